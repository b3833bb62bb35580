#include "scene/earth/geocentric_view.h"

#include <cmath>
#include <span>

#include "geo/reference_frames.h"

namespace insitu::scene {

using math::Vec3d;

Vec3d geocentric_place(double longitude, double latitude, double height) {
  Vec3d place{longitude, latitude, height};
  const std::span<Vec3d> one(&place, 1);
  geo::to_geocentric(geo::Frame::geodetic(), one, one);
  return place;
}

LocalAxes local_axes(double longitude, double latitude) {
  constexpr double degree = 3.14159265358979323846 / 180.0;
  const double sl = std::sin(longitude * degree), cl = std::cos(longitude * degree);
  const double sb = std::sin(latitude * degree), cb = std::cos(latitude * degree);
  return {{-sl, cl, 0}, {-sb * cl, -sb * sl, cb}, {cb * cl, cb * sl, sb}};
}

LocalAxes local_axes_at(const Vec3d& geocentric) {
  constexpr double nowhere = 1e5; // metres; the vertical there says nothing about the mesh
  if (!(dot(geocentric, geocentric) > nowhere * nowhere))
    return local_axes(0, 0);
  Vec3d place = geocentric;
  const std::span<Vec3d> one(&place, 1);
  geo::from_geocentric(geo::Frame::geodetic(), one, one);
  return local_axes(place.x, place.y);
}

render::Camera turned_to_local(const render::Camera& camera) {
  const LocalAxes axes = local_axes_at(camera.look_at);
  const auto turned = [&](const Vec3d& v) {
    return v.x * axes.east + v.y * axes.north + v.z * axes.up;
  };
  render::Camera to = camera;
  to.position = camera.look_at + turned(camera.position - camera.look_at);
  to.up = turned(camera.up);
  return to;
}

} // namespace insitu::scene
