#pragma once

#include <atomic>
#include <cstdint>

#include "accel/faces/unpaired_faces.h"
#include "accel/tree/tree.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::query {

/// Which cells of a committed mesh are alone: no other closed cell that owns points holds a point
/// of their interior, so that a proof answers in `exact` as well. Proven by degree
/// (design/locate.md, "Cells that are alone"), at the current coordinates: cells whose boxes meet
/// neither a face that no neighbour's cancels nor the box of an odd cell lie where so many cells
/// cover each point as cover one point of those that they hang together with, and that one is
/// asked.
///
/// It is found once `exact` has been asked for so many points that it pays: one bit a cell, and
/// until the topology changes 16 bytes a face of the boundary. Where memory is wanting, or the mesh
/// is of no kind for it, no cell is known to be alone. Calls that are const are thread-safe; the
/// others are the committer's, while nobody asks.
class LoneCells {
public:
  /// tree: of all owning cells of the meshes that will be asked for.
  LoneCells(const accel::Tree& tree, core::Memory& memory)
      : tree_(tree), memory_(memory), faces_(memory, INSITU_MEMORY_QUERY),
        bits_(memory, INSITU_MEMORY_QUERY) {}

  /// Other cells, which may be asked for or not; or the vertices moved. Nothing is known any more.
  void begin(bool serves);
  void forget();

  /// Whether it is known which cells are alone, and whether one is.
  bool are_known() const { return known_.load(std::memory_order_acquire); }
  bool has(std::int64_t cell) const {
    return bits_[std::size_t(cell) >> 6] >> (unsigned(cell) & 63) & 1;
  }

  /// So many points were asked for in `exact`.
  void note(std::size_t points) const {
    if (!are_known())
      asked_.fetch_add(std::int64_t(points), std::memory_order_relaxed);
  }
  /// Finds out, if that is due and it is known which cells fold; the tree must be fitted.
  void find_if_due(const mesh::MeshView& mesh, const core::Threads& threads) const;
  /// The same, due or not.
  void find(const mesh::MeshView& mesh, const core::Threads& threads) const;

private:
  void find_all(const mesh::MeshView& mesh, const core::Threads& threads) const;
  template <class Box>
  bool strike(std::int64_t count, const core::Threads& threads, const Box& box) const;
  void keep_covered_once(const mesh::MeshView& mesh) const;

  const accel::Tree& tree_;
  core::Memory& memory_;
  mutable bool serves_ = false;
  mutable std::atomic<bool> known_{false};
  mutable std::atomic<bool> is_settled_{true}; ///< somebody finds out, has found out, or has failed
  mutable std::atomic<std::int64_t> asked_{0}; ///< points, since the vertices moved
  mutable bool has_faces_ = false;
  mutable core::Buffer<accel::FaceVertices> faces_; ///< that no neighbour's cancels
  mutable core::Buffer<std::uint64_t> bits_;
};

} // namespace insitu::query
