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

/// The bounding-volume hierarchy of the `bvh` method over the owning cells of all pieces. Its nodes
/// are quantised, hold 8 children, and lie breadth first, so that children follow their parents and
/// a level is a range.
class Tree {
public:
  explicit Tree(core::Memory& memory);
  ~Tree();
  Tree(Tree&&) noexcept;

  /// Builds the tree anew over all owning cells, in Morton order unless the builder says otherwise.
  /// The buffers of an earlier build of the same kind are reused.
  void build(const mesh::MeshView& mesh, const core::Threads& threads, Builder builder);

  /// Fits the boxes to moved vertices, bottom up. The topology must be the one that was built.
  void refit(const mesh::MeshView& mesh, const core::Threads& threads);

  /// Moves the tree out. An empty tree with the scratch of the builders stays behind.
  Tree take();

  /// Becomes a copy of another tree, without its scratch and its marks of odd cells. The cells are
  /// those of a mesh with the same flat ids.
  void copy(const Tree& from);

  /// Takes over a part of another tree: the cells whose places in its cells() have a bit set, and
  /// those of its nodes that lead to them. The call looks at boxes alone, neither at cells nor at
  /// values, and marks no odd cells.
  void take_part(const Tree& from, std::span<const std::uint64_t> kept_slots,
                 const core::Threads& threads);

  /// Marks a few cells as odd, until the next build or refit; see OddSlots.
  void mark_odd(const mesh::MeshView& mesh, std::span<const std::int64_t> ids,
                const core::Threads& threads) {
    odd_ = OddSlots(mesh, ids, cells_.span(), threads);
  }
  const OddSlots& odd() const { return odd_; }

  /// Returns the expected work of a query, which is the sum of the surface areas of nodes relative
  /// to that of the root, in units of its value right after the last build.
  double cost_ratio() const { return built_cost_ > 0.0 ? cost_ / built_cost_ : 1.0; }

  /// Returns that sum itself, by which trees over the same cells compare.
  double cost() const { return cost_; }
  /// Returns how the tree was built.
  Builder builder() const { return builder_; }

  bool empty() const { return nodes_.empty(); }
  std::int64_t cell_count() const { return std::int64_t(cells_.size()); }
  /// Return the corners of the box of all owning cells, in mesh coordinates, rounded outwards.
  /// Where the tree is empty, lower > upper.
  math::Vec3d bounds_min() const;
  math::Vec3d bounds_max() const;
  /// Returns the bytes of nodes and leaves.
  std::int64_t bytes() const { return std::int64_t(nodes_.bytes() + cells_.bytes()); }

  // What traversals need.
  const Node* nodes() const { return nodes_.data(); }
  std::uint32_t node_count() const { return std::uint32_t(nodes_.size()); }
  const std::uint32_t* cells() const { return cells_.data(); } ///< flat ids
  const math::Vec3d& origin() const { return origin_; }        ///< origin of the local frame
  /// Returns the levels, root first: level l has the nodes [levels()[l], levels()[l + 1]).
  const std::vector<std::uint32_t>& levels() const { return levels_; }

  /// Gives the scratch of the builders back. Builds keep it otherwise, since touching fresh pages
  /// costs more than building.
  void release_scratch();

private:
  struct Embree; ///< holds scratch of the builder by surface area
  struct Morton;
  void build_by_surface_area(const Owners& owners, const core::Threads& threads);
  void build_in_morton_order(const mesh::MeshView& mesh, const Owners& owners,
                             const core::Threads& threads);
  void flatten(const void* root, const core::Threads& threads);
  template <class Kept>
  void emit_part(const Tree& from, const Kept& kept, const core::Threads& threads);
  /// Encodes all nodes, bottom up. fit(begin, end, slot) encodes some nodes of a level, whose cells
  /// start at the slot, and returns the area of their children.
  template <class Fit>
  void fit_bottom_up(const core::Threads& threads, Fit&& fit);
  void set_cost(const std::vector<double>& areas);

  core::Memory* memory_;
  core::Buffer<Node> nodes_;
  core::Buffer<std::uint32_t> cells_;
  core::Buffer<Box> boxes_; ///< one per node; scratch of refits
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
