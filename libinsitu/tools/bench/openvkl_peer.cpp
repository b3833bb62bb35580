#include "openvkl_peer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <openvkl/openvkl.h>
#include <openvkl/version.h>
#include <stdexcept>
#include <string>

namespace insitu::bench {

namespace {

using math::Vec3d;

// Handles are pointers before 2.0, and objects that are passed by their address from then on.
#if OPENVKL_VERSION_MAJOR >= 2
void load() {
  vklInit();
}
void sample_many(VKLSampler& sampler, unsigned n, const vkl_vec3f* points, float* values) {
  vklComputeSampleN(&sampler, n, points, values);
}
#else
void load() {
  vklLoadModule("cpu_device");
}
void sample_many(VKLSampler& sampler, unsigned n, const vkl_vec3f* points, float* values) {
  vklComputeSampleN(sampler, n, points, values);
}
#endif

/// One for the program's life: devices start threads and load modules.
VKLDevice device() {
  static const VKLDevice made = [] {
    load();
    const VKLDevice d = vklNewDevice("cpu");
    vklDeviceSetInt(d, "numThreads", 1);
    vklCommitDevice(d);
    if (vklDeviceGetLastErrorCode(d) != VKL_NO_ERROR)
      throw std::runtime_error(std::string("Open VKL: ") + vklDeviceGetLastErrorMsg(d));
    return d;
  }();
  return made;
}

class OpenVklPeer : public Peer {
public:
  OpenVklPeer(const workload::Mesh& mesh, const std::vector<double>& field)
      : field_(field.begin(), field.end()),
        index_(mesh.connectivity.begin(), mesh.connectivity.end()) {
    points_.reserve(std::size_t(mesh.vertex_count()));
    for (std::int64_t v = 0; v < mesh.vertex_count(); ++v) {
      const Vec3d p = mesh.point(v);
      points_.push_back({float(p.x), float(p.y), float(p.z)});
    }
    for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
      first_.push_back(std::uint32_t(mesh.ids(c) - mesh.connectivity.data()));
      types_.push_back(std::uint8_t(mesh.shape(c))); // VTK's numbers, as ours
    }
  }
  ~OpenVklPeer() override { release(); }
  OpenVklPeer(const OpenVklPeer&) = delete;
  OpenVklPeer& operator=(const OpenVklPeer&) = delete;

  const char* name() const override { return "OpenVKL"; }
  bool tells_cells() const override { return false; }

  void build() override {
    release();
    volume_ = vklNewVolume(device(), "unstructured");
    set("vertex.position", points_, VKL_VEC3F);
    set("vertex.data", field_, VKL_FLOAT);
    set("index", index_, VKL_UINT);
    set("cell.index", first_, VKL_UINT);
    set("cell.type", types_, VKL_UCHAR);
    vklSetBool(volume_, "hexIterative", 1);
    vklSetFloat(volume_, "background", std::numeric_limits<float>::quiet_NaN());
    vklCommit(volume_);
    sampler_ = vklNewSampler(volume_);
    vklCommit(sampler_);
    if (vklDeviceGetLastErrorCode(device()) != VKL_NO_ERROR)
      throw std::runtime_error(std::string("Open VKL: ") + vklDeviceGetLastErrorMsg(device()));
    built_ = true;
  }
  void locate(std::span<const Vec3d> points, std::span<std::int64_t> cells,
              std::span<Vec3d>) override {
    run(points, cells, nullptr);
  }
  void sample(std::span<const Vec3d> points, std::span<std::int64_t> cells,
              std::span<double> values) override {
    run(points, cells, values.data());
  }

private:
  template <class T>
  void set(const char* name, const std::vector<T>& items, VKLDataType type) {
    const VKLData data =
        vklNewData(device(), items.size(), type, items.data(), VKL_DATA_SHARED_BUFFER, 0);
    vklSetData(volume_, name, data);
    vklRelease(data);
  }
  void release() {
    if (built_) {
      vklRelease(sampler_);
      vklRelease(volume_);
    }
    built_ = false;
  }
  void run(std::span<const Vec3d> points, std::span<std::int64_t> cells, double* values) {
    constexpr std::size_t block = 1024; // what is converted stays in the first cache
    vkl_vec3f some[block];
    float found[block];
    for (std::size_t first = 0; first < points.size(); first += block) {
      const std::size_t n = std::min(block, points.size() - first);
      for (std::size_t i = 0; i < n; ++i) {
        const Vec3d& p = points[first + i];
        some[i] = {float(p.x), float(p.y), float(p.z)};
      }
      sample_many(sampler_, unsigned(n), some, found);
      for (std::size_t i = 0; i < n; ++i) {
        cells[first + i] = std::isnan(found[i]) ? -1 : 0;
        if (values)
          values[first + i] = std::isnan(found[i]) ? 0.0 : double(found[i]);
      }
    }
  }

  std::vector<vkl_vec3f> points_;
  std::vector<float> field_;
  std::vector<std::uint32_t> index_, first_;
  std::vector<std::uint8_t> types_;
  VKLVolume volume_{};
  VKLSampler sampler_{};
  bool built_ = false;
};

} // namespace

std::unique_ptr<Peer> make_openvkl(const workload::Mesh& mesh, const std::vector<double>& field) {
  return std::make_unique<OpenVklPeer>(mesh, field);
}

} // namespace insitu::bench
