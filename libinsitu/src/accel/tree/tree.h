#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/locator.h"
#include "accel/tree/node.h"
#include "accel/tree/odd_slots.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::accel {

class Owners;

/// The bounding-volume hierarchy of the `bvh` method over the owning cells of all pieces: 8-wide
/// quantised nodes, breadth first, so that children follow their parents and a level is a range.
class Tree {
public:
  explicit Tree(core::Memory& memory);
  ~Tree();
  Tree(Tree&&) noexcept;

  /// Builds anew over all owning cells, unless told otherwise in Morton order. Buffers of an
  /// earlier build of the kind are reused.
  void build(const mesh::MeshView& mesh, const core::Threads& threads, Builder builder);

  /// Fits the boxes to moved vertices, bottom up; the topology must be the one that was built.
  void refit(const mesh::MeshView& mesh, const core::Threads& threads);

  /// The tree as it is, which leaves an empty one with the builders' scratch.
  Tree take();

  /// The cells of another tree whose places in its cells() have a bit set, under what of its nodes
  /// leads to them: neither cells nor values are looked at, only boxes. Odd cells are not marked.
  void take_part(const Tree& from, std::span<const std::uint64_t> kept_slots,
                 const core::Threads& threads);

  /// Marks a few cells, until the next build or refit; see OddSlots.
  void mark_odd(const mesh::MeshView& mesh, std::span<const std::int64_t> ids,
                const core::Threads& threads) {
    odd_ = OddSlots(mesh, ids, cells_.span(), threads);
  }
  const OddSlots& odd() const { return odd_; }

  /// Expected work of a query, as the surface-area sum over nodes relative to the root's; in units
  /// of its value right after the last build.
  double cost_ratio() const { return built_cost_ > 0.0 ? cost_ / built_cost_ : 1.0; }

  /// The same sum itself, to compare trees over the same cells.
  double cost() const { return cost_; }
  /// How it was built.
  Builder builder() const { return builder_; }

  bool empty() const { return nodes_.empty(); }
  std::int64_t cell_count() const { return std::int64_t(cells_.size()); }
  /// The box of all owning cells, in mesh coordinates (rounded outwards); lower > upper if empty.
  math::Vec3d bounds_min() const;
  math::Vec3d bounds_max() const;
  /// Bytes of nodes and leaves.
  std::int64_t bytes() const { return std::int64_t(nodes_.bytes() + cells_.bytes()); }

  // For traversals.
  const Node* nodes() const { return nodes_.data(); }
  std::uint32_t node_count() const { return std::uint32_t(nodes_.size()); }
  const std::uint32_t* cells() const { return cells_.data(); } ///< flat ids
  const math::Vec3d& origin() const { return origin_; }        ///< of the local frame
  /// Levels, root first: nodes of level l are [levels()[l], levels()[l + 1]).
  const std::vector<std::uint32_t>& levels() const { return levels_; }

  /// Gives the builder's scratch back (it is kept between builds, since touching fresh pages costs
  /// more than building).
  void release_scratch();

private:
  struct Embree; ///< scratch of the builders
  struct Morton;
  void build_by_surface_area(const Owners& owners, const core::Threads& threads);
  void build_in_morton_order(const mesh::MeshView& mesh, const Owners& owners,
                             const core::Threads& threads);
  void flatten(const void* root, const core::Threads& threads);
  template <class Kept>
  void emit_part(const Tree& from, const Kept& kept, const core::Threads& threads);
  /// Encodes all nodes, bottom up. fit(begin, end, slot): encodes some of a level, whose cells
  /// start at the slot, and returns their children's area.
  template <class Fit>
  void fit_bottom_up(const core::Threads& threads, Fit&& fit);
  void set_cost(const std::vector<double>& areas);

  core::Memory* memory_;
  core::Buffer<Node> nodes_;
  core::Buffer<std::uint32_t> cells_;
  core::Buffer<Box> boxes_; ///< per node; scratch of refits
  std::unique_ptr<Embree> embree_;
  std::unique_ptr<Morton> morton_;
  std::vector<std::uint32_t> levels_;
  OddSlots odd_;
  math::Vec3d origin_;
  Box bounds_;
  Builder builder_ = Builder::morton;
  double cost_ = 0.0;
  double built_cost_ = 0.0;
};

} // namespace insitu::accel
