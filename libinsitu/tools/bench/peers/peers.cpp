#include "peers/peers.h"

#include <algorithm>

#include "peers/openvkl_parts.h"
#include "options.h"
#include "peers/vtk_parts.h"

namespace insitu::bench {

Peers make_peers(const workload::Mesh& mesh, const std::vector<double>& field,
                 const std::vector<std::string>& names) {
  Peers all = make_vtk_peers(mesh, field);
  if (auto peer = make_openvkl(mesh, field))
    all.push_back(std::move(peer));
  if (names.empty() || all.empty())
    return all;
  std::string known;
  for (const auto& peer : all)
    known += std::string(known.empty() ? "" : ", ") + peer->name();
  Peers wanted;
  for (const std::string& name : names) {
    const auto at = std::find_if(all.begin(), all.end(),
                                 [&](const auto& peer) { return peer && peer->name() == name; });
    if (at == all.end())
      throw UsageError("--peer " + name + ": one of " + known +
                       " expected in this build, once each");
    wanted.push_back(std::move(*at));
  }
  return wanted;
}

} // namespace insitu::bench
