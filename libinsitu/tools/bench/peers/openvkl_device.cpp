#include "peers/openvkl_device.h"

#include <limits>
#include <stdexcept>
#include <string>

namespace insitu::bench {

namespace {

void throw_error_of(VKLDevice device) {
  if (vklDeviceGetLastErrorCode(device) != VKL_NO_ERROR)
    throw std::runtime_error(std::string("Open VKL: ") + vklDeviceGetLastErrorMsg(device));
}

} // namespace

VKLDevice openvkl_device(int threads) {
  static const VKLDevice made = [&] {
#if OPENVKL_VERSION_MAJOR >= 2
    vklInit();
#else
    vklLoadModule("cpu_device");
#endif
    const VKLDevice device = vklNewDevice("cpu");
    vklDeviceSetInt(device, "numThreads", threads);
    vklCommitDevice(device);
    throw_error_of(device);
    return device;
  }();
  return made;
}

void throw_openvkl_error() {
  throw_error_of(openvkl_device());
}

OpenVklMesh::OpenVklMesh(const workload::Mesh& mesh, const std::vector<double>& field)
    : field_(field.begin(), field.end()),
      index_(mesh.connectivity.begin(), mesh.connectivity.end()) {
  points_.reserve(std::size_t(mesh.vertex_count()));
  for (std::int64_t v = 0; v < mesh.vertex_count(); ++v) {
    const math::Vec3d p = mesh.point(v);
    points_.push_back({float(p.x), float(p.y), float(p.z)});
  }
  for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
    first_.push_back(std::uint32_t(mesh.ids(c) - mesh.connectivity.data()));
    types_.push_back(std::uint8_t(mesh.shape(c))); // VTK's numbers, as ours
  }
}

void OpenVklMesh::build() {
  sampler_.reset();
  volume_ = OpenVkl<VKLVolume>(vklNewVolume(openvkl_device(), "unstructured"));
  set_shared(*volume_, "vertex.position", points_, VKL_VEC3F);
  set_shared(*volume_, "vertex.data", field_, VKL_FLOAT);
  set_shared(*volume_, "index", index_, VKL_UINT);
  set_shared(*volume_, "cell.index", first_, VKL_UINT);
  set_shared(*volume_, "cell.type", types_, VKL_UCHAR);
  vklSetBool(*volume_, "hexIterative", 1);
  vklSetFloat(*volume_, "background", std::numeric_limits<float>::quiet_NaN());
  vklCommit(*volume_);
  sampler_ = OpenVkl<VKLSampler>(vklNewSampler(*volume_));
  vklCommit(*sampler_);
  throw_openvkl_error();
}

} // namespace insitu::bench
