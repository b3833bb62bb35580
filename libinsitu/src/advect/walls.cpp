#include "advect/walls.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "advect/integrate.h"
#include "cells/faces.h"
#include "cells/kernels.h"

namespace insitu::advect {

namespace {

/// Contacts in a row after which a move is cut short: two walls of a wedge can take a particle to
/// and fro without end.
constexpr int most_contacts = 16;
/// A displacement is looked at in parts of half a cell, so that it does not jump over a wall.
constexpr double part_cells = 0.5;
constexpr int most_parts = 256;
constexpr int most_trials = 80;
constexpr double skin_cells = 1e-9;

/// Per face of a cell, a function that is 0 on it and positive inside: the sum of the shape
/// functions of the vertices that are not the face's. Its gradient is the inward normal, on curved
/// faces as well.
struct Faces {
  mesh::CellVertices cell;
  cells::FaceTable table;
  double value[6];
  Vec3d gradient[6];

  Faces(const mesh::MeshView& mesh, const query::Location& at, double alpha) {
    mesh::gather(mesh, at.cell, cell, alpha);
    table = cells::face_table(cell.shape);
    double weight[8];
    cells::shape_functions(cell.shape, at.parametric, weight);
    for (int f = 0; f < table.face_count; ++f) {
      double off[8];
      std::fill(off, off + 8, 1.0);
      for (int k = 0; k < table.faces[f].vertex_count; ++k)
        off[table.faces[f].vertices[k]] = 0.0;
      value[f] = 0.0;
      for (int v = 0; v < cell.count; ++v)
        value[f] += off[v] * weight[v];
      gradient[f] = cells::gradient(cell.shape, cell.x, off, at.parametric);
    }
  }

  /// The face that x + s d leaves through next after `after`, and s; -1 if there is none.
  int next(const Vec3d& d, double& s, int after = -1) const {
    int found = -1;
    const double passed = after >= 0 ? s : -1.0;
    s = std::numeric_limits<double>::infinity();
    for (int f = 0; f < table.face_count; ++f) {
      const double rate = -math::dot(gradient[f], d);
      if (!(rate > 0.0))
        continue;
      const double at = std::max(value[f], 0.0) / rate;
      if (at < s && (at > passed || (at == passed && f > after))) {
        s = at;
        found = f;
      }
    }
    return found;
  }
};

Vec3d unit_or_zero(const Vec3d& v) {
  const double length = length_of(v);
  return length > 0.0 && std::isfinite(length) ? v / length : Vec3d{};
}

} // namespace

math::Vec3d Walls::extent(std::int64_t cell, double alpha) const {
  mesh::CellVertices c;
  mesh::gather(sampler_->mesh(), cell, c, alpha);
  Vec3d low = c.x[0], high = c.x[0];
  for (int i = 1; i < c.count; ++i)
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], c.x[i][a]);
      high[a] = std::max(high[a], c.x[i][a]);
    }
  Vec3d e = high - low;
  const double least = std::max(1e-6 * std::max({e.x, e.y, e.z}), 1e-300);
  for (int a = 0; a < 3; ++a)
    e[a] = std::max(e[a], least);
  return e;
}

Vec3d Walls::skin(const Spot& at, double alpha) const {
  Vec3d s = skin_cells * extent(at.cell, alpha);
  for (int a = 0; a < 3; ++a)
    s[a] = std::max(s[a], 8.0 * std::numeric_limits<double>::epsilon() * std::abs(at.x[a]));
  return s;
}

Vec3d Walls::normal(const Spot& at, const Vec3d& direction, double alpha) const {
  const query::Location here = locate(at.x, at.cell, alpha);
  if (!here)
    return {};
  const Faces faces(sampler_->mesh(), here, alpha);
  const Vec3d skins = skin(at, alpha), per_metre = scale(at.x);
  // At an edge, a face between two cells may come first: the wall is the one with nothing behind.
  Vec3d first;
  double s = 0.0;
  for (int face = faces.next(direction, s); face >= 0; face = faces.next(direction, s, face)) {
    const Vec3d n = unit_or_zero(by_axis(-faces.gradient[face], per_metre));
    const Vec3d step = s * direction;
    if (first == Vec3d{})
      first = n;
    if (cells_crossed(step, skins) > 16.0)
      break;
    const Vec3d out = unit_or_zero(-faces.gradient[face]);
    const double reach = 4.0 / std::max(cells_crossed(out, skins), 1e-300);
    if (!locate(at.x + step + reach * out, here.cell, alpha))
      return n;
  }
  return first;
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

/// Moves `at` along d, whose end is outside, to within the skin of where d leaves the mesh first
/// (walls thinner than the parts of d apart). Returns how much of d is left, 0 to 1.
double Walls::advance_to_wall(Spot& at, const Vec3d& d, double alpha) const {
  const Vec3d start = at.x, skins = skin(at, alpha);
  const double width = 1.0 / std::max(cells_crossed(d, skins), 1.0); // of the skin, along d
  double inside = 0.0, outside = 1.0;
  for (int trial = 0; trial < most_trials && outside - inside > width; ++trial) {
    double s = 0.5 * (inside + outside);
    if (trial % 3 != 2) { // where the last cell's faces say, just before it and just behind
      const query::Location here = locate(at.x, at.cell, alpha);
      double ahead;
      if (here && Faces(sampler_->mesh(), here, alpha).next(d, ahead) >= 0) {
        const double guess = inside + ahead + (trial % 3 == 0 ? -0.4 : 0.4) * width;
        if (guess > inside && guess < outside)
          s = guess;
      }
    }
    const Vec3d x = start + s * d;
    if (const query::Location found = locate(x, at.cell, alpha)) {
      inside = s;
      at = {x, found.cell};
    } else {
      outside = s;
    }
  }
  return 1.0 - inside;
}

/// Takes a particle on a periodic side of the box to the opposite one, if that is inside the mesh.
bool Walls::pass_side(Spot& at, const Vec3d& d, const BoundaryEffect& boundary,
                      double alpha) const {
  const Vec3d near = 1e3 * skin(at, alpha);
  for (int a = 0; a < 3; ++a) {
    const bool up = d[a] > 0.0;
    if (!boundary.periodic[a] || d[a] == 0.0 ||
        std::abs(at.x[a] - (up ? box_.high[a] : box_.low[a])) > near[a])
      continue;
    // On the other side itself, or just inside it where rounding has that face elsewhere.
    for (const double in : {0.0, 1.0, 1e3}) {
      Vec3d x = at.x;
      const double inward = in * near[a] * 1e-3;
      x[a] = up ? box_.low[a] + inward : box_.high[a] - inward;
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
  for (int contact = 0; contact < most_contacts; ++contact) {
    const Vec3d size = extent(at.cell, alpha);
    const double crossed = cells_crossed(d, size);
    if (!(crossed > 0.0))
      return Moved::inside; // nothing left, or NaN
    const int parts = int(std::clamp(std::ceil(crossed / part_cells), 1.0, double(most_parts)));
    const Vec3d part = d / double(parts);
    int k = 0;
    for (; k < parts; ++k) {
      const Vec3d x = at.x + part;
      const query::Location found = locate(x, at.cell, alpha);
      if (!found)
        break;
      at = {x, found.cell};
      length += length_of(part);
    }
    if (k == parts)
      return Moved::inside;
    const double left = advance_to_wall(at, part, alpha);
    length += (1.0 - left) * length_of(part);
    d = (left + double(parts - k - 1)) * part;
    if (pass_side(at, d, boundary, alpha)) {
      ++work_->contacts;
      continue;
    }
    if (boundary.response == AtBoundary::leave)
      return Moved::left;
    ++work_->contacts;
    if (boundary.response == AtBoundary::stop)
      return Moved::stopped;
    const Vec3d n = normal(at, d, alpha);
    if (n == Vec3d{})
      break;
    const bool mirror = boundary.response == AtBoundary::reflect;
    // In metres, where the wall is at right angles to its normal.
    const Vec3d per_metre = scale(at.x);
    Vec3d rest = over_axis(d, per_metre);
    rest -= ((mirror ? 2.0 : 1.0) * math::dot(rest, n)) * n;
    d = by_axis(rest, per_metre);
    if (const double out = carried ? math::dot(*carried, n) : 0.0; out > 0.0)
      *carried -= ((mirror ? 1.0 + boundary.restitution : 1.0) * out) * n;
  }
  ++work_->pinned;
  return Moved::inside;
}

Box box_of(const mesh::MeshView& mesh, const core::Threads& threads) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Box none{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  constexpr std::int64_t grain = 4096;
  std::vector<Box> boxes(std::size_t((mesh.cell_count() + grain - 1) / grain), none);
  threads.parallel_for(mesh.cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    Box& box = boxes[std::size_t(begin / grain)];
    mesh::CellVertices c;
    for (std::int64_t cell = begin; cell < end; ++cell) {
      const std::int32_t piece = mesh.piece_of(cell);
      if (!mesh.pieces[piece].owns(cell - mesh.first_cell[piece]))
        continue;
      mesh::gather(mesh, cell, c);
      for (int v = 0; v < c.count; ++v)
        for (int a = 0; a < 3; ++a) {
          box.low[a] = std::min(box.low[a], c.x[v][a]);
          box.high[a] = std::max(box.high[a], c.x[v][a]);
        }
    }
  });
  Box all = none;
  for (const Box& box : boxes)
    for (int a = 0; a < 3; ++a) {
      all.low[a] = std::min(all.low[a], box.low[a]);
      all.high[a] = std::max(all.high[a], box.high[a]);
    }
  return all;
}

} // namespace insitu::advect
