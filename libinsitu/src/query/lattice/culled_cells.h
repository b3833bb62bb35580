#pragma once

#include <cstdint>
#include <optional>

#include "accel/tree/tree.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "query/lattice/place_locators.h"
#include "query/sampler.h"

namespace insitu::query {

/// Some of the gridlets and stitching cells of an adaptive mesh's dual, in a tree of their own; all
/// other cells are left out: a point in one of these lies outside (Sampler::among).
class CulledCells {
public:
  explicit CulledCells(core::Memory& memory)
      : tree_(memory), shown_(memory, INSITU_MEMORY_RANGES), slots_(memory, INSITU_MEMORY_RANGES) {}

  /// Whether the sampler's mesh is a dual mesh whose cells can be left out: one with gridlets.
  static bool serves(const Sampler& sampler);
  /// Gridlets and stitching cells, in this order.
  static std::int64_t primitives_of(const Sampler& sampler);

  /// shows(i): whether primitive i is kept; from any thread. Memory of an earlier call is used
  /// again.
  void make(const Sampler& sampler, const core::Threads& threads,
            core::FunctionRef<bool(std::int64_t)> shows);

  const accel::Tree& tree() const { return tree_; }
  /// Primitives in all, and of these those that are left out.
  std::int64_t primitives() const { return primitives_; }
  std::int64_t culled() const { return primitives_ - tree_.cell_count(); }
  /// Finds points in the primitives that are kept alone; after make().
  const PointLocator& locator() const { return *locator_; }
  std::int64_t bytes() const {
    return tree_.bytes() + std::int64_t(shown_.bytes() + slots_.bytes());
  }

private:
  accel::Tree tree_;
  core::Buffer<std::uint64_t> shown_; ///< a bit a primitive
  core::Buffer<std::uint64_t> slots_; ///< a bit a place in the whole tree's cells
  std::int64_t primitives_ = 0;
  std::optional<DualLocator> locator_;
};

} // namespace insitu::query
