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
  /// Which values are read.
  struct Slab {
    std::size_t step = 0;
    int level = -1; ///< the dimension of the levels; -1: one level
    int item = -1;  ///< the dimension of the items; -1: one
    int part = -1;  ///< a dimension of components, of which `component` alone is read
    std::size_t component = 0;
  };
  /// [levels][items]. Dimensions that the variable lacks have one value for all of theirs. Values
  /// of cells are averaged at nodes if these are the items.
  std::vector<double> values(const NetcdfFile::Variable& v, const Slab& slab) const;
};

/// The vertical coordinate of a layered mesh: heights, or a parametric coordinate of an ocean.
class UgridVertical {
public:
  /// Of which items a dimension has values.
  struct Along {
    bool nodes = false, cells = false;
  };
  /// Null if the file has no vertical coordinate that is known and along which there are values.
  /// notes: of what is not understood.
  static std::unique_ptr<UgridVertical> find(const UgridDims& dims,
                                             const std::function<Along(int)>& along,
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
