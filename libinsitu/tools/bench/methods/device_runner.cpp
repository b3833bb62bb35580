#include <cuda_runtime_api.h>
#include <stdexcept>

#include "accel/faces/mesh_faces.h"
#include "cells/checks/odd_cells.h"
#include "core/timer.h"
#include "methods/runner.h"
#include "query/device/device_locator.h"

namespace insitu::bench {

namespace {

void check(cudaError_t status, const char* what) {
  if (status != cudaSuccess)
    throw std::runtime_error(std::string(what) + ": " + cudaGetErrorString(status));
}

/// An array on the device.
template <class T>
class OnDevice {
public:
  OnDevice() = default;
  ~OnDevice() { cudaFree(data_); }
  OnDevice(const OnDevice&) = delete;
  OnDevice& operator=(const OnDevice&) = delete;
  void resize(std::size_t n) {
    if (n <= size_)
      return;
    cudaFree(data_);
    data_ = nullptr;
    check(cudaMalloc(reinterpret_cast<void**>(&data_), n * sizeof(T)), "device memory");
    size_ = n;
  }
  T* data() const { return data_; }

private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

class DeviceRunner final : public MethodRunner {
public:
  DeviceRunner(accel::Backend backend, accel::Method method, MethodMesh& mesh,
               core::Context& context)
      : backend_(backend), method_(method), context_(context), mesh_("bench", memory_),
        faces_(memory_) {
    mesh.register_with(mesh_);
    mesh_.update();
    const bool free = cells::find_odd_cells(mesh_.view(), context.threads).none();
    mesh_.set_free_of_folds(free);
    // As a committed mesh knows it: it looks for overlaps with ray methods alone.
    mesh_.set_covers_once(free && method != accel::Method::bvh);
    locator_ = query::make_device_locator(backend, method, memory_);
  }

  Sizes build(double& build_seconds) override {
    const auto host = [this]() -> const mesh::MeshView& { return mesh_.view(); };
    double faces_seconds = 0.0;
    if (uses_faces(method_)) {
      const core::Timer timer;
      faces_.build(mesh_.view(), context_.threads);
      faces_seconds = timer.seconds();
    }
    Sizes sizes;
    if (backend_ == accel::Backend::optix) {
      const auto whole =
          query::make_device_locator(backend_, method_, memory_, std::int64_t(1) << 40);
      whole->commit(mesh_, host, INSITU_CHANGED_ALL, &faces_, context_.threads);
      sizes.peak_whole = whole->report().ray_peak_bytes;
    }
    locator_->commit(mesh_, host, INSITU_CHANGED_ALL, &faces_, context_.threads);
    locator_->commit(mesh_, host, INSITU_CHANGED_ALL, &faces_,
                     context_.threads); // buffers are warm now
    const query::DeviceReport r = locator_->report();
    const bool by_rays = backend_ == accel::Backend::optix;
    build_seconds = by_rays ? faces_seconds + r.rays_seconds : r.tree_seconds;
    sizes.faces_s = faces_seconds;
    sizes.primitives = r.primitives;
    sizes.bytes = by_rays ? r.ray_bytes : r.tree_bytes;
    sizes.peak = by_rays ? r.ray_peak_bytes : r.tree_peak_bytes;
    return sizes;
  }

  double refit() override {
    const auto host = [this]() -> const mesh::MeshView& { return mesh_.view(); };
    locator_->commit(mesh_, host, INSITU_CHANGED_GEOMETRY, &faces_, context_.threads);
    const query::DeviceReport r = locator_->report();
    return backend_ == accel::Backend::optix ? r.rays_seconds : r.tree_seconds;
  }

  void set_points(std::span<const math::Vec3d> points) override {
    count_ = points.size();
    points_.resize(3 * count_);
    cells_.resize(count_);
    values_.resize(count_);
    check(cudaMemcpy(points_.data(), points.data(), count_ * sizeof(math::Vec3d),
                     cudaMemcpyHostToDevice),
          "copying points");
  }

  void answer(Wanted wanted, insitu_accuracy accuracy) override {
    query::DeviceQuery query;
    query.points = points_.data();
    query.count = std::int64_t(count_);
    query.on_device = true;
    query.accuracy = accuracy;
    double* const values = values_.data();
    const mesh::FieldView field = mesh_.field(wanted == Wanted::cell_value ? "c" : "f");
    if (wanted == Wanted::ids) {
      query.cells = cells_.data();
    } else {
      query.fields = std::span(&field, 1);
      query.values = &values;
    }
    const query::DeviceCounts counts = locator_->locate(query);
    ways_ = {counts.candidates_kept, 0, counts.by_tree, counts.settled_on_host};
    check(cudaDeviceSynchronize(), "locating");
  }

  Ways ways() const override { return ways_; }

  void ids(std::vector<std::int64_t>& out) override {
    out.resize(count_);
    check(cudaMemcpy(out.data(), cells_.data(), count_ * sizeof(std::int64_t),
                     cudaMemcpyDeviceToHost),
          "copying ids");
  }

private:
  accel::Backend backend_;
  accel::Method method_;
  core::Context& context_;
  core::Memory memory_;
  mesh::Mesh mesh_;
  accel::MeshFaces faces_;
  std::unique_ptr<query::DeviceLocator> locator_;
  std::size_t count_ = 0;
  Ways ways_;
  OnDevice<double> points_, values_;
  OnDevice<std::int64_t> cells_;
};

} // namespace

std::unique_ptr<MethodRunner> make_device_runner(accel::Backend backend, accel::Method method,
                                                 MethodMesh& mesh, core::Context& context) {
  return std::make_unique<DeviceRunner>(backend, method, mesh, context);
}

std::string device_name() {
  cudaDeviceProp p;
  int driver = 0;
  if (cudaGetDeviceProperties(&p, 0) != cudaSuccess || cudaDriverGetVersion(&driver) != cudaSuccess)
    return "";
  return std::string(p.name) + ", CUDA driver " + std::to_string(driver / 1000) + "." +
         std::to_string(driver % 1000 / 10);
}

} // namespace insitu::bench
