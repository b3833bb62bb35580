#include "query/walk/face_crossing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cells/exact/decide.h"
#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "cells/kernels/ray_cell.h"

namespace insitu::query {

using cells::Crossing;
using math::Vec3d;

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

double largest(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Of unit length, or 0; neither overflows nor underflows.
Vec3d unit(Vec3d v) {
  const double scale = largest(v);
  if (!(scale > 0.0) || !std::isfinite(scale))
    return {};
  v = v / scale;
  return v / std::sqrt(dot(v, v));
}

Vec3d unit_normal(const Vec3d& a, const Vec3d& b) {
  return unit(cross(a / std::max(largest(a), std::numeric_limits<double>::min()),
                    b / std::max(largest(b), std::numeric_limits<double>::min())));
}

struct FacePoint {
  Vec3d point, normal;
};

/// The point of a face with these weights of its corners, and the normal there, out of the cell.
FacePoint on_face(const mesh::CellVertices& c, int count, const std::uint8_t* corners,
                  const double* weights) {
  Vec3d x[4], face_centre, centre;
  for (int k = 0; k < count; ++k)
    x[k] = c.x[corners[k]] - c.x[corners[0]];
  FacePoint out;
  for (int k = 1; k < count; ++k) {
    out.point += weights[k] * x[k];
    face_centre += (1.0 / count) * x[k];
  }
  if (count == 3) {
    out.normal = unit_normal(x[1], x[2]);
  } else {
    const double u = weights[1] + weights[2], v = weights[2] + weights[3];
    out.normal =
        unit_normal((1 - v) * x[1] + v * (x[2] - x[3]), (1 - u) * x[3] + u * (x[2] - x[1]));
    if (out.normal == Vec3d{}) // at a corner that is drawn out to a point or folded back
      out.normal = unit_normal(x[2], x[3] - x[1]);
  }
  // Cells may be turned over, and the order of a wedge is not always VTK's.
  for (int i = 0; i < c.count; ++i)
    centre += (1.0 / c.count) * (c.x[i] - c.x[corners[0]]);
  if (dot(out.normal, face_centre - centre) < 0.0)
    out.normal = -out.normal;
  out.point += c.x[corners[0]];
  return out;
}

/// The face whose corners these are (all, or those that are left of a collapsed quad).
int face_of(mesh::Shape shape, const Crossing& crossing) {
  const cells::FaceTable table = cells::face_table(shape);
  for (int f = 0; f < table.face_count; ++f) {
    const cells::Face& face = table.faces[f];
    const std::uint8_t* end = face.vertices + face.vertex_count;
    if (std::all_of(crossing.vertices, crossing.vertices + crossing.count,
                    [&](std::uint8_t v) { return std::find(face.vertices, end, v) != end; }))
      return f;
  }
  return -1;
}

/// A segment, and distances along it.
struct Segment {
  Vec3d a, b, direction;
  double length;
  cells::RaySpace space;

  Segment(const Vec3d& from, const Vec3d& to)
      : a(from), b(to), direction(unit(to - from)),
        length(std::hypot(to.x - from.x, to.y - from.y, to.z - from.z)), space({a, direction}) {}
  bool valid() const { return length > 0.0 && std::isfinite(length); }
  Vec3d at(double distance) const { return distance >= length ? b : a + distance * direction; }
};

/// A face through which the segment may go out, and a point of it a little towards its middle, to
/// look beyond.
struct WayOut : FaceCrossing {
  FacePoint within;
};

/// The ways out of a cell at one distance: faces that meet there.
struct WaysOut {
  double distance = -1.0;
  int count = 0;
  WayOut faces[cells::most_crossings];
};

WayOut make(const mesh::CellVertices& c, std::int64_t flat, int face, double t, int count,
            const std::uint8_t* corners, const double* weights) {
  const FacePoint p = on_face(c, count, corners, weights);
  constexpr double part = 1.0 / 1024;
  double within[4];
  for (int k = 0; k < count; ++k)
    within[k] = (1.0 - part) * weights[k] + part / count;
  return {{t, p.point, flat, face, p.normal}, on_face(c, count, corners, within)};
}

/// How far a cell reaches from a point: what rounding of distances in it is measured by.
double reach(const mesh::CellVertices& c, const Vec3d& a) {
  double far = 0.0;
  for (int i = 0; i < c.count; ++i)
    far = std::max(far, largest(c.x[i] - a));
  return far;
}

double largest_coordinate(const mesh::CellVertices& c) {
  double most = 0.0;
  for (int i = 0; i < c.count; ++i)
    most = std::max(most, largest(c.x[i]));
  return most;
}

/// Where the segment, in the cell at distance `from`, leaves it. None: it meets no face, as a
/// segment that grazes a corner may.
WaysOut ways_out(const mesh::CellVertices& c, std::int64_t flat, const Segment& s, double from) {
  WaysOut out;
  Crossing crossings[cells::most_crossings];
  const int n = cells::face_crossings(c, s.space, crossings);
  if (n == 0)
    return out;
  const double tolerance = 32.0 * epsilon * reach(c, s.a);
  // Cells whose faces are curved can be left and entered again.
  int last = n - 1;
  for (int k = 0; k + 1 < n && n > 2; ++k) {
    const double begin = std::max(crossings[k].t, from), end = crossings[k + 1].t;
    if (end - begin > tolerance &&
        !cells::holds(cells::contain_exact(c.shape, c.x, s.at(0.5 * (begin + end))).where) &&
        crossings[k].t >= from - tolerance) {
      last = k;
      break;
    }
  }
  out.distance = std::max(crossings[last].t, from);
  for (int k = 0; k < n; ++k)
    if (std::abs(crossings[k].t - crossings[last].t) <= tolerance)
      out.faces[out.count++] =
          make(c, flat, face_of(c.shape, crossings[k]), std::min(out.distance / s.length, 1.0),
               crossings[k].count, crossings[k].vertices, crossings[k].weights);
  // The one that faces the segment most comes first.
  std::stable_sort(out.faces, out.faces + out.count, [&](const WayOut& a, const WayOut& b) {
    return dot(a.normal, s.direction) > dot(b.normal, s.direction);
  });
  return out;
}

WayOut on_parametric_face(const mesh::CellVertices& c, std::int64_t flat, int face, const double* n,
                          double t) {
  const cells::Face f = cells::face_table(c.shape).faces[face];
  double weights[4], sum = 0.0;
  for (int k = 0; k < f.vertex_count; ++k)
    sum += weights[k] = std::clamp(n[f.vertices[k]], 0.0, 1.0);
  for (int k = 0; k < f.vertex_count; ++k)
    weights[k] = sum > 0.0 ? weights[k] / sum : 1.0 / f.vertex_count;
  return make(c, flat, face, t, f.vertex_count, f.vertices, weights);
}

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

std::optional<FaceCrossing> leave_cell(const mesh::MeshView& mesh, std::int64_t cell,
                                       const Vec3d& a, const Vec3d& b, double alpha) {
  const Segment s(a, b);
  if (!s.valid())
    return std::nullopt;
  mesh::CellVertices c;
  mesh::gather(mesh, cell, c, alpha);
  const WaysOut ways = ways_out(c, cell, s, 0.0);
  if (ways.count > 0)
    return ways.distance > s.length ? std::nullopt : std::optional<FaceCrossing>(ways.faces[0]);
  if (cells::holds(cells::contain_exact(c.shape, c.x, b).where))
    return std::nullopt;
  // It grazes a corner: the nearest face.
  double n[8];
  cells::shape_functions(c.shape, cells::parametric_in(c.shape, c.x, a), n);
  std::optional<FaceCrossing> best;
  for (int f = 0; f < cells::face_table(c.shape).face_count; ++f)
    if (cells::parametric_distance(c.shape, f, n) <= 1e-9)
      if (const WayOut x = on_parametric_face(c, cell, f, n, 0.0);
          !best || dot(x.normal, s.direction) > dot(best->normal, s.direction))
        best = x;
  return best;
}

FaceCrossing nearest_face(const mesh::CellVertices& vertices, std::int64_t cell,
                          const Vec3d& parametric) {
  double n[8];
  cells::shape_functions(vertices.shape, parametric, n);
  int nearest = 0;
  for (int f = 1; f < cells::face_table(vertices.shape).face_count; ++f)
    if (cells::parametric_distance(vertices.shape, f, n) <
        cells::parametric_distance(vertices.shape, nearest, n))
      nearest = f;
  return on_parametric_face(vertices, cell, nearest, n, 0.0);
}

std::optional<Exit> leave_mesh(const Sampler& sampler, std::int64_t cell, const Vec3d& a,
                               const Vec3d& b, const LocateOptions& options) {
  return Walk(sampler, a, b, options).run(cell);
}

} // namespace insitu::query
