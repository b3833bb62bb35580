#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "workload/mesh.h"

namespace insitu::bench {

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

using Peers = std::vector<std::unique_ptr<Peer>>;

/// Those that this build has: VTK's, over the mesh's own arrays, and Open VKL. names: only these;
/// empty: all. Throws UsageError for a name that is none's, in a build that has some.
Peers make_peers(const workload::Mesh& mesh, const std::vector<double>& field,
                 const std::vector<std::string>& names = {});

} // namespace insitu::bench
