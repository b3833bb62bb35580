#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "workload/mesh.h"

/// What needs VTK; vtk_absent.cpp stands in where it is not there.
namespace insitu::bench {

/// Throws UsageError if the file cannot be read or holds other cells than the five linear shapes.
workload::Mesh read_vtu(const std::string& file);

/// Another library's way to answer the same queries, on the calling thread.
class Peer {
public:
  virtual ~Peer() = default;
  virtual const char* name() const = 0;
  /// False: cells are only 0 (found) or -1, so a wrong one cannot be told.
  virtual bool tells_cells() const { return true; }
  /// Builds anew.
  virtual void build() = 0;
  /// Cells (-1: none) and parametric coordinates; empty: these are computed and dropped.
  virtual void locate(std::span<const math::Vec3d> points, std::span<std::int64_t> cells,
                      std::span<math::Vec3d> parametric = {}) = 0;
  /// The same, and the field.
  virtual void sample(std::span<const math::Vec3d> points, std::span<std::int64_t> cells,
                      std::span<double> values) = 0;
};

/// The peers, over the mesh's own arrays; none without VTK. names: only these; empty: all. Throws
/// UsageError for an unknown name.
std::vector<std::unique_ptr<Peer>> make_peers(const workload::Mesh& mesh,
                                              const std::vector<double>& field,
                                              const std::vector<std::string>& names = {});

} // namespace insitu::bench
