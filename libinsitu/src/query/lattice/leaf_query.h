#pragma once

#include <cstdint>

#include "amr/leaves/leaf_map.h"
#include "query/lattice/leaf_lanes.h"
#include "query/location.h"

namespace insitu::query {

/// Finds the leaves of an adaptive mesh that own points (`nearest` reconstruction). Remembers the
/// last brick of leaves, since neighbours mostly lie in one.
class LeafFinder {
public:
  explicit LeafFinder(const amr::LeafMap& leaves)
      : leaves_(&leaves), box_(leaves), others_{box_, box_} {}

  static constexpr bool finds_all = true;

  /// Whether a leaf holds p, and then the lowest closed one (at: left alone otherwise); none
  /// outside, and for points that are not finite.
  bool find(const math::Vec3d& p, Location& at, Reason& reason) {
    if (in_last_brick(p, at, reason) || (go_to(p) && in_last_brick(p, at, reason)))
      return true;
    const amr::LeafMap::Leaf leaf = leaves_->lowest(p);
    if (!leaf) {
      reason = Reason::outside;
      return false;
    }
    std::uint32_t entry;
    (void)box_.take(leaf.cell.depth, leaf.cell.index, entry); // is there
    at.cell = leaf.id;
    int faces = 0;
    for (int a = 0; a < 3; ++a) {
      const int i = int(leaf.cell.index[a] & (Store::side - 1));
      const bool on_low = p[a] == face(a, i), on_high = p[a] == face(a, i + 1);
      faces += on_low || on_high;
      at.parametric[a] = part_in(i, steps(p, a), on_low, on_high);
    }
    reason = on_faces[faces];
    return true;
  }

  /// find() of a batch's points from the q-th on, as long as they lie in leaves of its depth;
  /// returns the next.
  std::size_t find_ahead(std::span<const math::Vec3d> points, std::size_t q, BatchAnswers& to) {
    return box_.entries && points.size() - q >= 8 && is_near(points[q + 3])
               ? q + leaves_ahead(box_, others_, &points[q], points.size() - q, &to.locations[q],
                                  &to.reasons[q])
               : q;
  }

private:
  using Store = amr::BrickStore;
  static constexpr Reason on_faces[] = {Reason::certified, Reason::on_face, Reason::on_edge,
                                        Reason::on_vertex};

  /// Takes the brick whose leaf holds p, as far as rounding tells, from the last one's depth on.
  bool go_to(const math::Vec3d& p) {
    int way = 0; // to finer depths, or to coarser ones
    for (int depth = box_.depth; depth >= 0 && depth < leaves_->depth_count(); depth += way) {
      std::uint32_t entry;
      if (box_.take_at(depth, p, entry))
        return true;
      const int next = entry == Store::nothing ? -1 : 1;
      if (next == -way)
        return false;
      way = next;
    }
    return false;
  }

  /// Whether p lies in the last brick, or in one beside it that leaves_ahead can go on to, about:
  /// then what comes before p most likely does too.
  bool is_near(const math::Vec3d& p) const {
    const double around = box_.order ? double(Store::side) : 0.0;
    bool near = true;
    for (int a = 0; a < 3; ++a)
      near &= steps(p, a) > -around && steps(p, a) < Store::side + around;
    return near;
  }

  /// Where p lies from the brick's lower corner, in leaves.
  double steps(const math::Vec3d& p, int axis) const {
    return (p[axis] - box_.start[axis]) * box_.steps_a_unit[axis];
  }
  /// The lower face of the brick's leaf i.
  double face(int axis, int i) const {
    return box_.lattice.place(axis, box_.depth, box_.first_half[axis] + 2 * i);
  }
  /// The parametric coordinate in leaf i; exact on its faces.
  static double part_in(int i, double steps, bool on_low, bool on_high) {
    const double part = steps - i;
    return on_low ? 0.0 : on_high ? 1.0 : part < 0.0 ? 0.0 : part > 1.0 ? 1.0 : part;
  }

  /// False too where a leaf that may hold p lies in another brick.
  bool in_last_brick(const math::Vec3d& p, Location& at, Reason& reason) const {
    if (!box_.entries)
      return false;
    double place[3];
    int lowest[3];
    bool sure = true;
    for (int a = 0; a < 3; ++a) {
      place[a] = steps(p, a);
      if (!(place[a] > 0.0 && place[a] < Store::side))
        return false;
      lowest[a] = int(place[a]);
      const double part = place[a] - lowest[a];
      sure &= part > box_.rounding[a] && part < 1.0 - box_.rounding[a];
    }
    if (!sure)
      return near_faces(p, place, at, reason);
    const std::uint32_t entry = box_.entry(lowest[0], lowest[1], lowest[2]);
    if (!Store::is_leaf(entry))
      return false;
    at.cell = entry;
    for (int a = 0; a < 3; ++a)
      at.parametric[a] = place[a] - lowest[a];
    reason = Reason::certified;
    return true;
  }

  /// The same for points on faces of leaves, or too near to tell, by comparing with the faces.
  /// place: steps().
  bool near_faces(const math::Vec3d& p, const double* place, Location& at, Reason& reason) const {
    int lowest[3];
    bool on_face[3];
    for (int a = 0; a < 3; ++a) {
      const int nearest = int(place[a] + 0.5);
      const double of = face(a, nearest);
      on_face[a] = p[a] == of;
      lowest[a] = nearest - (p[a] <= of);
      if (lowest[a] < 0 || lowest[a] + on_face[a] >= Store::side)
        return false;
    }
    std::uint32_t id = Store::nothing;
    int chosen[3] = {0, 0, 0};
    for (int k = lowest[2]; k <= lowest[2] + on_face[2]; ++k)
      for (int j = lowest[1]; j <= lowest[1] + on_face[1]; ++j)
        for (int i = lowest[0]; i <= lowest[0] + on_face[0]; ++i) {
          const std::uint32_t entry = box_.entry(i, j, k);
          if (!Store::is_leaf(entry))
            return false;
          if (entry > id)
            continue;
          id = entry;
          chosen[0] = i, chosen[1] = j, chosen[2] = k;
        }
    at.cell = id;
    for (int a = 0; a < 3; ++a)
      at.parametric[a] = part_in(chosen[a], place[a], on_face[a] && chosen[a] > lowest[a],
                                 on_face[a] && chosen[a] == lowest[a]);
    reason = on_faces[on_face[0] + on_face[1] + on_face[2]];
    return true;
  }

  const amr::LeafMap* leaves_;
  BrickBox box_;       ///< the last brick
  BrickBox others_[2]; ///< for leaves_ahead
};

} // namespace insitu::query
