#pragma once

#include <optional>
#include <vector>

#include "render/camera/camera.h"
#include "render/light.h"

namespace insitu::render {

/// Light that a point gets along one direction.
struct LightSample {
  math::Vec3d direction; ///< towards the light, of unit length
  double distance = 0;   ///< to it; infinite for light from afar
  Color irradiance;      ///< on a surface that faces it, unattenuated
};

/// The lights of a medium. A light of colour c has the irradiance pi c (a point light at distance
/// 1), so that a white surface that faces it would have the radiance c: as bright as Lighting
/// shades surfaces, and in keeping with domes, whose colour is their radiance. A headlight stands
/// at a perspective camera, without falling off, and shines along an orthographic one.
class PathLights {
public:
  /// lights empty: a white dome. Throws core::Error (INSITU_ERROR_ARGUMENT) for a directional light
  /// without a direction.
  PathLights(const std::vector<Light>& lights, const Camera& camera);

  /// The radiance from any direction.
  const Color& dome() const { return dome_; }
  bool has_dome() const { return dome_.r > 0 || dome_.g > 0 || dome_.b > 0; }

  /// Whether there are others, which no path meets by chance.
  bool has_small() const { return !small_.empty(); }
  /// One of them, picked by u in [0, 1), its irradiance times their number.
  LightSample sample(const math::Vec3d& at, double u) const;

private:
  struct Small {
    bool far = false;   ///< vector is its direction, or else its place
    bool fades = false; ///< with the square of the distance
    math::Vec3d vector;
    Color irradiance;
  };
  Color dome_{0, 0, 0};
  std::vector<Small> small_;
};

} // namespace insitu::render
