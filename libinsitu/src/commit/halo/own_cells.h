#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/tree/tree.h"
#include "commit/halo/seam_reach.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/box.h"
#include "mesh/view.h"

namespace insitu::commit {

/// A process's own cells by their boxes, before the mesh has its tree: that is built once, with the
/// halo, and those of other processes are looked for beside these.
class OwnCells {
public:
  /// Takes the own cells of a view, which outlives it. Throws as accel::Tree::build(), and for want
  /// of memory, as all here.
  OwnCells(const mesh::MeshView& view, core::Memory& memory, const core::Threads& threads);

  /// Boxes of groups of cells that lie together, in the mesh's coordinates, at most
  /// query::Directory::most_boxes of them; they hold all cells and what these reach.
  std::vector<mesh::Box> boxes(const SeamReach& reach) const;
  /// A tree of the cells whose boxes meet one of these, and of no other one.
  accel::Tree tree_of_those_in(std::span<const mesh::Box> boxes,
                               const core::Threads& threads) const;

private:
  static constexpr int levels = 6, groups = 1 << levels;
  /// Groups are halved by planes: plane g parts group g of its level into 2 g and 2 g + 1 of the
  /// next one.
  struct Plane {
    int axis = 0;
    float at = 0.0f;
  };
  void set_planes();
  void halve(std::size_t plane, std::span<std::array<float, 3>> middles);
  int group_of(const accel::Box& box) const;

  core::Memory* memory_;
  mesh::MeshView view_;
  math::Vec3d origin_;                 ///< of the boxes
  core::Buffer<accel::Box> boxes_;     ///< of the cells that exist
  core::Buffer<std::uint32_t> cells_;  ///< their flat ids, ascending
  core::Buffer<std::uint8_t> group_;   ///< of each
  std::array<Plane, groups> planes_{}; ///< from 1 on
  std::array<accel::Box, groups> around_{};
  std::array<std::array<float, 3>, groups> largest_{}; ///< of the sizes of the group's cells
};

} // namespace insitu::commit
