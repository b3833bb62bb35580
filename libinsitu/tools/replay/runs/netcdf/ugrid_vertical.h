#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "runs/netcdf/netcdf_file.h"
#include "runs/netcdf/ugrid_topology.h"

namespace insitu_replay {

/// What the dimensions of a UGRID file are to a variable, and its values by them.
struct UgridDims {
  const NetcdfFile& file;
  const UgridTopology& topology;
  int time_dim = -1;

  /// The dimensions that are neither time nor those of nodes and cells.
  std::vector<int> others(const NetcdfFile::Variable& v) const;
  bool has(const NetcdfFile::Variable& v, int dim) const;
  /// The values at a step, [levels][items]: levels of the dimension `level` (-1: one), items of
  /// the dimension `item` (-1: one). Dimensions that the variable lacks have one value for all of
  /// theirs.
  std::vector<double> values(const NetcdfFile::Variable& v, std::size_t step, int level,
                             int item) const;
};

/// The vertical coordinate of a layered mesh: heights, or a parametric coordinate of an ocean.
class UgridVertical {
public:
  /// Null if the file has no vertical coordinate that is known. has_node_data: whether there are
  /// values of nodes along a dimension. notes: of what is not understood.
  static std::unique_ptr<UgridVertical> find(const UgridDims& dims,
                                             const std::function<bool(int)>& has_node_data,
                                             std::vector<std::string>& notes);

  int layer_dim = -1;     ///< values along it are of layers; -1: the file has none
  int interface_dim = -1; ///< values along it are of what lies between the layers; -1: none
  std::size_t layers = 0;
  bool moves = false; ///< heights are others from step to step

  /// Heights of the layers + 1 interfaces at the nodes, [interface][node].
  std::vector<double> interfaces(const UgridDims& dims, std::size_t step) const;
  /// Heights at which values of layers are, [layer][node]; there is a layer_dim.
  std::vector<double> middles(const UgridDims& dims, std::size_t step) const;
  /// Whether the heights are those of a variable.
  bool is_coordinate(const NetcdfFile::Variable& v) const {
    return &v == layer_ || &v == interface_;
  }

private:
  using Variable = NetcdfFile::Variable;
  std::vector<double> heights(const UgridDims& dims, const Variable& v, std::size_t step) const;

  const Variable *layer_ = nullptr, *interface_ = nullptr;
  std::vector<double> bounds_; ///< of the layers, layers + 1 numbers of layer_
};

} // namespace insitu_replay
