#include "query/device/optix/locator.h"

#include <algorithm>
#include <mutex>

#include "accel/cuda/device_tree.h"
#include "accel/faces/mesh_faces.h"
#include "accel/optix/context.h"
#include "accel/optix/kernels.h"
#include "accel/optix/structure.h"
#include "core/status.h"
#include "core/timer.h"
#include "query/device/caller_ids.h"
#include "query/device/locate.h"
#include "query/device/optix/launch_streams.h"
#include "query/device/optix/pipeline.h"

namespace insitu::query {

using accel::Backend;
using accel::Box;
using accel::FaceTriangle;
using accel::MeshFaces;
using accel::Method;
using accel::uses_faces;

namespace optix {
namespace {

using accel::optix::Context;
using accel::optix::fill_cell_boxes;
using accel::optix::longest_distance;
using accel::optix::Primitives;
using accel::optix::quads_turned;
using accel::optix::Structure;

constexpr float vanishing = 1e-10f;         ///< the length of rays that ask boxes
constexpr std::int64_t most_rays = 1 << 30; ///< of a launch

class OptixLocator final : public DeviceLocator {
public:
  OptixLocator(Method method, core::Memory& memory, std::int64_t group);

  void commit(const mesh::Mesh& mesh, HostView host, std::uint32_t what, const MeshFaces* faces,
              const core::Threads& threads) override;
  DeviceCounts locate(const DeviceQuery& query) const override;
  void use_structures(core::FunctionRef<void(const DeviceStructures&)> use) const override {
    std::lock_guard lock(mutex_);
    require_committed();
    use({mesh_, tree_});
  }
  DeviceReport report() const override;

private:
  void require_committed() const {
    if (!committed_)
      throw core::Error(INSITU_ERROR_ORDER,
                        std::string("locator ") + name(method_) + " on optix: not committed");
  }
  void commit_rays(HostView host, bool rebuild, const MeshFaces* faces,
                   const core::Threads& threads);
  void upload_triangles(HostView host, const MeshFaces& faces, const core::Threads& threads);
  Launch launch_of(Ask ask) const;
  const Pipeline& pipeline_of(const Launch& launch) const;
  void run(const Launch& launch, device::StreamHandle stream) const;
  void answer_fast(const DeviceQuery& query) const;
  DeviceCounts answer(const DeviceQuery& query) const;

  const Method method_;
  core::Memory* memory_;
  device::Stream stream_;
  device::DeviceMesh mesh_;
  accel::cuda::DeviceTree tree_;
  device::Buffer<FaceTriangle> triangles_;
  device::Buffer<std::uint32_t> scratch_;
  Structure rays_;
  float length_ = vanishing;
  bool committed_ = false;
  double tree_seconds_ = 0.0, rays_seconds_ = 0.0;
  std::int64_t peak_bytes_ = 0;
  const core::Threads* threads_ = nullptr; ///< of the last commit: settle points on the host
  const math::Vec3f* vertices_ = nullptr;
  // Of queries, one at a time.
  mutable std::mutex mutex_;
  mutable on_device::Workspace workspace_;
  mutable device::Buffer<std::uint32_t> candidates_;
  mutable LaunchStreams streams_;
};

OptixLocator::OptixLocator(Method method, core::Memory& memory, std::int64_t group)
    : method_(method), memory_(&memory), mesh_(memory), tree_(memory), triangles_(memory),
      scratch_(memory), rays_(memory, group), workspace_(memory), candidates_(memory),
      streams_(memory) {
  Context::get();
}

void OptixLocator::commit(const mesh::Mesh& mesh, HostView host, std::uint32_t what,
                          const MeshFaces* faces, const core::Threads& threads) {
  if (uses_faces(method_) && !faces)
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("locator ") + name(method_) + " needs the mesh's faces");
  std::lock_guard lock(mutex_);
  // Queries and tracers that were queued still read what changes; the solver may still write it.
  device::wait_for_all("waiting for the device");
  const bool anew = !committed_ || (what & INSITU_CHANGED_TOPOLOGY);
  const bool rebuild = anew || (what & rebuild_due);
  const bool moved = rebuild || (what & INSITU_CHANGED_GEOMETRY);
  threads_ = &threads;
  committed_ = false;
  mesh_.commit(mesh, anew ? std::uint32_t(INSITU_CHANGED_ALL) : what, stream_.get());
  if (moved) {
    const core::Timer timer;
    if (rebuild)
      tree_.build(mesh_, stream_.get());
    else
      tree_.refit(mesh_, stream_.get());
    tree_seconds_ = timer.seconds();
    commit_rays(host, rebuild, faces, threads);
    pipeline_of(launch_of(Ask::candidates)); // compiled now, not within the first query
  }
  committed_ = true;
}

void OptixLocator::commit_rays(HostView host, bool rebuild, const MeshFaces* faces,
                               const core::Threads& threads) {
  Primitives primitives;
  const auto fill = [&](Box* boxes, std::int64_t first, std::int64_t n) {
    fill_cell_boxes(mesh_.view(), mesh_.origin(), tree_.view().cells, first, n, boxes,
                    stream_.get());
  };
  const Primitives::FillBoxes fill_boxes(fill);
  if (uses_faces(method_)) {
    primitives.vertices = mesh_.vertices(stream_.get());
    vertices_ = reinterpret_cast<const math::Vec3f*>(primitives.vertices);
    // Faces keep their halves when vertices move; what bounds a patch may turn.
    if (!rebuild && method_ == Method::shared_bilinear_faces)
      rebuild = quads_turned(triangles_.data(), std::int64_t(triangles_.size()),
                             primitives.vertices, scratch_, stream_.get());
    if (rebuild)
      upload_triangles(host, *faces, threads);
    primitives.vertex_count = mesh_.vertex_count();
    primitives.triangles = triangles_.data();
    primitives.count = std::int64_t(triangles_.size());
    length_ = longest_distance(mesh_.view(), tree_.view().cells, tree_.cell_count(), scratch_,
                               stream_.get()) *
              1.0001f; // the ray's own rounding
  } else {
    primitives.boxes = &fill_boxes;
    primitives.count = tree_.cell_count();
  }
  const core::Timer timer;
  if (rebuild) {
    const std::int64_t others = mesh_.bytes() + tree_.bytes() + triangles_.bytes();
    rays_.build(primitives, stream_.get());
    peak_bytes_ = others + rays_.peak_bytes();
  } else {
    rays_.refit(primitives, stream_.get());
  }
  rays_seconds_ = timer.seconds();
}

/// The triangles of the coordinates as they are.
void OptixLocator::upload_triangles(HostView host, const MeshFaces& faces,
                                    const core::Threads& threads) {
  core::Buffer<FaceTriangle> fresh(*memory_, INSITU_MEMORY_BUILD);
  faces.triangles(host(), threads, method_, fresh);
  if (fresh.size() >= hit_back)
    throw core::Error(INSITU_ERROR_MESH, std::string("locator ") + name(method_) + ": " +
                                             std::to_string(fresh.size()) +
                                             " triangles, at most 2147483647");
  triangles_.release(); // or both lists would be held at once
  triangles_.resize_discard(fresh.size());
  device::copy_to_device(triangles_.data(), fresh.data(), fresh.size() * sizeof(FaceTriangle),
                         stream_.get(), "copying triangles");
  stream_.wait("copying triangles");
}

Launch OptixLocator::launch_of(Ask ask) const {
  Launch launch{};
  launch.method = std::uint32_t(method_);
  launch.ask = std::uint32_t(ask);
  launch.length = length_;
  launch.tree = rays_.handle();
  launch.origin = mesh_.origin();
  launch.triangles = triangles_.data();
  launch.vertices = vertices_;
  launch.owners = tree_.view().cells;
  launch.query.in.mesh = mesh_.in_kernels();
  // Programs that look into no cell are the same for all shapes.
  const bool looks = method_ == Method::user_geometry || ask == Ask::interpolated ||
                     (method_ == Method::replicated_faces && ask != Ask::candidates);
  launch.shape = std::uint32_t(looks ? launch.query.in.mesh.shape : mesh::Shape::none);
  return launch;
}

const Pipeline& OptixLocator::pipeline_of(const Launch& launch) const {
  return Pipeline::get({method_, Ask(launch.ask), mesh::Shape(launch.shape), rays_.two_level()});
}

void OptixLocator::run(const Launch& launch, device::StreamHandle stream) const {
  pipeline_of(launch).launch(streams_.put(launch, stream), launch.query.count, stream);
  streams_.launched(stream);
}

/// Points and outputs on the device: one launch does all, and nothing waits.
void OptixLocator::answer_fast(const DeviceQuery& query) const {
  const auto stream = static_cast<device::StreamHandle>(query.stream);
  const std::size_t field_count = query.fields.size();
  for (std::size_t at = 0; at == 0 || at < field_count; at += on_device::most_fields) {
    const auto fields =
        query.fields.subspan(at, std::min<std::size_t>(on_device::most_fields, field_count - at));
    bool interpolates = at == 0 && query.parametric != nullptr;
    for (const mesh::FieldView& field : fields)
      interpolates |= field.association == INSITU_VERTEX;
    Launch launch = launch_of(interpolates     ? Ask::interpolated
                              : fields.empty() ? Ask::cells
                                               : Ask::cell_values);
    on_device::Outputs& out = launch.query.out;
    out.fields = mesh_.fields(fields, stream);
    out.field_count = int(fields.size());
    out.needs_map = interpolates;
    for (std::int64_t first = 0; first < query.count; first += most_rays) {
      launch.query.points = query.points + 3 * first;
      launch.query.count = std::uint32_t(std::min(most_rays, query.count - first));
      if (at == 0) {
        out.cells = query.cells ? query.cells + first : nullptr;
        out.parametric = query.parametric ? query.parametric + 3 * first : nullptr;
        out.reasons = query.reasons ? query.reasons + first : nullptr;
      }
      for (std::size_t f = 0; f < fields.size(); ++f)
        out.values[f] = query.values[at + f] + first * fields[f].components;
      run(launch, stream);
    }
  }
}

DeviceCounts OptixLocator::locate(const DeviceQuery& asked) const {
  std::lock_guard lock(mutex_);
  require_committed();
  if (asked.count == 0)
    return {};
  on_device::CallerIds ids(mesh_, asked);
  const DeviceCounts counts = answer(ids.flat());
  ids.finish();
  if (asked.on_device)
    streams_.launched(static_cast<device::StreamHandle>(asked.stream)); // with what the ids took
  return counts;
}

DeviceCounts OptixLocator::answer(const DeviceQuery& query) const {
  const bool fast = query.accuracy == INSITU_FAST;
  if (fast && query.on_device) {
    answer_fast(query);
    return {};
  }
  const auto find = [&](const double* points, std::uint32_t count, device::StreamHandle stream) {
    const bool shares = !fast && uses_faces(method_) && method_ != Method::replicated_faces;
    candidates_.resize_discard(std::size_t(count) * (shares ? 2 : 1));
    Launch launch = launch_of(fast ? Ask::cells : Ask::candidates);
    launch.query.points = points;
    launch.query.count = count;
    launch.candidates = candidates_.data();
    launch.others = shares ? candidates_.data() + count : nullptr;
    run(launch, stream);
    return on_device::Candidates{launch.candidates, launch.others};
  };
  const on_device::CandidatesOf candidates(find);
  return on_device::locate_points(mesh_, &tree_, workspace_, *threads_, query, &candidates);
}

DeviceReport OptixLocator::report() const {
  DeviceReport r;
  r.bytes = mesh_.bytes() + tree_.bytes() + tree_.scratch_bytes() + triangles_.bytes() +
            scratch_.bytes() + rays_.bytes() + workspace_.device_bytes() + candidates_.bytes() +
            streams_.bytes();
  r.peak_bytes = std::max(r.bytes, peak_bytes_);
  r.bytes_copied = mesh_.bytes_copied();
  r.primitives = rays_.count();
  r.tree_bytes = tree_.bytes();
  r.tree_peak_bytes = tree_.bytes() + tree_.scratch_bytes();
  r.ray_groups = rays_.group_count();
  r.ray_bytes = rays_.bytes() + triangles_.bytes();
  r.ray_peak_bytes = rays_.peak_bytes() + triangles_.bytes();
  r.tree_seconds = tree_seconds_;
  r.rays_seconds = rays_seconds_;
  return r;
}

} // namespace
} // namespace optix

std::unique_ptr<DeviceLocator> make_optix_locator(Method method, core::Memory& memory,
                                                  std::int64_t group) {
  if (!has(Backend::optix, method))
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      std::string("backend optix has no method ") + name(method));
  return std::make_unique<optix::OptixLocator>(method, memory, group);
}

std::string why_no_optix() {
  return accel::optix::Context::why_unavailable();
}

} // namespace insitu::query
