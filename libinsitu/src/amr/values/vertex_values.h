#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "amr/dual/reentrant.h"
#include "amr/dual/virtual_leaves.h"
#include "amr/leaves/brick_store.h"

namespace insitu::amr {

class LeafGradient;

/// What gives the dual mesh's vertices that have no leaf's own value theirs, as sums of
/// weight * value:
///
/// - virtual leaves: f_A + g (x - x_A) in a real leaf A, with its gradient g (leaf_gradient.h).
///   Linear fields are met exactly, and the mean over the real leaf is its value;
/// - vertices on the domain's boundary beyond which the solver has ghost cells: the leaf's value,
///   and along each axis that leads to the boundary half the difference of the ghost cell's value
///   to it. Only ghosts across faces are read, none across edges or corners;
/// - means in re-entrant corners: f_A + g (x - x_A), the mean over its leaves, if ghost cells lie
///   wherever the domain ends beyond their faces; otherwise the mean of their values.
class VertexValues {
public:
  explicit VertexValues(core::Memory& memory)
      : first_(memory, INSITU_MEMORY_AMR), leaves_(memory, INSITU_MEMORY_AMR),
        ghosts_(memory, INSITU_MEMORY_AMR), weights_(memory, INSITU_MEMORY_AMR) {}

  /// Vertices are numbered from 0: virtual leaves, means, and those on the boundary.
  void build(const BrickStore& store, const mesh::AmrView& mesh, const VirtualLeaves& leaves,
             std::span<const MeanVertex> means, std::span<const VertexKey> on_boundary,
             const core::Threads& threads);
  void clear();
  std::int64_t bytes() const {
    return std::int64_t(first_.bytes() + leaves_.bytes() + ghosts_.bytes() + weights_.bytes());
  }

  /// The terms of vertex n.
  int count(std::int64_t n) const {
    return int(first_[std::size_t(n + 1)] - first_[std::size_t(n)]);
  }
  const std::uint32_t* leaves(std::int64_t n) const {
    return leaves_.data() + first_[std::size_t(n)];
  }
  const double* weights(std::int64_t n) const { return weights_.data() + first_[std::size_t(n)]; }
  /// For each term the face of the leaf whose ghost cell it is, or no_ghost; null if none is one.
  const std::uint8_t* ghosts(std::int64_t n) const {
    return with_ghosts_ ? ghosts_.data() + first_[std::size_t(n)] : nullptr;
  }

private:
  struct Build;
  void add_virtual(const Build& build, const core::Threads& threads);
  void add_mean(const Build& build, const MeanVertex& mean);
  void add_vertex(const Build& build, const VertexKey& key, double share);
  void add_extrapolated(const LeafGradient& gradient, std::uint32_t leaf, const math::Vec3d& offset,
                        double share);
  void push(std::uint32_t leaf, std::uint8_t ghost, double weight);

  core::Buffer<std::int64_t> first_;
  core::Buffer<std::uint32_t> leaves_;
  core::Buffer<std::uint8_t> ghosts_; ///< with_ghosts_
  core::Buffer<double> weights_;
  bool with_ghosts_ = false; ///< the mesh has some
};

} // namespace insitu::amr
