#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "amr/brick_store.h"
#include "amr/reentrant.h"

namespace insitu::amr {

/// Leaves that only the dual mesh has.
struct VirtualLeaves {
  struct Leaf {
    mesh::AmrCell cell;
    mesh::AmrCell real; ///< the leaf that it lies in
    std::uint32_t real_id;
  };
  std::int64_t first = 0;           ///< the first one's id; the others follow
  std::vector<Leaf> leaves;         ///< those that lie in one real leaf: not together
  std::vector<mesh::AmrCell> split; ///< cells that were split, coarse ones first
};

/// What gives virtual leaves their values: f_A + g (x - x_A) in a real leaf A, where the gradient g
/// is the least squares fit to the leaves across A's faces (of finer ones, the four nearest to the
/// middle of the face). Linear fields are met exactly, and the mean over the real leaf is its
/// value. Along an axis that the neighbours do not span, g is zero: the leaf has none there, or
/// only much finer ones across other faces, whose differences would be blown up.
class VirtualValues {
public:
  explicit VirtualValues(core::Memory& memory)
      : first_(memory, INSITU_MEMORY_AMR), leaves_(memory, INSITU_MEMORY_AMR),
        weights_(memory, INSITU_MEMORY_AMR) {}

  /// Means follow the virtual leaves: the terms of the leaves that they are over, each with an
  /// equal share.
  void build(const BrickStore& store, const VirtualLeaves& leaves,
             std::span<const MeanVertex> means, const core::Threads& threads);
  void clear();
  std::int64_t bytes() const {
    return std::int64_t(first_.bytes() + leaves_.bytes() + weights_.bytes());
  }

  /// The terms of virtual leaf or mean n, counted from 0.
  int count(std::int64_t n) const {
    return int(first_[std::size_t(n + 1)] - first_[std::size_t(n)]);
  }
  const std::uint32_t* leaves(std::int64_t n) const {
    return leaves_.data() + first_[std::size_t(n)];
  }
  const double* weights(std::int64_t n) const { return weights_.data() + first_[std::size_t(n)]; }

private:
  void add_means(const VirtualLeaves& leaves, std::span<const MeanVertex> means);

  core::Buffer<std::int64_t> first_;
  core::Buffer<std::uint32_t> leaves_;
  core::Buffer<double> weights_;
};

} // namespace insitu::amr
