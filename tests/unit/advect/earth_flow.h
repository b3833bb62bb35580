#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "advect/pathlines.h"
#include "fixtures/committed.h"
#include "fixtures/earth_meshes.h"
#include "geo/upright.h"

/// Geodetic meshes with velocities given by a function, and tracers with effects on them.
namespace insitu::test {

constexpr double degree = std::numbers::pi / 180;

/// Around the Earth between coasts at 10 degrees south and north, from a meridian on.
inline TestMesh tropics(double west, bool wraps) {
  return fixtures::lattice({.west = west,
                            .south = -10,
                            .east = west + 360,
                            .north = 10,
                            .across = 72,
                            .along = 4,
                            .wraps = wraps});
}

/// A committed mesh in longitude and latitude (degrees, metres of height, unless `units` says
/// otherwise) with fields of functions of the vertices' places in degrees and metres of height.
struct Ocean : fixtures::Committed {
  using Vector = std::function<Vec3d(const Vec3d&)>;
  using Scalar = std::function<double(const Vec3d&)>;

  /// flow: metres per second east, north and up. geocentric: the mesh (in degrees and metres of
  /// height) and the velocities are turned so.
  Ocean(const TestMesh& from, const Vector& flow, const Scalar& scalar = {},
        const geo::ChartUnits& units = {}, bool geocentric = false)
      : Committed() {
    TestMesh turned = from;
    mesh.reference_frame = fixtures::frame_of(units);
    if (geocentric) {
      mesh.reference_frame.kind = INSITU_FRAME_GEOCENTRIC;
      for (Vec3d& x : turned.vertices)
        x = geocentric_of(x);
    }
    arrays = fixtures::SolverArrays(turned);
    for (const Vec3d& x : from.vertices) {
      const Vec3d at{units.radians ? x.x / degree : x.x, units.radians ? x.y / degree : x.y,
                     x.z * units.up_per_unit()};
      const Vec3d local = flow(at),
                  v = geocentric ? geo::from_east_north_up(geo::normal_of({}, at), local) : local;
      velocity.insert(velocity.end(), {v.x, v.y, v.z});
      scalars.push_back(scalar ? scalar(at) : 0.0);
    }
    const insitu_array a = arrays.point_array();
    const insitu_cells c = arrays.cells();
    const auto count = std::int64_t(from.vertices.size());
    const insitu_array v = insitu_array_of(velocity.data(), INSITU_FLOAT64, count, 3);
    const insitu_array s = insitu_array_of(scalars.data(), INSITU_FLOAT64, count, 1);
    mesh.mesh().set_points(0, &a, 1);
    mesh.mesh().set_cells(0, &c);
    mesh.mesh().set_field(0, "v", INSITU_VERTEX, &v, 1);
    mesh.mesh().set_field(0, "s", INSITU_VERTEX, &s, 1);
    commit();
  }
  /// Of degrees and metres of height, and back; by normals, which GeographicLib holds to 1e-14.
  static Vec3d geocentric_of(const Vec3d& p) {
    return geo::geocentric_point({geo::normal_of({}, p), p.z});
  }
  static Vec3d geodetic_of(const Vec3d& x) {
    const geo::Upright at = geo::upright(x);
    return geo::chart_point({}, geo::Pole::none, at.normal, at.height);
  }
  mesh::FieldView flow() const { return mesh.mesh().field("v"); }
  mesh::FieldView scalar() const { return mesh.mesh().field("s"); }

  /// Particles after `cycles` advances to `end` in this steady flow.
  advect::Tracer run(const advect::Effects& effects, std::span<const Vec3d> seeds, double end,
                     int cycles = 1, const core::Threads* with = nullptr) {
    advect::Tracer tracer(settings, memory);
    tracer.set_effects(effects);
    tracer.seed(seeds, 0.0);
    const mesh::FieldView v = flow();
    work = {};
    for (int c = 0; c < cycles; ++c)
      work += tracer
                  .advance(sampler(), v, &v, end * c / cycles, end * (c + 1) / cycles,
                           with ? *with : threads)
                  .effects;
    return tracer;
  }

  advect::TracerSettings settings;
  advect::EffectWork work;
  std::vector<double> velocity, scalars;
};

inline advect::Effects boundary(advect::AtBoundary response) {
  advect::Effects effects;
  effects.boundary.emplace();
  effects.boundary->response = response;
  return effects;
}

/// Metres per degree of longitude and latitude at a latitude (degrees) and a height.
inline Vec3d metres_per_degree(double latitude, double height = 0.0) {
  const geo::Radii r = geo::radii(std::sin(latitude * degree));
  return {(r.across + height) * std::cos(latitude * degree) * degree, (r.along + height) * degree,
          1.0};
}

inline Ocean::Vector constant(const Vec3d& v) {
  return [v](const Vec3d&) { return v; };
}

/// Metres per second towards a direction in space.
inline Ocean::Vector towards(const Vec3d& v) {
  return [v](const Vec3d& at) {
    const geo::ChartPlace place = geo::place_of({}, geo::Pole::none, at);
    return Vec3d{dot(v, place.east), dot(v, place.north), 0.0};
  };
}

} // namespace insitu::test
