#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/registered/mesh.h"

namespace insitu::api {

/// Where the cells of an adaptive mesh lay at its last regrid, to tell one that nobody announced:
/// leaves that are others, and fields of patches in arrays of another shape. Patches themselves
/// cannot move unannounced, since insitu_mesh_patch says so. 16 bytes a leaf.
class AmrWatch {
public:
  explicit AmrWatch(core::Memory& memory) : memory_(&memory) {}

  /// The mesh as of its last update; it must outlive this. Not an adaptive one: nothing is watched.
  void remember(const mesh::Mesh& mesh, const core::Threads& threads);

  /// Throws INSITU_ERROR_ORDER for the first leaf that lies elsewhere, whatever the threads, or the
  /// first array of another shape, with what it was and what it is. Reads every leaf.
  void expect_unchanged(const core::Threads& threads) const;
  /// The same of a few thousand leaves a piece, others each time.
  void expect_unchanged_chunk();

private:
  struct Leaf {
    std::int32_t index[3]; ///< of its own level's cells
    std::int32_t level;    ///< as the solver numbers it
  };
  struct Piece {
    Piece(core::Memory& memory, const mesh::AmrPieceView& from)
        : view(from), leaves(memory, INSITU_MEMORY_AMR) {}
    mesh::AmrPieceView view;
    core::Buffer<Leaf> leaves; ///< of a patch: none
    std::int64_t next = 0;     ///< where the next chunk begins
    /// Of a patch: the arrays that had its shape.
    std::vector<std::string> fields;
  };

  std::int64_t corner(const Piece& piece, const Leaf& leaf, int axis) const;
  bool is_elsewhere(const Piece& piece, std::int64_t leaf) const;
  void check_leaves(std::size_t piece, std::int64_t begin, std::int64_t end,
                    const core::Threads* threads) const;
  void check_shapes(std::size_t piece) const;
  [[noreturn]] void refuse(std::size_t piece, const std::string& what) const;

  core::Memory* memory_;
  const mesh::Mesh* mesh_ = nullptr;
  mesh::AmrView view_;
  std::vector<Piece> pieces_;
};

} // namespace insitu::api
