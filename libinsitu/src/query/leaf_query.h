#pragma once

#include <cmath>
#include <cstdint>

#include "amr/leaf_map.h"
#include "query/sampler.h"

namespace insitu::query {

/// Finds the leaves of an adaptive mesh that own points (`nearest` reconstruction). Remembers the
/// last brick of leaves, since neighbours mostly lie in one.
class LeafFinder {
public:
  explicit LeafFinder(const amr::LeafMap& leaves) : leaves_(&leaves), lattice_(leaves.lattice()) {
    for (int a = 0; a < 3; ++a)
      per_unit_[a] = 1.0 / lattice_.spacing[a];
  }

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
    at.cell = leaf.id;
    int faces = 0;
    for (int a = 0; a < 3; ++a) {
      const double low = lattice_.place(a, leaf.cell.depth, 2 * leaf.cell.index[a]);
      const double high = lattice_.place(a, leaf.cell.depth, 2 * leaf.cell.index[a] + 2);
      at.parametric[a] = (p[a] - low) / (high - low);
      faces += p[a] == low || p[a] == high;
    }
    reason = on_faces[faces];
    return true;
  }

private:
  using Store = amr::BrickStore;
  static constexpr Reason on_faces[] = {Reason::certified, Reason::on_face, Reason::on_edge,
                                        Reason::on_vertex};

  /// Takes the brick whose leaf holds p, as far as rounding tells, from the last one's depth on.
  bool go_to(const math::Vec3d& p) {
    const Store& store = leaves_->store();
    int way = 0; // to finer depths, or to coarser ones
    for (int depth = depth_; depth >= 0 && depth < store.depth_count(); depth += way) {
      const double scale = double(std::int64_t(1) << depth);
      std::int64_t index[3];
      for (int a = 0; a < 3; ++a) {
        const double steps = (p[a] - lattice_.origin[a]) * (per_unit_[a] * scale);
        if (!(std::fabs(steps) < double(2 * mesh::Lattice::largest_index)))
          return false;
        index[a] = std::int64_t(steps);
        index[a] -= steps < double(index[a]);
      }
      const std::uint32_t brick = store.find(depth, Store::key_of(index));
      const std::uint32_t entry = brick == amr::BrickTable::none
                                      ? Store::nothing
                                      : store.entries(brick)[Store::entry_of(index)];
      if (Store::is_leaf(entry)) {
        take(depth, brick);
        return true;
      }
      const int next = entry == Store::nothing ? -1 : 1;
      if (next == -way)
        return false;
      way = next;
    }
    return false;
  }

  void take(int depth, std::uint32_t brick) {
    depth_ = depth;
    entries_ = leaves_->store().entries(brick);
    const amr::BrickKey& key = leaves_->store().key(brick);
    const std::int64_t index[3] = {key.x, key.y, key.z};
    const double scale = double(std::int64_t(1) << depth);
    for (int a = 0; a < 3; ++a) {
      first_half_[a] = 2 * Store::side * index[a];
      start_[a] = lattice_.place(a, depth, first_half_[a]);
      steps_a_unit_[a] = per_unit_[a] * scale;
      // Some units in the last place of the coordinates, in steps.
      rounding_[a] = 0x1p-49 * (std::fabs(start_[a]) * steps_a_unit_[a] + 16.0);
    }
  }

  bool in_last_brick(const math::Vec3d& p, Location& at, Reason& reason) const {
    return entries_ && (inside(p, at, reason) || near_faces(p, at, reason));
  }

  /// Almost all points strictly inside of the brick's leaves, and none else.
  bool inside(const math::Vec3d& p, Location& at, Reason& reason) const {
    double part[3];
    int entry = 0;
    bool sure = true;
    for (int a = 0; a < 3; ++a) {
      const double steps = (p[a] - start_[a]) * steps_a_unit_[a];
      if (!(steps > 0.0 && steps < Store::side))
        return false;
      const int i = int(steps);
      part[a] = steps - i;
      sure &= part[a] > rounding_[a] && part[a] < 1.0 - rounding_[a];
      entry |= i << (3 * a);
    }
    if (!sure || !Store::is_leaf(entries_[entry]))
      return false;
    at.cell = entries_[entry];
    for (int a = 0; a < 3; ++a)
      at.parametric[a] = part[a];
    reason = Reason::certified;
    return true;
  }

  /// Points on faces of leaves, or too near to tell: by comparing with the faces, where all leaves
  /// that may hold them lie in the last brick.
  bool near_faces(const math::Vec3d& p, Location& at, Reason& reason) const {
    int lowest[3], choices[3], faces = 0;
    double face[3][3]; // of the one or two leaves along each axis
    for (int a = 0; a < 3; ++a) {
      const auto place = [&](int i) { return lattice_.place(a, depth_, first_half_[a] + 2 * i); };
      const double steps = (p[a] - start_[a]) * steps_a_unit_[a];
      if (!(steps > 0.0 && steps < Store::side))
        return false;
      int i = int(steps + 0.5); // the nearest face
      const double nearest = place(i);
      const bool on_face = p[a] == nearest;
      i -= p[a] <= nearest;
      if (i < 0 || i + on_face >= Store::side)
        return false;
      lowest[a] = i;
      choices[a] = 1 + on_face;
      faces += on_face;
      face[a][0] = place(i);
      face[a][1] = place(i + 1);
      face[a][2] = place(i + 2);
    }
    std::uint32_t id = Store::nothing;
    int chosen[3] = {0, 0, 0};
    for (int k = 0; k < choices[2]; ++k)
      for (int j = 0; j < choices[1]; ++j)
        for (int i = 0; i < choices[0]; ++i) {
          const std::uint32_t entry =
              entries_[lowest[0] + i +
                       Store::side * (lowest[1] + j + Store::side * (lowest[2] + k))];
          if (!Store::is_leaf(entry))
            return false;
          if (entry > id)
            continue;
          id = entry;
          chosen[0] = i, chosen[1] = j, chosen[2] = k;
        }
    at.cell = id;
    for (int a = 0; a < 3; ++a) {
      const double low = face[a][chosen[a]], high = face[a][chosen[a] + 1];
      at.parametric[a] = (p[a] - low) / (high - low);
    }
    reason = on_faces[faces];
    return true;
  }

  const amr::LeafMap* leaves_;
  mesh::Lattice lattice_;
  double per_unit_[3]; ///< cells of depth 0
  // Of the last brick:
  int depth_ = 0;
  const std::uint32_t* entries_ = nullptr;
  std::int64_t first_half_[3] = {0, 0, 0};
  double start_[3], steps_a_unit_[3], rounding_[3];
};

} // namespace insitu::query
