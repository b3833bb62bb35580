#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "node.h"

namespace insitu::blueprint {

struct Domain;

/// A window of Blueprint's nestsets, in which a domain meets a coarser or a finer one. Where the
/// window lies is not read: the domains' places tell it.
struct NestWindow {
  std::string path;
  std::optional<std::int64_t> partner; ///< the other domain's id
  bool is_to_parent = false;           ///< the other domain is the coarser one
  std::int64_t ratio = 0;              ///< how many finer cells a coarser one has along each axis
};

/// The windows of a domain's nestsets of that topology that have a ratio. Throws Error, by the
/// path.
std::vector<NestWindow> read_nestsets(const Node& mesh, const std::string& topology,
                                      int dimensions);

struct ToldRatio {
  std::int64_t ratio;
  std::string path; ///< of the window
};
/// By the coarser and the finer level.
using ToldRatios = std::map<std::pair<std::int64_t, std::int64_t>, ToldRatio>;

/// What the windows of all domains tell. The other domain's level is known where that domain is
/// here; otherwise it is the next one. Throws Error where windows tell different things.
ToldRatios ratios_of_nestsets(const std::vector<Domain>& domains);

/// Refuses windows whose ratio is another than that of the levels. ratios: as of insitu_amr.
void check_ratios(const ToldRatios& told, const std::vector<std::int32_t>& ratios);

} // namespace insitu::blueprint
