#include "scene/parse/parse_parts.h"

namespace insitu::scene {
namespace {

constexpr std::int64_t most_samples = 1'000'000;
constexpr std::int64_t most_bounces = 1'000'000;
/// The phase function of an anisotropy beyond is all peak.
constexpr double most_anisotropy = 0.999;

bool has(const std::vector<FrameEffect>& effects, FrameEffect effect) {
  return std::find(effects.begin(), effects.end(), effect) != effects.end();
}

PathTracing parse_map(const Cursor& cursor) {
  PathTracing paths;
  paths.line = cursor.line();
  const MapReader map(cursor, {"samples", "density", "anisotropy", "max_bounces",
                               "cells_per_macrocell", "seed", "dome_visible", "accumulate"});
  if (const auto samples = map.find("samples")) {
    if (const auto count = samples->integer(1, most_samples)) {
      paths.samples = static_cast<int>(*count);
    }
  }
  if (const auto density = map.find("density")) {
    assign(paths.density, density->number({0, 1e6}));
  }
  if (const auto anisotropy = map.find("anisotropy")) {
    assign(paths.anisotropy, anisotropy->number({-most_anisotropy, most_anisotropy}));
  }
  if (const auto bounces = map.find("max_bounces")) {
    if (const auto count = bounces->integer(1, most_bounces)) {
      paths.max_bounces = static_cast<int>(*count);
    }
  }
  if (const auto cells = map.find("cells_per_macrocell")) {
    assign(paths.cells_per_macrocell, cells->number({1, 1e9}));
  }
  if (const auto seed = map.find("seed")) {
    if (const auto number = seed->integer(0, std::numeric_limits<std::int64_t>::max())) {
      paths.seed = static_cast<std::uint64_t>(*number);
    }
  }
  if (const auto visible = map.find("dome_visible")) {
    assign(paths.shows_dome, visible->boolean());
  }
  if (const auto accumulate = map.find("accumulate")) {
    assign(paths.accumulate, accumulate->boolean());
  }
  return paths;
}

} // namespace

std::optional<PathTracing> parse_path_tracing(const MapReader& map, const Frame& frame) {
  const bool single = has(frame.effects, FrameEffect::single_scattering);
  const bool multiple = has(frame.effects, FrameEffect::multiple_scattering);
  const auto own = map.find("path_tracing");
  if (map && (single || multiple || own) &&
      std::none_of(frame.layers.begin(), frame.layers.end(),
                   [](const FrameLayer& layer) { return layer.volume.has_value(); })) {
    (own ? *own : map.cursor()).fail("path tracing needs a 'volume'");
  }
  if (single && multiple) {
    map.cursor().fail("'single_scattering' is part of 'multiple_scattering'; give one of them");
  }
  if (!own && !single && !multiple) {
    return std::nullopt;
  }
  PathTracing paths = own ? parse_map(*own) : PathTracing{};
  paths.scattering = multiple ? render::Scattering::multiple
                     : single ? render::Scattering::single
                              : render::Scattering::none;
  return paths;
}

} // namespace insitu::scene
