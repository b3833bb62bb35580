#pragma once

#include "math/vec.h"
#include "render/camera/camera.h"

/// Places and directions on Earth, for cameras of geocentric frames.
namespace insitu::scene {

/// Geocentric metres of a place: degrees, and metres above the WGS84 ellipsoid.
math::Vec3d geocentric_place(double longitude, double latitude, double height);

/// Unit vectors, right-handed.
struct LocalAxes {
  math::Vec3d east, north, up;
};
LocalAxes local_axes(double longitude, double latitude);
/// Of the place below or above a geocentric point; near the Earth's centre, which is below every
/// place, those of longitude and latitude 0.
LocalAxes local_axes_at(const math::Vec3d& geocentric);

/// A camera made as if east, north and up were x, y and z, turned around what it looks at to where
/// they are there.
render::Camera turned_to_local(const render::Camera& camera);

} // namespace insitu::scene
