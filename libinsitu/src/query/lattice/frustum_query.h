#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "amr/dual/corner_map.h"
#include "query/lattice/frustum_sides.h"

/// Points in stitching cells that are frusta: without a tree and without Newton's method, since
/// the cells' sections across one axis are rectangles.
namespace insitu::query {

/// Finds frusta by their places. What it answers is proven by bounds on rounding, and for points on
/// or very near one of a frustum's sides by exact arithmetic: on sides the lowest id of the two or
/// four frusta there owns. Boxes likewise, but for points on their faces.
class FrustumFinder {
public:
  /// first_cell: the flat id of the first stitching cell. shown: a bit a stitching cell, from bit
  /// `first_shown` on, whether it may answer; null: all.
  FrustumFinder(const amr::CornerMap& map, const mesh::Lattice& lattice, std::int64_t first_cell,
                const std::uint64_t* shown = nullptr, std::int64_t first_shown = 0)
      : map_(&map), sides_(lattice, map), shown_(shown), first_cell_(first_cell),
        first_shown_(first_shown) {}

  /// The stitching cell at a corner of a depth, of any kind, or none.
  amr::CornerMap::Found cell_at(int depth, const std::int64_t* corner) const {
    return depth < map_->depth_count() ? map_->find(depth, corner) : amr::CornerMap::Found();
  }

  /// Whether a frustum or box of a depth owns p: `found`, which has the corner nearest to p, or a
  /// frustum beside it; and then which (at: left alone otherwise), or none where that is not shown.
  /// guess: another cell at that corner, or left alone.
  bool find_at(const math::Vec3d& p, int depth, const std::int64_t* corner,
               const amr::CornerMap::Found& found, Location& at, Reason& reason,
               std::int64_t& guess) {
    const Place place = sides_.place(p, depth);
    if (found.kind.is_box())
      return in_box(p, place, corner, found, at, reason);
    if (found.kind.is_frustum())
      return in_frustum(p, place, found.kind, corner[found.kind.axis()], at, reason, guess);
    propose(found, guess);
    return false;
  }

  /// Whether there are frusta of a depth beside leaves `up` depths above.
  bool has_frusta(int depth, int up) const {
    return depth < map_->depth_count() && map_->has_frusta(depth, up);
  }
  /// The same for points in a leaf `up` depths above, further than half a cell of the depth.
  bool find_within(const math::Vec3d& p, int depth, int up, Location& at, Reason& reason,
                   std::int64_t& guess);

private:
  using Place = FrustumSides::Place;

  bool in_box(const math::Vec3d& p, const Place& place, const std::int64_t* corner,
              const amr::CornerMap::Found& found, Location& at, Reason& reason) const;
  bool in_frustum(const math::Vec3d& p, const Place& place, amr::CornerKind kind,
                  std::int64_t plane, Location& at, Reason& reason, std::int64_t& guess) {
    switch (kind.axis()) {
    case 0:
      return in_frustum_along<0>(p, place, kind, plane, at, reason, guess);
    case 1:
      return in_frustum_along<1>(p, place, kind, plane, at, reason, guess);
    default:
      return in_frustum_along<2>(p, place, kind, plane, at, reason, guess);
    }
  }
  template <int axis>
  bool in_frustum_along(const math::Vec3d& p, const Place& place, amr::CornerKind kind,
                        std::int64_t plane, Location& at, Reason& reason, std::int64_t& guess);
  bool shows(std::uint32_t cell) const {
    const std::int64_t bit = first_shown_ + cell;
    return !shown_ || ((shown_[bit >> 6] >> (bit & 63)) & 1) != 0;
  }
  void answer(std::uint32_t cell, Location& at, Reason& reason) const {
    at.cell = first_cell_ + cell;
    if (!shows(cell)) {
      at = {};
      reason = Reason::outside;
    }
  }
  void propose(const amr::CornerMap::Found& found, std::int64_t& guess) const {
    if (guess < 0 && found.is_here() && shows(found.cell))
      guess = first_cell_ + found.cell;
  }

  const amr::CornerMap* map_;
  FrustumSides sides_;
  const std::uint64_t* shown_;
  std::int64_t first_cell_, first_shown_;
};

// Implementation

inline bool FrustumFinder::find_within(const math::Vec3d& p, int depth, int up, Location& at,
                                       Reason& reason, std::int64_t& guess) {
  const Place place = sides_.place(p, depth);
  const std::int64_t half = std::int64_t(1) << (up - 1);
  std::int64_t centre[3]; // of the leaf
  for (int a = 0; a < 3; ++a)
    centre[a] = (place.floor[a] >> up) * 2 * half + half;
  for (int a = 0; a < 3; ++a) {
    // Finer leaves are beyond its face if a cell of theirs stands on the face's midst.
    const int side = place.floor[a] < centre[a]; // the leaf is above the face
    std::int64_t midst[3] = {centre[0], centre[1], centre[2]};
    midst[a] += side ? -half : half;
    const auto kind = amr::CornerKind::frustum(a, side, up);
    if (map_->find(depth, midst).kind == kind &&
        in_frustum(p, place, kind, midst[a], at, reason, guess))
      return true;
  }
  // Where its face meets the way from its centre through the point.
  double from_centre[3], farthest = 0.0;
  for (int a = 0; a < 3; ++a) {
    from_centre[a] = place.steps[a] - double(centre[a]);
    farthest = std::max(farthest, std::fabs(from_centre[a]));
  }
  std::int64_t corner[3];
  for (int a = 0; a < 3; ++a) {
    const double seen = farthest > 0.0 ? from_centre[a] * (double(half) / farthest) : 0.0;
    corner[a] = centre[a] - half + std::int64_t(seen + double(half) + 0.5);
  }
  amr::CornerMap::Found found = map_->find(depth, corner);
  if (!found) { // finer leaves lie beyond an edge or a corner of the leaf only
    for (int a = 0; a < 3; ++a)
      corner[a] = from_centre[a] < 0.0 ? centre[a] - half : centre[a] + half;
    found = map_->find(depth, corner);
  }
  if (found)
    propose(found, guess);
  return false;
}

inline bool FrustumFinder::in_box(const math::Vec3d& p, const Place& place,
                                  const std::int64_t* corner, const amr::CornerMap::Found& found,
                                  Location& at, Reason& reason) const {
  std::uint32_t moves = found.kind.moves();
  math::Vec3d r;
  for (int a = 0; a < 3; ++a, moves /= 3) {
    const double from_corner =
        (p[a] - sides_.lattice().place(a, place.depth, 2 * corner[a])) * place.steps_a_unit[a];
    const double low = moves % 3 == 1 ? 0.0 : -0.5, high = moves % 3 == 2 ? 0.0 : 0.5;
    const double within = from_corner - low;
    if (!(within > place.rounding[a] && high - from_corner > place.rounding[a]))
      return false;
    r[a] = moves % 3 == 0 ? within : 2.0 * within;
  }
  if (!found.is_here())
    return false; // of another process
  at.parametric = r;
  reason = Reason::certified;
  answer(found.cell, at, reason);
  return true;
}

/// In one of this kind whose corner lies in a plane across its axis.
template <int axis>
bool FrustumFinder::in_frustum_along(const math::Vec3d& p, const Place& place, amr::CornerKind kind,
                                     std::int64_t plane, Location& at, Reason& reason,
                                     std::int64_t& guess) {
  constexpr int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const int side = kind.side(), up = kind.up(), depth = place.depth;
  const std::int64_t leaf_width = std::int64_t(1) << up;
  const double half = double(leaf_width / 2);
  const double along =
      (p[axis] - sides_.lattice().place(axis, depth, 2 * plane)) * place.steps_a_unit[axis];
  const double to_coarse = half - (side ? along : -along), to_fine = half + 0.5 - to_coarse;
  const double rounding = place.rounding[axis] * (half + 0.5);
  if (!(to_coarse > rounding && to_fine > rounding))
    return false;
  const double length = up == 1 ? 1.0 / 1.5 : 1.0 / 2.5, coarse = to_fine * length,
               fine = to_coarse * length;
  // Seen from the centre of a coarser leaf, sections of its frusta are as far apart as corners.
  std::int64_t corner[3];
  corner[axis] = plane;
  for (const int a : {b, c}) {
    const std::int64_t leaf = place.floor[a] >> up;
    const double from_centre = place.steps[a] - (double(leaf) + 0.5) * double(leaf_width);
    const double seen = from_centre / fine + half; // from the leaf's lower face
    const double nearest = seen + 0.5 < double(leaf_width) ? seen + 0.5 : double(leaf_width);
    corner[a] = leaf * leaf_width + std::int64_t(nearest > 0.0 ? nearest : 0.0);
  }
  const FrustumSides::Sections at_point = {kind, coarse, fine, 2.0 * rounding};
  double part[3];
  part[axis] = coarse;
  reason = Reason::certified;
  int on_b = 0, on_c = 0;
  if (!sides_.within(p, place, at_point, corner, b, part[b], on_b, reason) ||
      !sides_.within(p, place, at_point, corner, c, part[c], on_c, reason))
    return false;
  amr::CornerMap::Found found = map_->find(depth, corner);
  if (!(found.kind == kind)) {
    if (found)
      propose(found, guess);
    return false;
  }
  if (on_b || on_c) { // of the two or four frusta there the lowest id owns
    reason = on_b && on_c ? Reason::on_edge : Reason::on_face;
    const std::int64_t from[3] = {corner[0], corner[1], corner[2]};
    const double part_b = part[b], part_c = part[c];
    for (const bool move_c : {false, true})
      for (const bool move_b : {false, true}) {
        if ((!move_b && !move_c) || (move_b && !on_b) || (move_c && !on_c))
          continue;
        std::int64_t to[3] = {from[0], from[1], from[2]};
        to[b] += move_b ? on_b : 0;
        to[c] += move_c ? on_c : 0;
        const amr::CornerMap::Found other = map_->find(depth, to);
        if (!(other.kind == kind))
          return false;
        if (other.cell > found.cell)
          continue;
        found = other;
        corner[b] = to[b];
        corner[c] = to[c];
        part[b] = move_b ? 1.0 - part_b : part_b;
        part[c] = move_c ? 1.0 - part_c : part_c;
      }
  }
  if (!found.is_here())
    return false; // of another process
  // As amr/dual/dual_cells.cpp orders the vertices.
  const auto shares = [&](int a) { return (corner[a] & (leaf_width - 1)) != 0; }; // one leaf
  if (shares(b) && shares(c)) {
    at.parametric = {part[side ? b : c], part[side ? c : b], coarse};
  } else if (shares(b) || shares(c)) {
    const int of = shares(b) ? b : c, turn = (axis - of + 3) % 3;
    const bool turned = (turn == 1) == (side == 1);
    const double across = turned ? 1.0 - part[of] : part[of];
    // On the slanted face, exactly: fine and coarse sum to 1 but for rounding.
    at.parametric = {across == 1.0 ? 1.0 - coarse : across * fine, coarse, part[shares(b) ? c : b]};
  } else {
    part[axis] = side ? coarse : fine;
    at.parametric = {part[0], part[1], part[2]};
  }
  answer(found.cell, at, reason);
  return true;
}

} // namespace insitu::query
