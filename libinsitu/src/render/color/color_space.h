#pragma once

#include "math/vec.h"
#include "render/color/color_map.h"

namespace insitu::render {

/// The colour, linear, at fraction u between two sRGB colours, on the path of that space.
Color mix(ColorSpace space, const math::Vec3d& a, const math::Vec3d& b, double u);

/// CIELAB (CIE 1976, D65) of sRGB, and back; the way back may leave [0, 1].
math::Vec3d lab_of_srgb(const math::Vec3d& rgb);
math::Vec3d linear_of_lab(const math::Vec3d& lab);

} // namespace insitu::render
