#pragma once

#include <cstdint>
#include <vector>

#include "core/archive.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::mesh {

/// A copy of a mesh's cells, which outlives the solver's arrays: shapes, vertex ids and which cells
/// own points. Blocks need none; ids are kept in 32 bits where they fit. Not of an adaptive mesh.
class CellsCopy {
public:
  explicit CellsCopy(core::Memory& memory) : bytes_(memory, INSITU_MEMORY_EARLIER) {}

  /// The bytes that copy() takes.
  static std::int64_t bytes_for(const MeshView& mesh, const core::Threads& threads);

  void copy(const MeshView& from, const core::Threads& threads);
  void release();
  /// Adds the pieces of another copy behind these.
  void append(const CellsCopy& behind);
  /// Whether pieces lie apart may change while the cells stay (MeshView::one_mesh).
  void set_one_mesh(bool one) { traits_ = (traits_ & ~one_mesh) | (one ? one_mesh : 0); }
  /// Whether they are a flat mesh's (MeshView::is_flat).
  void set_flat(bool is_flat) { traits_ = (traits_ & ~flat) | (is_flat ? flat : 0); }
  bool empty() const { return pieces_.empty(); }

  /// The cells on vertices at points [vertex, flat], as long as neither this nor they move.
  const MeshView& on(const math::Vec3d* points);

  /// To a checkpoint or back.
  void keep(core::Archive& archive);

private:
  /// Offsets are into bytes_; -1: there is no such array.
  struct Piece {
    std::int64_t layout = 0, shape = 0; ///< uniform, mixed or block
    std::int64_t cells = 0, vertices = 0;
    std::int64_t block[3] = {0, 0, 0};
    std::int64_t id_count = 0, ids_are_int32 = 1, ids = -1;
    std::int64_t offsets = -1, types = -1, owns = -1;
    std::int64_t pole = 0;
  };
  static std::int64_t count_ids(const PieceView& from, const core::Threads& threads,
                                std::vector<std::int64_t>& before);
  static std::int64_t place(Piece& piece, const PieceView& from, std::int64_t ids, std::int64_t at);
  void fill(const Piece& piece, const PieceView& from, const std::vector<std::int64_t>& before,
            const core::Threads& threads);

  std::vector<Piece> pieces_;
  core::Buffer<std::byte> bytes_;
  static constexpr std::int64_t one_mesh = 1, flat = 2;
  std::int64_t traits_ = 0;
  std::vector<PieceView> views_;
  std::vector<std::int64_t> first_cell_, first_vertex_;
  MeshView view_;
};

} // namespace insitu::mesh
