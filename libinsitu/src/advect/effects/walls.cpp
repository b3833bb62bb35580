#include "advect/effects/walls.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "advect/integrate/integrate.h"
#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "query/walk/beside_mesh.h"
#include "query/walk/face_crossing.h"

namespace insitu::advect {

namespace {

/// Contacts in a row after which a move is cut short: two walls of a wedge can take a particle to
/// and fro without end.
constexpr int most_contacts = 16;
/// A displacement is looked at in parts of half a cell, so that it does not jump over a wall.
constexpr double part_cells = 0.5;
constexpr int most_parts = 256;
constexpr double skin_cells = 1e-9;

Vec3d unit_or_zero(const Vec3d& v) {
  const double length = length_of(v);
  return length > 0.0 && std::isfinite(length) ? v / length : Vec3d{};
}

} // namespace

Box Walls::box(std::int64_t cell, double alpha) const {
  mesh::CellVertices c;
  mesh::gather(sampler_->mesh(), cell, c, alpha);
  return box_of(c);
}

Vec3d Walls::edges(std::int64_t cell, double alpha) const {
  if (space_.is_geocentric()) { // level, and between heights: a layer is as thin as it is
    mesh::CellVertices c;
    mesh::gather(sampler_->mesh(), cell, c, alpha);
    const Vec3d normal = geo::upright(c.x[0]).normal, origin = c.x[0];
    for (int i = 0; i < c.count; ++i) {
      const double height = geo::upright(c.x[i]).height;
      c.x[i] = geo::to_east_north_up(normal, c.x[i] - origin);
      c.x[i].z = height;
    }
    return edges_of(box_of(c));
  }
  const Box b = box(cell, alpha);
  return space_.is_curved() ? scale(b.middle()).edges(edges_of(b)) : edges_of(b);
}

Vec3d Walls::middle(std::int64_t cell, double alpha) const {
  mesh::CellVertices c;
  mesh::gather(sampler_->mesh(), cell, c, alpha);
  Vec3d sum;
  for (int i = 0; i < c.count; ++i)
    sum += c.x[i];
  return sum / double(c.count);
}

Vec3d Walls::skin(const Spot& at, double alpha) const {
  Vec3d s = skin_cells * extent(at.cell, alpha);
  for (int a = 0; a < 3; ++a)
    s[a] = std::max(s[a], 8.0 * std::numeric_limits<double>::epsilon() * std::abs(at.x[a]));
  return s;
}

Vec3d Walls::carry(const Spot& at, double alpha0, double alpha1) const {
  const query::Location here = locate(at.x, at.cell, alpha0);
  if (!here || alpha0 == alpha1)
    return at.x;
  mesh::CellVertices then, now;
  mesh::gather(sampler_->mesh(), here.cell, then, alpha0);
  mesh::gather(sampler_->mesh(), here.cell, now, alpha1);
  double weight[8];
  cells::shape_functions(now.shape, here.parametric, weight);
  Vec3d x = at.x; // the displacement is added, so that what does not move keeps its place exactly
  for (int v = 0; v < now.count; ++v)
    x += weight[v] * (now.x[v] - then.x[v]);
  return x;
}

bool Walls::is_on_flat_face(const Spot& at, const Vec3d& normal, double alpha) const {
  constexpr double near = 16.0, even = 0.05; // skins
  if (space_.is_curved() || normal == Vec3d{})
    return false;
  mesh::CellVertices c;
  mesh::gather(sampler_->mesh(), at.cell, c, alpha);
  const Vec3d s = skin(at, alpha);
  const double reach =
      std::abs(normal.x) * s.x + std::abs(normal.y) * s.y + std::abs(normal.z) * s.z;
  const cells::FaceTable table = cells::face_table(c.shape);
  for (int f = 0; f < table.face_count; ++f) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int v = 0; v < table.faces[f].vertex_count; ++v) {
      const double above = math::dot(normal, c.x[table.faces[f].vertices[v]] - at.x);
      low = std::min(low, above);
      high = std::max(high, above);
    }
    if (std::max(std::abs(low), std::abs(high)) <= near * reach && high - low <= even * reach)
      return true;
  }
  return false;
}

/// Takes a particle on a periodic side to the opposite one, if that is inside the mesh.
bool Walls::pass_side(Spot& at, const Vec3d& d, double alpha) const {
  const Vec3d near = 1e3 * skin(at, alpha);
  for (int a = 0; a < 3; ++a) {
    const bool up = d[a] > 0.0;
    if (!sides_->is_periodic(a) || d[a] == 0.0 || std::abs(sides_->beyond(at.x, a, up)) > near[a])
      continue;
    // On the other side itself, or just inside it where rounding has that face elsewhere.
    for (const double in : {0.0, 1.0, 1e3}) {
      Vec3d x = at.x;
      const double inward = in * near[a] * 1e-3;
      x[a] = sides_->at(a, !up) + (up ? inward : -inward);
      x = space_.image(x, geo::Pole::none);
      if (const query::Location found = locate(x, -1, alpha)) {
        at = {x, found.cell};
        return true;
      }
    }
  }
  return false;
}

Moved Walls::move(Spot& at, Vec3d d, const BoundaryEffect& boundary, double alpha, double& length,
                  Vec3d* carried) {
  wall_ = {};
  const Spot start = at;
  const double length_before = length;
  // These have to learn of the wall that they are pressed to, by however little.
  const bool turns =
      boundary.response == AtBoundary::slide || boundary.response == AtBoundary::reflect;
  for (int contact = 0; contact < most_contacts; ++contact) {
    const double crossed = cells_crossed(d, extent(at.cell, alpha));
    if (!(crossed > (contact == 0 ? 0.0 : skin_cells))) { // nothing left, or NaN
      rename(at, alpha, carried);
      return Moved::inside;
    }
    const int parts = int(std::clamp(std::ceil(crossed / part_cells), 1.0, double(most_parts)));
    Vec3d part = d / double(parts);
    std::optional<query::Exit> exit;
    int k = 0;
    for (; k < parts; ++k) {
      const geo::Pole pole = space_.pole_of(at.x);
      const Vec3d x = at.x + part;
      Vec3d y = space_.image(x, pole);
      query::Location found = locate(y, at.cell, alpha);
      if (!found && !turns) // beyond the wall by rounding, it is on it
        found = query::bring_inside(
            *sampler_, y, query::rounding_in(sampler_->mesh(), at.cell, alpha), {accuracy_, alpha});
      if (!found) {
        exit = query::leave_mesh(*sampler_, at.cell, at.x, x, {accuracy_, alpha});
        break;
      }
      length += length_of(scale(at.x + 0.5 * part).metres(part));
      if (!(y == x) && k + 1 < parts) { // to the same end on the other sheet
        const double left = double(parts - k - 1);
        part = (space_.across(x, pole, y, x + left * part) - y) / left;
      }
      enter_axes(at.x, y, carried);
      at = {y, found.cell};
    }
    if (k == parts)
      return Moved::inside;
    if (!exit)
      break;
    length += exit->t * length_of(scale(at.x + 0.5 * exit->t * part).metres(part));
    d = (1.0 - exit->t + double(parts - k - 1)) * part;
    const Vec3d from = at.x;
    at = {exit->inside, exit->owner};
    if (space_.is_curved() && part.z == 0.0) // to the bit: rounding of the exit is no way down
      if (const query::Location found = locate({at.x.x, at.x.y, from.z}, at.cell, alpha))
        at = {{at.x.x, at.x.y, from.z}, found.cell};
    enter_axes(from, at.x, carried);
    if (next_sheet(at, d, alpha, carried))
      continue;
    if (pass_side(at, d, alpha)) {
      ++work_->contacts;
      continue;
    }
    if (boundary.response == AtBoundary::leave)
      return Moved::left;
    ++work_->contacts;
    if (boundary.response == AtBoundary::stop)
      return Moved::stopped;
    if (boundary.response == AtBoundary::put_back) {
      at = start;
      length = length_before;
      if (carried)
        *carried = {};
      return Moved::inside;
    }
    const Scale per_metre = scale(at.x);
    const Vec3d n = normal_in_metres(per_metre, exit->normal);
    wall_ = n;
    if (n == Vec3d{})
      break;
    step_back(at, per_metre.coordinates(n), alpha);
    const bool mirror = boundary.response == AtBoundary::reflect;
    // In metres, where the wall is at right angles to its normal.
    const auto turned = [&](const Scale& s, const Vec3d& normal) {
      Vec3d rest = s.metres(d);
      rest -= ((mirror ? 2.0 : 1.0) * math::dot(rest, normal)) * normal;
      return s.coordinates(rest);
    };
    Vec3d rest = turned(per_metre, n);
    if (space_.is_curved() && !mirror) { // with the metric halfway along the wall: of second order
      const Scale halfway = scale(at.x + 0.5 * rest);
      rest = turned(halfway, normal_in_metres(halfway, exit->normal));
    }
    d = rest;
    if (const double out = carried ? math::dot(*carried, n) : 0.0; out > 0.0)
      *carried -= ((mirror ? 1.0 + boundary.restitution : 1.0) * out) * n;
  }
  rename(at, alpha, carried);
  ++work_->pinned;
  return Moved::inside;
}

/// Vectors at x change to the axes of the same place's chart at y.
void Walls::enter_axes(const Vec3d& x, const Vec3d& y, Vec3d* carried) {
  if (carried)
    *carried = space_.transport(x, y, *carried);
  if (!space_.same_axes(x, y))
    wall_ = {};
}

/// A spot in an overhang of its sheet by its image.
void Walls::rename(Spot& at, double alpha, Vec3d* carried) {
  if (!space_.is_curved())
    return;
  const Vec3d y = space_.image(at.x, space_.pole_of(at.x));
  if (y == at.x)
    return;
  if (const query::Location found = locate(y, -1, alpha)) {
    enter_axes(at.x, y, carried);
    at = {y, found.cell};
  }
}

/// Where a sheet of a chart ends, the mesh may go on in another: takes the spot there, a little
/// beyond, and the rest of its way to the same end.
bool Walls::next_sheet(Spot& at, Vec3d& rest, double alpha, Vec3d* carried) {
  if (!space_.is_curved())
    return false;
  const geo::Pole pole = space_.pole_of(at.x);
  const double skins = cells_crossed(rest, skin(at, alpha));
  const Vec3d x = skins > 8.0 ? at.x + (8.0 / skins) * rest : at.x + rest;
  Vec3d y = space_.image(x, pole);
  if (y == x) // of this sheet, which has no cell there
    return false;
  query::Location found = locate(y, -1, alpha);
  if (!found && pole == geo::Pole::none && space_.is_beyond_pole(x)) {
    // Where coasts meet at a pole, what is beside one is beside the other by less than its skin.
    const Vec3d there = y;
    for (const double beside : {-32.0, 32.0})
      if (!found) {
        y.x = there.x + beside * skin(at, alpha).x;
        found = locate(y, -1, alpha);
      }
  }
  if (!found)
    return false;
  rest = space_.across(x, pole, y, at.x + rest) - y;
  enter_axes(x, y, carried);
  at = {y, found.cell};
  return true;
}

/// Of a face's normal in coordinates. On a chart what is upright but for rounding is upright: then
/// nothing along it rises or sinks.
Vec3d Walls::normal_in_metres(const Scale& per_metre, const Vec3d& normal) const {
  Vec3d n = per_metre.covector(normal);
  if (space_.is_curved() && std::abs(n.z) < 1e-9 * std::hypot(n.x, n.y))
    n.z = 0.0;
  return unit_or_zero(n);
}

/// From the wall into its skin, against a displacement outwards: what goes along the wall would
/// else be out of it by rounding.
void Walls::step_back(Spot& at, const Vec3d& out, double alpha) const {
  const double reach = 1.0 / std::max(cells_crossed(out, skin(at, alpha)), 1e-300);
  const Vec3d x = at.x - reach * out;
  if (const query::Location found = locate(x, at.cell, alpha))
    at = {x, found.cell};
}

} // namespace insitu::advect
