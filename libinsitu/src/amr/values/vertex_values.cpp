#include "amr/values/vertex_values.h"

#include <cmath>

#include "amr/values/leaf_gradient.h"

namespace insitu::amr {

using math::Vec3d;

struct VertexValues::Build {
  const BrickStore& store;
  const mesh::AmrView& mesh;
  const VirtualLeaves& leaves;

  /// A leaf's number among the virtual ones; negative: it is real.
  std::int64_t made(std::uint32_t leaf) const { return std::int64_t(leaf) - leaves.first; }
  /// The real leaf that a leaf is or lies in.
  std::uint32_t real_id(std::uint32_t leaf) const {
    return made(leaf) < 0 ? leaf : leaves.leaves[std::size_t(made(leaf))].real_id;
  }
  mesh::AmrCell real(std::uint32_t leaf) const {
    return made(leaf) < 0 ? cell_at(mesh, leaf) : leaves.leaves[std::size_t(made(leaf))].real;
  }
  LeafGradient gradient(const VirtualLeaves::Leaf& leaf) const {
    return {store, mesh, leaf.real_id, leaf.real};
  }
};

namespace {

bool same_real(const VirtualLeaves& leaves, std::size_t v) {
  return leaves.leaves[v].real_id == leaves.leaves[v - 1].real_id;
}

} // namespace

void VertexValues::clear() {
  first_.resize_discard(0);
  leaves_.resize_discard(0);
  ghosts_.resize_discard(0);
  weights_.resize_discard(0);
}

void VertexValues::build(const BrickStore& store, const mesh::AmrView& mesh,
                         const VirtualLeaves& leaves, std::span<const MeanVertex> means,
                         std::span<const VertexKey> on_boundary, const core::Threads& threads) {
  clear();
  with_ghosts_ = mesh.has_ghosts();
  if (leaves.leaves.empty() && means.empty() && on_boundary.empty())
    return;
  const Build build = {store, mesh, leaves};
  add_virtual(build, threads);
  for (const MeanVertex& mean : means) {
    add_mean(build, mean);
    first_.push_back(std::int64_t(leaves_.size()));
  }
  for (const VertexKey& key : on_boundary) {
    add_vertex(build, key, 1.0);
    first_.push_back(std::int64_t(leaves_.size()));
  }
  first_.shrink();
  leaves_.shrink();
  ghosts_.shrink();
  weights_.shrink();
}

void VertexValues::add_virtual(const Build& build, const core::Threads& threads) {
  const VirtualLeaves& leaves = build.leaves;
  const std::int64_t n = std::int64_t(leaves.leaves.size());
  constexpr std::int64_t grain = 256;
  first_.resize_discard(std::size_t(n + 1));
  first_[0] = 0;
  threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    // Virtual leaves of one real leaf often follow each other.
    for (std::size_t v = std::size_t(begin); v < std::size_t(end); ++v)
      first_[v + 1] = v > std::size_t(begin) && same_real(leaves, v)
                          ? first_[v]
                          : 1 + build.gradient(leaves.leaves[v]).count();
  });
  for (std::size_t v = 0; v < std::size_t(n); ++v)
    first_[v + 1] += first_[v];
  leaves_.resize_discard(std::size_t(first_[std::size_t(n)]));
  weights_.resize_discard(leaves_.size());
  ghosts_.resize_discard(with_ghosts_ ? leaves_.size() : 0);
  threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    LeafGradient near;
    Vec3d gradient[LeafGradient::most_terms];
    for (std::size_t v = std::size_t(begin); v < std::size_t(end); ++v) {
      const VirtualLeaves::Leaf& leaf = leaves.leaves[v];
      if (v == std::size_t(begin) || !same_real(leaves, v)) {
        near = build.gradient(leaf);
        near.fit(gradient);
      }
      Vec3d offset;
      const double size = std::ldexp(1.0, leaf.real.depth - leaf.cell.depth);
      for (int a = 0; a < 3; ++a)
        offset[a] = (double(leaf.cell.index[a]) + 0.5) * size - (double(leaf.real.index[a]) + 0.5);
      const std::size_t at = std::size_t(first_[v]);
      double own = 1.0;
      leaves_[at] = leaf.real_id;
      for (int m = 0; m < near.count(); ++m) {
        const double w = math::dot(gradient[m], offset);
        own -= w;
        leaves_[at + 1 + std::size_t(m)] = near[m].id;
        weights_[at + 1 + std::size_t(m)] = w;
      }
      weights_[at] = own;
      if (!with_ghosts_)
        continue;
      ghosts_[at] = no_ghost;
      for (int m = 0; m < near.count(); ++m)
        ghosts_[at + 1 + std::size_t(m)] = near[m].ghost;
    }
  });
}

void VertexValues::push(std::uint32_t leaf, std::uint8_t ghost, double weight) {
  leaves_.push_back(leaf);
  weights_.push_back(weight);
  if (with_ghosts_)
    ghosts_.push_back(ghost);
}

/// A leaf's vertex, moved to the boundary along some axes or along none.
void VertexValues::add_vertex(const Build& build, const VertexKey& key, double share) {
  const std::int64_t made = build.made(key.leaf);
  const std::uint32_t real = build.real_id(key.leaf);
  const std::size_t own = leaves_.size();
  double half = 0.5; // a leaf's own, in cells of the real one
  if (made < 0) {
    push(real, no_ghost, share);
  } else {
    for (int t = 0; t < count(made); ++t)
      push(leaves(made)[t], ghosts(made) ? ghosts(made)[t] : no_ghost, share * weights(made)[t]);
    const VirtualLeaves::Leaf& leaf = build.leaves.leaves[std::size_t(made)];
    half = std::ldexp(half, leaf.real.depth - leaf.cell.depth);
  }
  for (int a = 0; with_ghosts_ && a < 3; ++a) {
    const std::uint32_t move = move_along(key.moves, a);
    if (move == 0)
      continue;
    const int face = 2 * a + int(move) - 1;
    if (!has_ghost(build.mesh, real, face))
      continue; // the value is kept
    push(real, std::uint8_t(face), share * half);
    weights_[own] -= share * half;
  }
}

/// The value at an offset from a leaf's centre, in its cells.
void VertexValues::add_extrapolated(const LeafGradient& gradient, std::uint32_t leaf,
                                    const Vec3d& offset, double share) {
  Vec3d terms[LeafGradient::most_terms];
  gradient.fit(terms);
  const std::size_t own = leaves_.size();
  push(leaf, no_ghost, share);
  for (int n = 0; n < gradient.count(); ++n) {
    const double w = share * math::dot(terms[n], offset);
    push(gradient[n].id, gradient[n].ghost, w);
    weights_[own] -= w;
  }
}

void VertexValues::add_mean(const Build& build, const MeanVertex& mean) {
  const double share = 1.0 / mean.count;
  LeafGradient gradients[8];
  bool enclosed = with_ghosts_ && !mean.on_line;
  for (int m = 0; enclosed && m < mean.count; ++m) {
    const std::uint32_t leaf = mean.leaves[m];
    gradients[m] = {build.store, build.mesh, build.real_id(leaf), build.real(leaf)};
    enclosed = gradients[m].is_enclosed();
  }
  for (int m = 0; m < mean.count; ++m) {
    if (!enclosed) {
      add_vertex(build, {mean.leaves[m], mean.on_line ? mean.moves[m] : 0u}, share);
      continue;
    }
    const mesh::AmrCell leaf = build.real(mean.leaves[m]);
    const mesh::Lattice& lattice = build.mesh.lattice;
    Vec3d offset;
    for (int a = 0; a < 3; ++a)
      offset[a] =
          (mean.x[a] - lattice.centre(a, leaf.depth, leaf.index[a])) / lattice.width(a, leaf.depth);
    add_extrapolated(gradients[m], build.real_id(mean.leaves[m]), offset, share);
  }
}

} // namespace insitu::amr
