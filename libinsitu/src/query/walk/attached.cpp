#include "query/walk/attached.h"

#include <cmath>

#include "cells/kernels/kernels.h"
#include "geo/upright.h"
#include "query/chart_image.h"

namespace insitu::query {

math::Vec3d position(const Sampler& sampler, const Location& at) {
  mesh::CellVertices c;
  mesh::gather(sampler.mesh(), at.cell, c);
  double weight[8];
  cells::shape_functions(c.shape, at.parametric, weight);
  math::Vec3d x;
  for (int v = 0; v < c.count; ++v)
    x += weight[v] * c.x[v];
  return sampler.chart() ? sampler.chart()->point_of(x) : x;
}

math::Vec3d on_the_way(const Sampler& sampler, const math::Vec3d& a, const math::Vec3d& b,
                       double part) {
  const math::Vec3d straight = a + part * (b - a);
  const ChartImage* const chart = sampler.chart();
  if (!chart || (a.x == b.x && a.y == b.y))
    return straight;
  const math::Vec3d n =
      (1.0 - part) * geo::normal_of(chart->units, a) + part * geo::normal_of(chart->units, b);
  return chart->with_longitude(geo::chart_point(chart->units, geo::Pole::none, n, straight.z));
}

namespace {

math::Vec3d in_space(const geo::ChartUnits& units, const math::Vec3d& p) {
  return geo::geocentric_point({geo::normal_of(units, p), p.z * units.up_per_unit()});
}

} // namespace

double distance(const Sampler& sampler, const math::Vec3d& a, const math::Vec3d& b) {
  const ChartImage* const chart = sampler.chart();
  if (!chart)
    return std::hypot(b.x - a.x, b.y - a.y, b.z - a.z);
  if (a.x == b.x && a.y == b.y)
    return std::abs((b.z - a.z) * chart->units.up_per_unit());
  const math::Vec3d d = in_space(chart->units, b) - in_space(chart->units, a);
  return std::sqrt(dot(d, d));
}

bool follow(const Sampler& sampler, bool same_cells, const LocateOptions& options, Location& at,
            math::Vec3d& x) {
  if (!same_cells || !at || at.cell >= sampler.mesh().cell_count()) {
    at = sampler.locate(x, -1, options);
    if (at && sampler.chart())
      x = sampler.chart()->with_longitude(x);
    return bool(at);
  }
  const math::Vec3d moved = position(sampler, at);
  if (!(std::isfinite(moved.x) && std::isfinite(moved.y) && std::isfinite(moved.z))) {
    at = {};
    return false;
  }
  x = moved;
  return true;
}

} // namespace insitu::query
