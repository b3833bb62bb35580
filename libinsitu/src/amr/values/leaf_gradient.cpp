#include "amr/values/leaf_gradient.h"

#include <algorithm>
#include <cmath>

namespace insitu::amr {

namespace {

using math::Vec3d;

/// Inverts a symmetric matrix along the axes that it spans, by elimination with the largest pivots;
/// zero along the others.
void invert(const double (&matrix)[3][3], double (&inverse)[3][3]) {
  constexpr double least_pivot = 0.02;
  double m[3][3], r[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) {
    std::copy_n(matrix[i], 3, m[i]);
    largest = std::max(largest, m[i][i]);
  }
  bool done[3] = {};
  for (int step = 0; step < 3; ++step) {
    int p = -1;
    for (int i = 0; i < 3; ++i)
      if (!done[i] && (p < 0 || m[i][i] > m[p][p]))
        p = i;
    if (!(m[p][p] > least_pivot * largest))
      break;
    done[p] = true;
    const double pivot = m[p][p];
    for (int j = 0; j < 3; ++j) {
      m[p][j] /= pivot;
      r[p][j] /= pivot;
    }
    for (int i = 0; i < 3; ++i) {
      const double factor = m[i][p];
      for (int j = 0; i != p && j < 3; ++j) {
        m[i][j] -= factor * m[p][j];
        r[i][j] -= factor * r[p][j];
      }
    }
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      inverse[i][j] = done[i] && done[j] ? r[i][j] : 0.0;
}

} // namespace

LeafGradient::LeafGradient(const BrickStore& store, const mesh::AmrView& mesh, std::uint32_t id,
                           const mesh::AmrCell& leaf)
    : id_(id), leaf_(leaf), axes_(mesh.lattice.is_flat != 0 ? 2 : 3) {
  for (int a = 0; a < axes_; ++a)
    for (int side = 0; side < 2; ++side)
      across(store, mesh, a, side);
}

void LeafGradient::add(std::uint32_t id, std::uint8_t ghost, int depth, const std::int64_t* index) {
  Neighbor& n = list_[count_++];
  n.id = id;
  n.ghost = ghost;
  const double size = std::ldexp(1.0, leaf_.depth - depth);
  for (int a = 0; a < axes_; ++a)
    n.offset[a] = (double(index[a]) + 0.5) * size - (double(leaf_.index[a]) + 0.5);
  n.weight = 1.0 / math::dot(n.offset, n.offset);
}

void LeafGradient::across(const BrickStore& store, const mesh::AmrView& mesh, int axis, int side) {
  std::int64_t index[3] = {leaf_.index[0], leaf_.index[1], leaf_.index[2]};
  index[axis] += side ? 1 : -1;
  const std::uint32_t entry = store.at(leaf_.depth, index);
  const int before = count_;
  int up = 0;
  if (BrickStore::is_leaf(entry))
    add(entry, no_ghost, leaf_.depth, index);
  else if (entry != BrickStore::nothing)
    for (int quarter = 0; quarter < 4; ++quarter)
      descend(store, axis, side, quarter, index);
  else if (const std::uint32_t id = store.above(leaf_.depth, index, &up);
           id != BrickStore::nothing) {
    const std::int64_t coarse[3] = {index[0] >> up, index[1] >> up, index[2] >> up};
    add(id, no_ghost, leaf_.depth - up, coarse);
  }
  if (count_ > before)
    return;
  const int face = 2 * axis + side;
  if (has_ghost(mesh, id_, face))
    add(id_, std::uint8_t(face), leaf_.depth, index);
  else
    enclosed_ = false;
}

/// The leaf in a quarter of the face that touches the face's middle.
void LeafGradient::descend(const BrickStore& store, int axis, int side, int quarter,
                           const std::int64_t* from) {
  std::int64_t index[3] = {from[0], from[1], from[2]};
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  int on_b = quarter & 1, on_c = quarter >> 1;
  for (int depth = leaf_.depth + 1;; ++depth) {
    index[axis] = 2 * index[axis] + (side ? 0 : 1);
    index[b] = 2 * index[b] + on_b;
    index[c] = 2 * index[c] + on_c;
    const std::uint32_t entry = store.at(depth, index);
    if (BrickStore::is_leaf(entry))
      add(entry, no_ghost, depth, index);
    if (BrickStore::is_leaf(entry) || entry == BrickStore::nothing)
      return;
    on_b = 1 - (quarter & 1); // back towards the middle
    on_c = 1 - (quarter >> 1);
  }
}

void LeafGradient::fit(Vec3d* terms) const {
  double m[3][3] = {}, inverse[3][3];
  for (int n = 0; n < count_; ++n)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        m[i][j] += list_[n].weight * list_[n].offset[i] * list_[n].offset[j];
  invert(m, inverse);
  for (int n = 0; n < count_; ++n)
    for (int i = 0; i < 3; ++i) {
      terms[n][i] = 0.0;
      for (int j = 0; j < 3; ++j)
        terms[n][i] += inverse[i][j] * list_[n].weight * list_[n].offset[j];
    }
}

} // namespace insitu::amr
