#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "accel/locator.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/registered/mesh.h"

namespace insitu::accel {
class MeshFaces;
}
namespace insitu::accel::cuda {
class DeviceTree;
}
namespace insitu::device {
class DeviceMesh;
}

namespace insitu::query {

/// Where queries are answered for the whole batch at once, on a device. Points and outputs lie in
/// host memory, or all in device memory; then the work is queued on the stream. `fast` waits for
/// nothing; `exact` and `standard` wait for the stream, to learn which points are left undecided,
/// and queue what follows for those: answers are there once the stream has been waited for.
struct DeviceQuery {
  const double* points = nullptr; ///< [count][3]
  std::int64_t count = 0;
  bool on_device = false;
  insitu_accuracy accuracy = INSITU_STANDARD;
  void* stream = nullptr; ///< cudaStream_t; null: the default stream

  // Outputs, each [count] or null.
  std::int64_t* cells = nullptr; ///< flat ids, -1 outside
  double* parametric = nullptr;  ///< [count][3]; NaN outside
  std::uint8_t* reasons = nullptr;
  // What callers see instead of flat ids, where asked for:
  bool by_piece = false;      ///< cells count within their piece
  std::int64_t cell_base = 0; ///< added to cells, outside too
  std::int32_t* pieces = nullptr;
  std::uint8_t* found = nullptr;
  /// One field a span item: values[f] is [count][components], NaN outside.
  std::span<const mesh::FieldView> fields = {};
  double* const* values = nullptr; ///< a host array of pointers
};

/// How a query was decided; nothing is counted in `fast`, which decides nothing.
struct DeviceCounts {
  std::int64_t candidates_kept = 0; ///< the ray's candidate was certified and answered alone
  std::int64_t by_tree = 0;         ///< went through the device's tree
  std::int64_t settled_on_host = 0; ///< undecided there: exact arithmetic on the host
};

struct DeviceReport {
  std::int64_t bytes = 0;        ///< device memory of the structures and copies, held
  std::int64_t peak_bytes = 0;   ///< the most during the last build
  std::int64_t bytes_copied = 0; ///< of the solver's host arrays that have a copy on the device
  std::int64_t primitives = 0;   ///< cells of the tree, or of rays: triangles or cells
  // Of the structures alone, without the mesh's copies:
  std::int64_t tree_bytes = 0, tree_peak_bytes = 0;
  std::int64_t ray_bytes = 0, ray_peak_bytes = 0; ///< with triangles
  std::int64_t ray_groups = 0;                    ///< of a two-level structure; 1: one level
  double tree_seconds = 0.0, rays_seconds = 0.0;  ///< of the last build or refit, on the device
};

/// What a device holds of a mesh.
struct DeviceStructures {
  const device::DeviceMesh& mesh;
  const accel::cuda::DeviceTree& tree;
};

/// The mesh as the host can read it: its own view, or a mesh::HostMirror's.
using HostView = core::FunctionRef<const mesh::MeshView&()>;

/// Beside INSITU_CHANGED_* in what a commit is told: the vertices moved so far that structures over
/// the same cells are to be built anew, not refitted.
inline constexpr std::uint32_t rebuild_due = 1u << 16;

/// Locates points in a mesh on a device, with its structures: the `bvh` method in CUDA, or a ray
/// method in OptiX beside it.
class DeviceLocator {
public:
  virtual ~DeviceLocator() = default;
  /// Brings arrays and structures up to date. what: INSITU_CHANGED_*, topology at first, and
  /// rebuild_due. faces: as in accel::RayLocator::build. Arrays in device memory are read in place,
  /// others copied. Throws core::Error.
  /// host: asked for when faces or triangles are made, by methods that use faces.
  virtual void commit(const mesh::Mesh& mesh, HostView host, std::uint32_t what,
                      const accel::MeshFaces* faces, const core::Threads& threads) = 0;
  /// The answers of query::Sampler on the same mesh; `fast` answers by the papers' rules in float.
  virtual DeviceCounts locate(const DeviceQuery& query) const = 0;
  /// Calls use(structures) while the locator does nothing else. Work that `use` queues is done
  /// before the next commit changes them. Throws INSITU_ERROR_ORDER before the first commit.
  virtual void
  use_structures(core::FunctionRef<void(const DeviceStructures& structures)> use) const = 0;
  virtual DeviceReport report() const = 0;
};

/// Empty if the backend can be used here, else why not ("no CUDA device: ...", "driver too old for
/// this OptiX (ABI 105)", "built without CUDA").
std::string why_unavailable(accel::Backend backend);

/// Throws INSITU_ERROR_UNSUPPORTED with why_unavailable(). group: as in accel::make_embree_locator.
std::unique_ptr<DeviceLocator> make_device_locator(accel::Backend backend, accel::Method method,
                                                   core::Memory& memory,
                                                   std::int64_t group = std::int64_t(1) << 20);

} // namespace insitu::query
