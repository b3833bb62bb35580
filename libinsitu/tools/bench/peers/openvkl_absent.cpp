#include "peers/openvkl_parts.h"

namespace insitu::bench {

std::unique_ptr<Peer> make_openvkl(const workload::Mesh&, const std::vector<double>&) {
  return nullptr;
}

std::unique_ptr<OpenVklAmr> make_openvkl_amr(const workload::AmrMesh&, int) {
  return nullptr;
}

std::unique_ptr<OpenVklFrame> make_openvkl_frame(const workload::Mesh&, const std::vector<double>&,
                                                 const query::Sampler&,
                                                 const render::FrameSettings&) {
  return nullptr;
}

} // namespace insitu::bench
