#include "query/walk/beside_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "cells/kernels/kernels.h"
#include "query/batch/candidates.h"
#include "query/chart_image.h"
#include "query/elsewhere.h"
#include "query/lattice/gridlet_query.h"
#include "query/point_query.h"

namespace insitu::query {

using math::Vec3d;

namespace {

double largest(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

Vec3d clamped(const Vec3d& p, const Vec3d& low, const Vec3d& high) {
  return {std::clamp(p.x, low.x, high.x), std::clamp(p.y, low.y, high.y),
          std::clamp(p.z, low.z, high.z)};
}

/// The nearest coordinates that are this far within the reference cell.
Vec3d within(mesh::Shape shape, Vec3d r, double in) {
  const bool simplex = shape == mesh::Shape::tetrahedron, wedge = shape == mesh::Shape::wedge;
  for (int a = 0; a < 3; ++a)
    r[a] = std::clamp(r[a], in, 1.0 - in);
  const double sum = r.x + r.y + (simplex ? r.z : 0.0);
  if ((simplex || wedge) && sum > 1.0 - in) {
    const double less = (sum - (1.0 - in)) / (simplex ? 3.0 : 2.0);
    r.x -= less;
    r.y -= less;
    r.z -= simplex ? less : 0.0;
    for (int a = 0; a < 3; ++a)
      r[a] = std::max(r[a], 0.0);
  }
  return r;
}

/// The point of a cell that is nearest to one beside it, if that is within reach.
std::optional<Vec3d> nearest_in(const mesh::CellVertices& c, const Vec3d& p, double reach) {
  Vec3d low = c.x[0], high = low;
  for (int v = 1; v < c.count; ++v)
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], c.x[v][a]);
      high[a] = std::max(high[a], c.x[v][a]);
    }
  const Vec3d in_box = clamped(p, low, high); // to the bit, where faces are level
  if (!(largest(in_box - p) <= reach))
    return std::nullopt;
  if (decide(c.shape, c.x, in_box))
    return in_box;
  constexpr double far = 1e-3; // beyond, in parametric units, no rounding takes a point
  const auto map = cells::inverse_map(c.shape, c.x, p);
  if (!map.converged || !(map.margin > -far))
    return std::nullopt;
  for (double in = 0.0; in < far; in = in == 0.0 ? 0x1p-53 : 2.0 * in) {
    Vec3d y = clamped(cells::map_to_physical(c.shape, c.x, within(c.shape, map.r, in)), low, high);
    if (!(largest(y - p) <= 4.0 * reach))
      break;
    if (!decide(c.shape, c.x, y))
      continue;
    for (const int a : {2, 1, 0}) { // what need not move does not: depths, above all
      Vec3d less = y;
      less[a] = p[a];
      if (decide(c.shape, c.x, less))
        y = less;
    }
    return y;
  }
  return std::nullopt;
}

/// Among the cells, of images where there is a chart.
std::optional<Vec3d> nearest_inside(const Sampler& sampler, const Vec3d& p, double reach,
                                    const LocateOptions& options) {
  const mesh::MeshView& mesh = sampler.mesh();
  const PointQuery query{mesh, sampler.tree(), options};
  const Vec3d by{reach, reach, reach};
  float lower[3], upper[3], other[3];
  if (sampler.tree().empty() || !query.box_rule().box(p - by, lower, other) ||
      !query.box_rule().box(p + by, other, upper))
    return std::nullopt;
  std::optional<Vec3d> best;
  std::int64_t owner = -1;
  const auto take = [&](const Vec3d& y, std::int64_t cell) {
    const double was = best ? largest(*best - p) : 0.0, is = largest(y - p);
    if (best && (is > was || (is == was && cell > owner)))
      return;
    best = y;
    owner = cell;
  };
  for (const Candidate& candidate : query.candidates_in(lower, upper)) {
    const std::int64_t flat = sampler.tree().cells()[candidate.slot];
    if (flat < mesh.first_single_cell()) { // it stands for a gridlet
      const mesh::GridletsView& all = *gridlets_of(mesh);
      const std::int64_t gridlet = flat >> mesh::Gridlet::cell_bits;
      const mesh::Gridlet& g = all.gridlets[gridlet];
      Vec3d low, high;
      for (int a = 0; a < 3; ++a) {
        low[a] = all.coordinate(g, a, 0);
        high[a] = all.coordinate(g, a, g.size[a]);
      }
      const Vec3d y = clamped(p, low, high);
      Reason why;
      if (largest(y - p) <= reach && locate_in_gridlet(all, gridlet, y, why))
        take(y, flat);
      continue;
    }
    mesh::CellVertices c;
    mesh::gather(mesh, flat, c, options.alpha);
    if (const auto y = nearest_in(c, p, reach))
      take(*y, flat);
  }
  return best;
}

} // namespace

double rounding_in(const mesh::MeshView& mesh, std::int64_t cell, double alpha) {
  if (cell < 0 || cell >= mesh.cell_count())
    return 0.0;
  mesh::CellVertices c;
  mesh::gather(mesh, cell, c, alpha);
  double most = 0.0;
  for (int v = 0; v < c.count; ++v)
    most = std::max({most, largest(c.x[v]), largest(c.x[v] - c.x[0])});
  return 16.0 * std::numeric_limits<double>::epsilon() * most;
}

bool bring_into_cell(const mesh::CellVertices& cell, Vec3d& p, double reach) {
  const std::optional<Vec3d> inside = nearest_in(cell, p, reach);
  if (inside)
    p = *inside;
  return bool(inside);
}

Location bring_inside(const Sampler& sampler, Vec3d& p, double reach,
                      const LocateOptions& options) {
  if (!(reach > 0.0))
    return {};
  const ChartImage* const chart = sampler.chart();
  const Vec3d image = chart ? (*chart)(p) : p;
  std::optional<Vec3d> found = nearest_inside(sampler, image, reach, options);
  if (!found && sampler.outlook())
    found = sampler.outlook()->nearest(image, reach, options.alpha);
  if (!found)
    return {};
  if (!chart) {
    p = *found;
    return sampler.locate(p, -1, options);
  }
  // On the chart of a pole rounding may take it back again: then further in.
  const geo::Pole pole = chart->pole_of(image);
  const auto in_frame = [&](Vec3d q) {
    q.x -= chart->offset(pole);
    return pole == geo::Pole::none ? q
                                   : geo::between_charts(chart->units, pole, geo::Pole::none, q);
  };
  for (double part = 1.0; part < 1e3; part *= 4.0) {
    const Vec3d q = image + part * (*found - image);
    const Vec3d y = p + (in_frame(q) - in_frame(image)); // what does not move keeps its place
    if (const Location at = sampler.locate(y, -1, options)) {
      p = y;
      return at;
    }
  }
  return {};
}

} // namespace insitu::query
