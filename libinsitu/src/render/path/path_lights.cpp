#include "render/path/path_lights.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"
#include "render/path/phase_function.h"

namespace insitu::render {

namespace {

math::Vec3d unit(const math::Vec3d& v) {
  // Scaled first, so that no square overflows or vanishes.
  const double most = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  if (!(most > 0) || !std::isfinite(most))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "light: a direction of some finite length expected, (" + std::to_string(v.x) +
                          ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ") given");
  const math::Vec3d scaled = v / most;
  return scaled / std::sqrt(dot(scaled, scaled));
}

} // namespace

PathLights::PathLights(const std::vector<Light>& lights, const Camera& camera) {
  if (lights.empty())
    dome_ = {1, 1, 1};
  for (const Light& light : lights) {
    const Color irradiance = float(pi) * light.color;
    switch (light.kind) {
    case Light::Kind::dome:
      dome_ = dome_ + light.color;
      break;
    case Light::Kind::directional:
      small_.push_back({true, false, unit(light.vector), irradiance});
      break;
    case Light::Kind::point:
      small_.push_back({false, true, light.vector, irradiance});
      break;
    case Light::Kind::head:
      if (camera.orthographic_height > 0)
        small_.push_back({true, false, unit(camera.position - camera.look_at), irradiance});
      else
        small_.push_back({false, false, camera.position, irradiance});
      break;
    }
  }
}

LightSample PathLights::sample(const math::Vec3d& at, double u) const {
  const std::size_t count = small_.size();
  const Small& light = small_[std::min(std::size_t(u * double(count)), count - 1)];
  const Color irradiance = float(count) * light.irradiance;
  if (light.far)
    return {light.vector, HUGE_VAL, irradiance};
  const math::Vec3d to = light.vector - at;
  const double squared = dot(to, to), distance = std::sqrt(squared);
  if (!(distance > 0)) // at the very place of the light: a null set
    return {{0, 0, 1}, 0, {0, 0, 0}};
  return {to / distance, distance, light.fades ? float(1 / squared) * irradiance : irradiance};
}

} // namespace insitu::render
