#include "nestsets.h"

#include <algorithm>

#include "attachment.h"

namespace insitu::blueprint {

namespace {

constexpr const char* counts[3] = {"i", "j", "k"};

/// The ratio of a window, along all axes; 0: the window has none.
std::int64_t ratio_of(const Node& window, int dimensions) {
  const Node ratios = window.find("ratio");
  if (!ratios)
    return 0;
  const std::int64_t first = ratios.at("i").integer();
  for (int a = 0; a < dimensions; ++a) {
    const Node along = ratios.at(counts[a]);
    const std::int64_t ratio = along.integer();
    if (ratio < 2 || ratio > (1 << 30) || (ratio & (ratio - 1)) != 0)
      along.refuse(INSITU_ERROR_UNSUPPORTED, "is " + std::to_string(ratio) +
                                                 "; a half or a quarter a level is supported, by "
                                                 "ratios of 2 or 4");
    if (ratio != first)
      along.refuse(INSITU_ERROR_UNSUPPORTED, "is " + std::to_string(ratio) + ", and along i " +
                                                 std::to_string(first) +
                                                 "; one ratio along all axes is supported");
  }
  return first;
}

/// The levels between which a window's ratio lies, the coarser one first.
std::pair<std::int64_t, std::int64_t> levels_of(const NestWindow& window, const Domain& domain,
                                                const std::vector<Domain>& domains) {
  std::int64_t other = domain.level + (window.is_to_parent ? -1 : 1);
  for (const Domain& d : domains) // ids of other processes' domains, and wrong ones, tell no level
    if (d.id && window.partner && *d.id == *window.partner &&
        (window.is_to_parent ? d.level < domain.level : d.level > domain.level))
      other = d.level;
  if (other < 0)
    throw Error(INSITU_ERROR_ARGUMENT, window.path + "/domain_type is parent, and " + domain.path +
                                           " is of level 0, the coarsest");
  return std::minmax(domain.level, other);
}

} // namespace

std::vector<NestWindow> read_nestsets(const Node& mesh, const std::string& topology,
                                      int dimensions) {
  std::vector<NestWindow> out;
  const Node sets = mesh.find("nestsets");
  for (std::int64_t s = 0; s < sets.size(); ++s) {
    const Node of = sets.child(s).find("topology");
    if (of && of.is_text() && of.text() != topology)
      continue;
    const Node windows = sets.child(s).find("windows");
    for (std::int64_t w = 0; w < windows.size(); ++w) {
      const Node window = windows.child(w);
      const Node type = window.at("domain_type");
      const std::string partner = type.text();
      if (partner != "parent" && partner != "child")
        type.refuse(INSITU_ERROR_ARGUMENT, "is '" + partner + "'; parent or child is needed");
      NestWindow read;
      read.path = window.path();
      read.is_to_parent = partner == "parent";
      read.ratio = ratio_of(window, dimensions);
      if (const Node id = window.find("domain_id"))
        read.partner = id.integer();
      if (read.ratio > 0)
        out.push_back(std::move(read));
    }
  }
  return out;
}

ToldRatios ratios_of_nestsets(const std::vector<Domain>& domains) {
  ToldRatios out;
  for (const Domain& domain : domains)
    for (const NestWindow& window : domain.windows) {
      const auto levels = levels_of(window, domain, domains);
      if (levels.second == levels.first + 1 && window.ratio > 4)
        throw Error(INSITU_ERROR_UNSUPPORTED, window.path + "/ratio/i is " +
                                                  std::to_string(window.ratio) +
                                                  "; from level to level 2 and 4 are supported");
      const auto [known, fresh] = out.try_emplace(levels, ToldRatio{window.ratio, window.path});
      if (known->second.ratio != window.ratio)
        throw Error(INSITU_ERROR_ARGUMENT, window.path + "/ratio/i is " +
                                               std::to_string(window.ratio) + ", and " +
                                               known->second.path +
                                               "/ratio/i between the same "
                                               "levels is " +
                                               std::to_string(known->second.ratio));
    }
  return out;
}

void check_ratios(const ToldRatios& told, const std::vector<std::int32_t>& ratios) {
  for (const auto& [levels, by] : told) {
    const auto [coarse, fine] = levels;
    if (fine > std::int64_t(ratios.size()))
      continue; // no domain of the finer level is here
    std::int64_t ratio = 1;
    for (std::int64_t l = coarse; l < fine; ++l)
      ratio *= ratios[static_cast<std::size_t>(l)];
    if (ratio != by.ratio)
      throw Error(INSITU_ERROR_ARGUMENT,
                  by.path + "/ratio/i is " + std::to_string(by.ratio) + ", and the spacings of " +
                      "level " + std::to_string(coarse) + " and level " + std::to_string(fine) +
                      " make it " + std::to_string(ratio));
  }
}

} // namespace insitu::blueprint
