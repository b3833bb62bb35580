#include "amr/virtual_leaves.h"

#include <algorithm>
#include <cmath>

#include "math/vec.h"

namespace insitu::amr {

namespace {

using math::Vec3d;

/// A leaf near another one; the offset of its centre in cells of that one.
struct Neighbor {
  std::uint32_t id;
  Vec3d offset;
  double weight;
};

class Neighbors {
public:
  Neighbors() = default;
  Neighbors(const BrickStore& store, const mesh::AmrCell& leaf) : leaf_(leaf) {
    for (int a = 0; a < 3; ++a)
      for (int side = 0; side < 2; ++side)
        across(store, a, side);
  }
  int count() const { return count_; }
  const Neighbor& operator[](int n) const { return list_[n]; }

private:
  void add(std::uint32_t id, int depth, const std::int64_t* index) {
    Neighbor& n = list_[count_++];
    n.id = id;
    const double size = std::ldexp(1.0, leaf_.depth - depth);
    for (int a = 0; a < 3; ++a)
      n.offset[a] = (double(index[a]) + 0.5) * size - (double(leaf_.index[a]) + 0.5);
    n.weight = 1.0 / math::dot(n.offset, n.offset);
  }

  void across(const BrickStore& store, int axis, int side) {
    std::int64_t index[3] = {leaf_.index[0], leaf_.index[1], leaf_.index[2]};
    index[axis] += side ? 1 : -1;
    const std::uint32_t entry = store.at(leaf_.depth, index);
    int up = 0;
    if (BrickStore::is_leaf(entry))
      add(entry, leaf_.depth, index);
    else if (entry != BrickStore::nothing)
      for (int quarter = 0; quarter < 4; ++quarter)
        descend(store, axis, side, quarter, index);
    else if (const std::uint32_t id = store.above(leaf_.depth, index, &up);
             id != BrickStore::nothing) {
      const std::int64_t coarse[3] = {index[0] >> up, index[1] >> up, index[2] >> up};
      add(id, leaf_.depth - up, coarse);
    }
  }

  /// The leaf in a quarter of the face that touches the face's middle.
  void descend(const BrickStore& store, int axis, int side, int quarter, const std::int64_t* from) {
    std::int64_t index[3] = {from[0], from[1], from[2]};
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    int on_b = quarter & 1, on_c = quarter >> 1;
    for (int depth = leaf_.depth + 1;; ++depth) {
      index[axis] = 2 * index[axis] + (side ? 0 : 1);
      index[b] = 2 * index[b] + on_b;
      index[c] = 2 * index[c] + on_c;
      const std::uint32_t entry = store.at(depth, index);
      if (BrickStore::is_leaf(entry))
        add(entry, depth, index);
      if (BrickStore::is_leaf(entry) || entry == BrickStore::nothing)
        return;
      on_b = 1 - (quarter & 1); // back towards the middle
      on_c = 1 - (quarter >> 1);
    }
  }

  mesh::AmrCell leaf_;
  Neighbor list_[24];
  int count_ = 0;
};

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

/// The gradient's terms: of neighbour n, gradient[n] times its difference to the leaf's value.
void fit_gradient(const Neighbors& near, Vec3d* gradient) {
  double m[3][3] = {}, inverse[3][3];
  for (int n = 0; n < near.count(); ++n)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        m[i][j] += near[n].weight * near[n].offset[i] * near[n].offset[j];
  invert(m, inverse);
  for (int n = 0; n < near.count(); ++n)
    for (int i = 0; i < 3; ++i) {
      gradient[n][i] = 0.0;
      for (int j = 0; j < 3; ++j)
        gradient[n][i] += inverse[i][j] * near[n].weight * near[n].offset[j];
    }
}

bool same_real(const VirtualLeaves& leaves, std::size_t v) {
  return leaves.leaves[v].real_id == leaves.leaves[v - 1].real_id;
}

} // namespace

void VirtualValues::clear() {
  first_.resize_discard(0);
  leaves_.resize_discard(0);
  weights_.resize_discard(0);
}

void VirtualValues::build(const BrickStore& store, const VirtualLeaves& leaves,
                          std::span<const MeanVertex> means, const core::Threads& threads) {
  const std::int64_t n = std::int64_t(leaves.leaves.size());
  constexpr std::int64_t grain = 256;
  clear();
  if (n == 0 && means.empty())
    return;
  first_.resize_discard(std::size_t(n + 1));
  first_[0] = 0;
  threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    // Virtual leaves of one real leaf often follow each other.
    for (std::size_t v = std::size_t(begin); v < std::size_t(end); ++v)
      first_[v + 1] = v > std::size_t(begin) && same_real(leaves, v)
                          ? first_[v]
                          : 1 + Neighbors(store, leaves.leaves[v].real).count();
  });
  for (std::size_t v = 0; v < std::size_t(n); ++v)
    first_[v + 1] += first_[v];
  leaves_.resize_discard(std::size_t(first_[std::size_t(n)]));
  weights_.resize_discard(leaves_.size());
  threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    Neighbors near;
    Vec3d gradient[24];
    for (std::size_t v = std::size_t(begin); v < std::size_t(end); ++v) {
      const VirtualLeaves::Leaf& leaf = leaves.leaves[v];
      if (v == std::size_t(begin) || !same_real(leaves, v)) {
        near = Neighbors(store, leaf.real);
        fit_gradient(near, gradient);
      }
      Vec3d offset;
      const double size = std::ldexp(1.0, leaf.real.depth - leaf.cell.depth);
      for (int a = 0; a < 3; ++a)
        offset[a] = (double(leaf.cell.index[a]) + 0.5) * size - (double(leaf.real.index[a]) + 0.5);
      std::size_t at = std::size_t(first_[v]);
      double own = 1.0;
      leaves_[at] = leaf.real_id;
      for (int m = 0; m < near.count(); ++m) {
        const double w = math::dot(gradient[m], offset);
        own -= w;
        leaves_[at + 1 + std::size_t(m)] = near[m].id;
        weights_[at + 1 + std::size_t(m)] = w;
      }
      weights_[at] = own;
    }
  });
  add_means(leaves, means);
}

void VirtualValues::add_means(const VirtualLeaves& leaves, std::span<const MeanVertex> means) {
  std::vector<std::uint32_t> ids;
  std::vector<double> weights;
  for (const MeanVertex& mean : means) {
    ids.clear();
    weights.clear();
    for (int m = 0; m < mean.count; ++m) {
      const double share = 1.0 / mean.count;
      const std::int64_t made = std::int64_t(mean.leaves[m]) - leaves.first;
      for (int t = 0; t < (made < 0 ? 1 : count(made)); ++t) {
        ids.push_back(made < 0 ? mean.leaves[m] : this->leaves(made)[t]);
        weights.push_back(made < 0 ? share : share * this->weights(made)[t]);
      }
    }
    for (std::size_t t = 0; t < ids.size(); ++t) {
      leaves_.push_back(ids[t]);
      weights_.push_back(weights[t]);
    }
    first_.push_back(std::int64_t(leaves_.size()));
  }
}

} // namespace insitu::amr
