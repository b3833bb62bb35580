#pragma once

#include <vector>

#include "math/vec.h"
#include "render/color/color.h"

namespace insitu::render {

/// What sheds light on a scene. head: from the viewer; directional: parallel light from afar;
/// point: falling off with the square of the distance; dome: the same from every direction.
struct Light {
  enum class Kind { head, directional, point, dome };
  Kind kind = Kind::head;
  math::Vec3d vector{0, 0,
                     1}; ///< directional: towards the light, of any length; point: where it is
  /// Linear, may exceed 1. directional: irradiance on a surface that faces it; point: the same at
  /// distance 1; dome: radiance; head: irradiance everywhere.
  Color color{1, 1, 1};
};

/// How surfaces, and volumes that ask for it, are lit: color * (ambient * open + diffuse * sum over
/// lights of light * visible * cosine), by the side that is seen: lights behind it do not count,
/// and both sides look the same under the same light. Without shadows and occlusion all is open and
/// visible.
struct Lighting {
  bool enabled = true; ///< false: everything keeps its plain colours
  double ambient = 0.3;
  double diffuse = 0.7;
  std::vector<Light> lights; ///< none: a single white headlight
  bool shadows = false;
  /// A volume and surfaces cast shadows on each other too; with `shadows`.
  bool volume_shadows = false;
  int occlusion_samples = 0;     ///< rays a hit for ambient occlusion; 0: none
  double occlusion_distance = 0; ///< how far they reach; 0: a tenth of the mesh's diagonal
};

} // namespace insitu::render
