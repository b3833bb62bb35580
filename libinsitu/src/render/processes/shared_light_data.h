#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "render/processes/shared_light.h"
#include "render/processes/tile_data.h"

/// What is sent about rays of light, and how both sides number them.
namespace insitu::render {

struct SentPoint {
  math::Vec3d position, normal;
  double clearance;
  std::uint64_t seed;
  std::int64_t cell; ///< of the receiver; -1: none
  std::int32_t surface;
  std::int32_t none = 0;
};
static_assert(sizeof(SentPoint) == std::size_t(bytes_a_light_point));

static_assert(sizeof(SentMeeting) == std::size_t(bytes_a_light_hit));

struct SentShadowSample {
  std::int64_t key;
  std::int32_t index;
  float opacity;
};
static_assert(sizeof(SentShadowSample) == std::size_t(bytes_a_shadow_sample));

constexpr std::uint32_t ray_ends = ~std::uint32_t(0); ///< in place of how many hits there are

/// The rays of some points, point by point in the order of Shader::send().
struct SharedLight::Rays {
  struct One {
    Ray ray;
    double t_max;
    std::uint32_t point;
  };
  std::vector<One> all;
  std::vector<std::uint32_t> first;                ///< by point, and behind the last
  std::vector<std::vector<std::uint32_t>> streams; ///< rays that are near to each other, in order

  Rays(const Shader& shader, std::size_t points,
       core::FunctionRef<const SurfacePoint&(std::size_t)> point, SurfaceCounts& counts)
      : streams(std::size_t(shader.streams())) {
    for (std::size_t i = 0; i < points; ++i) {
      const SurfacePoint& at = point(i);
      first.push_back(std::uint32_t(all.size()));
      shader.send(
          at,
          [&](int stream, const math::Vec3d& direction, double t_max) {
            streams[std::size_t(stream)].push_back(std::uint32_t(all.size()));
            all.push_back({{at.start(), direction}, t_max, std::uint32_t(i)});
          },
          counts);
    }
    first.push_back(std::uint32_t(all.size()));
  }
  /// Rays that are given, one a point.
  explicit Rays(std::vector<One> rays) : all(std::move(rays)), streams(1) {
    for (std::uint32_t i = 0; i <= all.size(); ++i)
      first.push_back(i);
    streams[0].assign(first.begin(), first.end() - 1);
  }
};

} // namespace insitu::render
