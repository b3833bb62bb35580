#include "query/walk/face_crossing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cells/exact/decide.h"
#include "cells/kernels/kernels.h"
#include "query/walk/ways_out.h"

namespace insitu::query {

using cells::Crossing;
using math::Vec3d;

namespace {

class Walk {
public:
  Walk(const Sampler& sampler, const Vec3d& a, const Vec3d& b, const LocateOptions& options)
      : sampler_(sampler), options_(options), s_(a, b) {}

  std::optional<Exit> run(std::int64_t cell);

private:
  Location locate(const Vec3d& p, std::int64_t hint) const {
    return sampler_.locate(p, hint, options_);
  }
  void gather(std::int64_t cell) {
    cell_ = cell;
    mesh::gather(sampler_.mesh(), cell, vertices_, options_.alpha);
    rounding_ =
        std::max(8.0 * epsilon * largest_coordinate(vertices_), std::numeric_limits<double>::min());
  }
  bool is_boundary(const WayOut& f) const {
    return !locate(f.within.point + (4.0 * rounding_) * f.within.normal, f.cell);
  }
  std::optional<FaceCrossing> boundary_nearby(const Vec3d& p, double t) const;
  std::optional<Exit> bisect(double from);
  Exit finish(const WaysOut& ways);
  void put_inside(Exit& exit, const Vec3d& towards_middle, double distance) const;

  const Sampler& sampler_;
  LocateOptions options_;
  Segment s_;
  std::int64_t cell_ = -1;
  mesh::CellVertices vertices_;
  double rounding_ = 0.0; ///< of positions about the cell
};

std::optional<Exit> Walk::run(std::int64_t cell) {
  if (!s_.valid() || cell < 0)
    return std::nullopt;
  constexpr int most_cells = 1 << 20;
  gather(cell);
  double from = 0.0;
  for (int passed = 0; passed < most_cells; ++passed) {
    WaysOut ways = ways_out(vertices_, cell_, s_, from);
    if (ways.distance > s_.length)
      return bisect(from); // rounding may have put b outside
    if (ways.count == 0)
      ways.distance = from;
    // The next cell: the owner of a point just beyond, or further where rounding leaves it here.
    double step = rounding_;
    Location beyond;
    for (;; step *= 4.0) {
      const double distance = ways.distance + step;
      beyond = locate(s_.at(distance), cell_);
      if (beyond.cell != cell_)
        break;
      if (distance >= s_.length)
        return std::nullopt;
    }
    if (!beyond) {
      if (ways.count > 0 && step <= 256.0 * rounding_)
        return finish(ways);
      return bisect(std::max(from, ways.distance + (step > rounding_ ? 0.25 * step : 0.0)));
    }
    from = ways.distance + step;
    if (from >= s_.length)
      return std::nullopt; // b is there
    gather(beyond.cell);
  }
  return bisect(from);
}

Exit Walk::finish(const WaysOut& ways) {
  Exit exit;
  static_cast<FaceCrossing&>(exit) = ways.faces[0];
  bool found = false;
  Vec3d middle = ways.faces[0].within.point - exit.point;
  for (int k = 0; k < ways.count && !found; ++k)
    if ((found = is_boundary(ways.faces[k]))) {
      static_cast<FaceCrossing&>(exit) = ways.faces[k];
      middle = ways.faces[k].within.point - exit.point;
    }
  if (!found)
    if (const auto other = boundary_nearby(exit.point, exit.t))
      static_cast<FaceCrossing&>(exit) = *other;
  put_inside(exit, middle, ways.distance);
  return exit;
}

/// The last cell may touch the boundary at an edge or a vertex only: the faces of other cells there
/// tell where it is.
std::optional<FaceCrossing> Walk::boundary_nearby(const Vec3d& p, double t) const {
  Vec3d low = vertices_.x[0], high = low;
  for (int i = 1; i < vertices_.count; ++i)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], vertices_.x[i][k]);
      high[k] = std::max(high[k], vertices_.x[i][k]);
    }
  std::optional<FaceCrossing> best;
  for (int corner = 0; corner < 27; ++corner) {
    const int side[3] = {corner % 3 - 1, corner / 3 % 3 - 1, corner / 9 - 1};
    Vec3d q = p;
    for (int k = 0; k < 3; ++k)
      q[k] += side[k] * std::max(1e-7 * (high[k] - low[k]), 64.0 * rounding_);
    const Location at = locate(q, -1);
    if (!at)
      continue;
    mesh::CellVertices c;
    mesh::gather(sampler_.mesh(), at.cell, c, options_.alpha);
    double n[8];
    cells::shape_functions(c.shape, cells::parametric_in(c.shape, c.x, q), n);
    for (int f = 0; f < cells::face_table(c.shape).face_count; ++f) {
      if (cells::parametric_distance(c.shape, f, n) > 1e-5)
        continue;
      const WayOut face = on_parametric_face(c, at.cell, f, n, t);
      if ((!best || dot(face.normal, s_.direction) > dot(best->normal, s_.direction)) &&
          is_boundary(face))
        best = face;
    }
  }
  if (best)
    best->point = p;
  return best;
}

/// Where the mesh ends, by ownership alone.
std::optional<Exit> Walk::bisect(double from) {
  if (locate(s_.b, cell_))
    return std::nullopt;
  double inside = from, outside = s_.length;
  Location last = locate(s_.at(inside), cell_);
  for (int i = 0; i < 200 && outside - inside > 0.5 * rounding_; ++i) {
    const double middle = 0.5 * (inside + outside);
    if (!(middle > inside && middle < outside))
      break;
    const Location at = locate(s_.at(middle), last ? last.cell : cell_);
    (at ? inside : outside) = middle;
    if (at)
      last = at;
  }
  if (last && last.cell != cell_)
    gather(last.cell);
  double n[8];
  cells::shape_functions(vertices_.shape,
                         cells::parametric_in(vertices_.shape, vertices_.x, s_.at(inside)), n);
  WaysOut ways;
  ways.distance = inside;
  const cells::FaceTable table = cells::face_table(vertices_.shape);
  double nearest = std::numeric_limits<double>::infinity();
  for (int f = 0; f < table.face_count; ++f)
    nearest = std::min(nearest, cells::parametric_distance(vertices_.shape, f, n));
  for (int f = 0; f < table.face_count; ++f)
    if (cells::parametric_distance(vertices_.shape, f, n) <= nearest + 1e-9)
      ways.faces[ways.count++] =
          on_parametric_face(vertices_, cell_, f, n, std::min(inside / s_.length, 1.0));
  std::stable_sort(ways.faces, ways.faces + ways.count, [&](const WayOut& a, const WayOut& b) {
    return dot(a.normal, s_.direction) > dot(b.normal, s_.direction);
  });
  return finish(ways);
}

/// Of the points within rounding of the exit, one that a cell owns.
void Walk::put_inside(Exit& exit, const Vec3d& towards_middle, double distance) const {
  const auto accept = [&](const Vec3d& p) {
    const Location at = locate(p, exit.cell);
    if (at) {
      exit.inside = p;
      exit.owner = at.cell;
    }
    return bool(at);
  };
  if (accept(exit.point))
    return;
  // Within the face first, so that a point of a side stays on it.
  const Vec3d along = unit(towards_middle);
  for (double step = 0.125 * rounding_; step <= 8.0 * rounding_; step *= 2.0)
    if (accept(exit.point + step * along))
      return;
  for (double step = 0.125 * rounding_; step <= 8.0 * rounding_; step *= 2.0)
    if (accept(exit.point - step * exit.normal) ||
        accept(exit.point + step * (along - exit.normal)))
      return;
  for (double step = 0.125 * rounding_; step < distance; step *= 2.0)
    if (accept(s_.a + (distance - step) * s_.direction))
      return;
  exit.inside = s_.a;
  exit.owner = cell_;
}

} // namespace

std::optional<Exit> leave_mesh(const Sampler& sampler, std::int64_t cell, const Vec3d& a,
                               const Vec3d& b, const LocateOptions& options) {
  return Walk(sampler, a, b, options).run(cell);
}

} // namespace insitu::query
