#pragma once

#include <memory>
#include <vector>

#include "peers.h"

namespace insitu::bench {

/// Open VKL's unstructured volume on one thread, hexahedra by Newton's method (hexIterative),
/// sampled 1024 points a call; float, as it has it. It names no
/// cells and gives no parametric coordinates. Null in a build without -DINSITU_BENCH_OPENVKL=ON.
std::unique_ptr<Peer> make_openvkl(const workload::Mesh& mesh, const std::vector<double>& field);

} // namespace insitu::bench
