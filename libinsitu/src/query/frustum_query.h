#pragma once

#include <cmath>
#include <cstdint>

#include "amr/corner_map.h"
#include "math/expansion.h"
#include "mesh/lattice.h"
#include "query/sampler.h"

/// Points in stitching cells that are frusta: without a tree and without Newton's method, since
/// the cells' sections across one axis are rectangles.
namespace insitu::query {

/// Finds frusta by their places. What it answers is proven by bounds on rounding, and for points on
/// or very near one of a frustum's sides by exact arithmetic: on sides the lowest id of the two or
/// four frusta there owns. Remembers the last frustum, since neighbours often lie in one like it.
class FrustumFinder {
public:
  /// first_cell: the flat id of the first stitching cell. shown: a bit a stitching cell, from bit
  /// `first_shown` on, whether it may answer; null: all.
  FrustumFinder(const amr::CornerMap& map, const mesh::Lattice& lattice, std::int64_t first_cell,
                const std::uint64_t* shown = nullptr, std::int64_t first_shown = 0)
      : map_(&map), lattice_(&lattice), shown_(shown), first_cell_(first_cell),
        first_shown_(first_shown) {
    for (int a = 0; a < 3; ++a)
      per_unit_[a] = 1.0 / lattice.spacing[a];
  }

  /// Whether a frustum or box of a depth owns p that has the corner nearest to p, or a frustum
  /// beside it, and then which (at: left alone otherwise), or none where that is not shown. guess:
  /// another cell at that corner, or left alone.
  bool find_at(const math::Vec3d& p, int depth, const std::int64_t* corner, Location& at,
               Reason& reason, std::int64_t& guess) {
    const amr::CornerMap::Found found = map_->find(depth, corner);
    if (!found)
      return false;
    const Place place(*this, p, depth);
    if (found.kind.is_box())
      return in_box(p, place, corner, found, at, reason);
    if (found.kind.is_frustum())
      return in_frustum(p, place, found.kind, corner[found.kind.axis()], at, reason, guess);
    propose(found.cell, guess);
    return false;
  }

  /// The same for frusta of the last one's kind, in its plane, such that find_at() or find_within()
  /// find for the point alone. is_leaf(depth, index): whether that cell is a leaf.
  template <class IsLeaf>
  bool find_like_last(const math::Vec3d& p, Location& at, Reason& reason, IsLeaf&& is_leaf);

  /// Whether there are frusta of a depth beside leaves `up` depths above.
  bool has_frusta(int depth, int up) const {
    return depth < map_->depth_count() && map_->has_frusta(depth, up);
  }
  /// The same for points in a leaf `up` depths above, further than half a cell of the depth.
  bool find_within(const math::Vec3d& p, int depth, int up, Location& at, Reason& reason,
                   std::int64_t& guess);

private:
  static constexpr int unknown = 2;

  /// Frusta of a kind whose corners lie in a plane across its axis.
  struct Plane {
    int depth = -1; ///< -1: none
    amr::CornerKind kind;
    std::int64_t plane = 0;
    double low = 0.0, high = 0.0; ///< about: their ends
  };

  /// A point as a depth sees it.
  struct Place {
    Place(const FrustumFinder& finder, const math::Vec3d& p, int depth);
    int depth;
    double steps_a_unit[3];
    double steps[3];    ///< cells from the lattice's origin
    double rounding[3]; ///< of differences of coordinates there, in cells
    std::int64_t floor[3];
  };
  /// Across the section at the point, along one axis, cells from the corner.
  struct Section {
    double low, high;
  };

  /// The sections of frusta of a kind at the point: weights of the coarser leaves' rectangle and of
  /// the others'.
  struct Sections {
    amr::CornerKind kind;
    double coarse, fine;
    double rounding; ///< of their sides, in cells
  };

  static std::int64_t nearest_corner(const Place& place, int axis) {
    return place.floor[axis] + (place.steps[axis] - double(place.floor[axis]) >= 0.5);
  }
  bool in_box(const math::Vec3d& p, const Place& place, const std::int64_t* corner,
              const amr::CornerMap::Found& found, Location& at, Reason& reason) const;
  bool in_frustum(const math::Vec3d& p, const Place& place, amr::CornerKind kind,
                  std::int64_t plane, Location& at, Reason& reason, std::int64_t& guess);
  bool within_sides(const math::Vec3d& p, const Place& place, const Sections& at_point,
                    std::int64_t* corner, int axis, double& part, int& on, Reason& reason) const;
  int side_of(const math::Vec3d& p, int depth, amr::CornerKind kind, const std::int64_t* corner,
              int axis, int direction) const;
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
  void propose(std::uint32_t cell, std::int64_t& guess) const {
    if (guess < 0 && shows(cell))
      guess = first_cell_ + cell;
  }

  /// From the corner to the coarser leaves' centres along an axis across the frustum's, in cells.
  static Section coarse_section(std::int64_t corner, int up) {
    const std::int64_t width = std::int64_t(1) << up, past = corner & (width - 1);
    const double half = double(width / 2);
    return past == 0 ? Section{-half, half} : Section{half - double(past), half - double(past)};
  }

  const amr::CornerMap* map_;
  const mesh::Lattice* lattice_;
  const std::uint64_t* shown_;
  std::int64_t first_cell_, first_shown_;
  double per_unit_[3]; ///< cells of depth 0
  Plane last_plane_;   ///< that of the last frustum
};

// Implementation

inline FrustumFinder::Place::Place(const FrustumFinder& finder, const math::Vec3d& p, int d)
    : depth(d) {
  const double scale = double(std::int64_t(1) << d);
  for (int a = 0; a < 3; ++a) {
    const double from_origin = p[a] - finder.lattice_->origin[a];
    steps_a_unit[a] = finder.per_unit_[a] * scale;
    steps[a] = from_origin * steps_a_unit[a];
    // Those far from all cells are as good as none.
    const double near = std::fabs(steps[a]) < double(mesh::Lattice::largest_index) ? steps[a] : 0.0;
    floor[a] = std::int64_t(near);
    floor[a] -= near < double(floor[a]);
    // Some units in the last place of the coordinates around, of those from the origin, and of
    // distances of a few cells.
    rounding[a] = 0x1p-49 * ((std::fabs(p[a]) + std::fabs(from_origin)) * steps_a_unit[a] + 16.0);
  }
}

inline bool FrustumFinder::find_within(const math::Vec3d& p, int depth, int up, Location& at,
                                       Reason& reason, std::int64_t& guess) {
  const Place place(*this, p, depth);
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
    farthest = std::fmax(farthest, std::fabs(from_centre[a]));
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
    propose(found.cell, guess);
  return false;
}

inline bool FrustumFinder::in_box(const math::Vec3d& p, const Place& place,
                                  const std::int64_t* corner, const amr::CornerMap::Found& found,
                                  Location& at, Reason& reason) const {
  std::uint32_t moves = found.kind.moves();
  math::Vec3d r;
  for (int a = 0; a < 3; ++a, moves /= 3) {
    const double from_corner =
        (p[a] - lattice_->place(a, place.depth, 2 * corner[a])) * place.steps_a_unit[a];
    const double low = moves % 3 == 1 ? 0.0 : -0.5, high = moves % 3 == 2 ? 0.0 : 0.5;
    const double within = from_corner - low;
    if (!(within > place.rounding[a] && high - from_corner > place.rounding[a]))
      return false;
    r[a] = within / (high - low);
  }
  at.parametric = r;
  reason = Reason::certified;
  answer(found.cell, at, reason);
  return true;
}

template <class IsLeaf>
inline bool FrustumFinder::find_like_last(const math::Vec3d& p, Location& at, Reason& reason,
                                          IsLeaf&& is_leaf) {
  const int depth = last_plane_.depth, axis = last_plane_.kind.axis();
  const amr::CornerKind kind = last_plane_.kind;
  const std::int64_t plane = last_plane_.plane;
  if (depth < 0 || !(p[axis] > last_plane_.low && p[axis] < last_plane_.high))
    return false;
  const Place place(*this, p, depth);
  const bool in_coarser = (place.floor[axis] >= plane) == (kind.side() == 1);
  const int up = in_coarser ? kind.up() : 0;
  std::int64_t leaf[3], corner[3];
  for (int a = 0; a < 3; ++a) {
    leaf[a] = place.floor[a] >> up;
    corner[a] = nearest_corner(place, a);
  }
  if (!is_leaf(depth - up, leaf))
    return false;
  const auto is_like = [&] {
    return corner[axis] == plane && map_->find(depth, corner).kind == kind;
  };
  if (!is_like()) {
    if (!in_coarser)
      return false;
    const std::int64_t half = std::int64_t(1) << (up - 1);
    for (int a = 0; a < 3; ++a)
      corner[a] = a == axis ? plane : leaf[a] * 2 * half + half;
    if (!is_like())
      return false;
  }
  std::int64_t no_guess = 0;
  return in_frustum(p, place, kind, plane, at, reason, no_guess);
}

/// In one of this kind whose corner lies in a plane across its axis.
inline bool FrustumFinder::in_frustum(const math::Vec3d& p, const Place& place,
                                      amr::CornerKind kind, std::int64_t plane, Location& at,
                                      Reason& reason, std::int64_t& guess) {
  const int axis = kind.axis(), side = kind.side(), up = kind.up(), depth = place.depth;
  const std::int64_t leaf_width = std::int64_t(1) << up;
  const double half = double(leaf_width / 2);
  const double along =
      (p[axis] - lattice_->place(axis, depth, 2 * plane)) * place.steps_a_unit[axis];
  const double to_coarse = half - (side ? along : -along), to_fine = half + 0.5 - to_coarse;
  const double rounding = place.rounding[axis] * (half + 0.5);
  if (!(to_coarse > rounding && to_fine > rounding))
    return false;
  const double length = 1.0 / (half + 0.5), coarse = to_fine * length, fine = to_coarse * length;
  // Seen from the centre of a coarser leaf, sections of its frusta are as far apart as corners.
  std::int64_t corner[3];
  corner[axis] = plane;
  for (const int b : {(axis + 1) % 3, (axis + 2) % 3}) {
    const std::int64_t leaf = place.floor[b] >> up;
    const double from_centre = place.steps[b] - (double(leaf) + 0.5) * double(leaf_width);
    const double seen = from_centre / fine + half; // from the leaf's lower face
    corner[b] =
        leaf * leaf_width +
        (seen > 0.0 ? seen < double(leaf_width) ? std::int64_t(seen + 0.5) : leaf_width : 0);
  }
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const Sections at_point = {kind, coarse, fine, 2.0 * rounding};
  double part[3];
  part[axis] = coarse;
  reason = Reason::certified;
  int on_b = 0, on_c = 0;
  if (!within_sides(p, place, at_point, corner, b, part[b], on_b, reason) ||
      !within_sides(p, place, at_point, corner, c, part[c], on_c, reason))
    return false;
  amr::CornerMap::Found found = map_->find(depth, corner);
  if (!(found.kind == kind)) {
    if (found)
      propose(found.cell, guess);
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
  // As amr/dual_cells.cpp orders the vertices.
  const auto shares = [&](int a) { return (corner[a] & (leaf_width - 1)) != 0; }; // one leaf
  if (shares(b) && shares(c)) {
    at.parametric = {part[side ? b : c], part[side ? c : b], coarse};
  } else if (shares(b) || shares(c)) {
    const int of = shares(b) ? b : c, turn = (axis - of + 3) % 3;
    const bool turned = (turn == 1) == (side == 1);
    at.parametric = {(turned ? 1.0 - part[of] : part[of]) * fine, coarse, part[shares(b) ? c : b]};
  } else {
    part[axis] = side ? coarse : fine;
    at.parametric = {part[0], part[1], part[2]};
  }
  answer(found.cell, at, reason);
  if (last_plane_.depth != depth || last_plane_.plane != plane || !(last_plane_.kind == kind)) {
    const std::int64_t to = side ? 1 : -1;
    const double ends[2] = {lattice_->place(axis, depth, 2 * plane - to),
                            lattice_->place(axis, depth, 2 * plane + to * leaf_width)};
    last_plane_ = {depth, kind, plane, ends[1 - side], ends[side]};
  }
  return true;
}

/// Moves the corner along an axis across the frusta's to the one whose sides p is between, as far
/// as floating point and exact arithmetic can tell, from the next one at most. part: of the way
/// from its lower side. on: 0, or the direction of the side that p is on.
inline bool FrustumFinder::within_sides(const math::Vec3d& p, const Place& place,
                                        const Sections& at_point, std::int64_t* corner, int axis,
                                        double& part, int& on, Reason& reason) const {
  const double near = place.rounding[axis] + at_point.rounding; // where rounding may err
  double above, below;
  const auto look = [&] {
    const Section centres = coarse_section(corner[axis], at_point.kind.up());
    const double x =
        (p[axis] - lattice_->place(axis, place.depth, 2 * corner[axis])) * place.steps_a_unit[axis];
    above = x - (at_point.coarse * centres.low - 0.5 * at_point.fine);
    below = (at_point.coarse * centres.high + 0.5 * at_point.fine) - x;
    part = above / (above + below);
    return above + below > 8.0 * near;
  };
  const bool wide = look();
  if (above > near && below > near)
    return true;
  const int direction = above > below ? 1 : -1;
  if (!wide || !(std::fmin(above, below) > -2.0 * near))
    return false; // too near to the apex, or a wrong guess
  const int where = side_of(p, place.depth, at_point.kind, corner, axis, direction);
  if (where == unknown)
    return false;
  if (where < 0) {
    corner[axis] += direction;
    if (!look())
      return false;
  }
  part = std::fmin(std::fmax(part, 0.0), 1.0);
  if (where == 0) {
    on = direction;
    part = direction > 0 ? 1.0 : 0.0;
  }
  reason = Reason::exact;
  return true;
}

/// On which side of a frustum's side a point lies that is between its ends: 1 within, 0 on it, -1
/// beyond, or unknown. The side is that along an axis in a direction, -1 or 1.
inline int FrustumFinder::side_of(const math::Vec3d& p, int depth, amr::CornerKind kind,
                                  const std::int64_t* corner, int axis, int direction) const {
  const int across = kind.axis(), to = kind.side() ? 1 : -1;
  const std::int64_t width = std::int64_t(1) << kind.up();
  const Section centres = coarse_section(corner[axis], kind.up());
  const auto place = [&](int a, std::int64_t halves) { return lattice_->place(a, depth, halves); };
  const double fine_x = place(axis, 2 * corner[axis] + direction);
  const double coarse_x =
      place(axis, 2 * corner[axis] + 2 * std::int64_t(direction > 0 ? centres.high : centres.low));
  const double fine_z = place(across, 2 * corner[across] - to);
  const double coarse_z = place(across, 2 * corner[across] + to * width);
  // The sign of (p - fine)_x (coarse - fine)_z - (p - fine)_z (coarse - fine)_x.
  const math::DoubleDouble x = math::two_difference(p[axis], fine_x),
                           z = math::two_difference(p[across], fine_z),
                           rise = math::two_difference(coarse_z, fine_z),
                           run = math::two_difference(coarse_x, fine_x);
  if (x.lo != 0.0 || z.lo != 0.0 || rise.lo != 0.0 || run.lo != 0.0)
    return unknown;
  constexpr double least = 0x1p-900, most = 0x1p900; // of exact products
  const math::DoubleDouble left = math::two_product(x.hi, rise.hi),
                           right = math::two_product(z.hi, run.hi);
  for (const double size : {std::fabs(left.hi), std::fabs(right.hi)})
    if (size != 0.0 && !(size > least && size < most))
      return unknown;
  // Products rounded to nearest keep their order.
  const int sign = left.hi != right.hi   ? (left.hi > right.hi ? 1 : -1)
                   : left.lo != right.lo ? (left.lo > right.lo ? 1 : -1)
                                         : 0;
  return -sign * direction * (rise.hi > 0.0 ? 1 : -1);
}

} // namespace insitu::query
