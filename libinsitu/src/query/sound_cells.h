#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>

#include "core/memory.h"
#include "mesh/view.h"

namespace insitu::query {

/// Which cells of a committed mesh whose vertices moved are sound: the determinant of their map
/// keeps the sign that it has in most cells, throughout, at the current coordinates (the Bernstein
/// coefficients of cells/kernels/jacobian_signs.inl). Such a cell answers alone for what it is
/// proven to hold. That is found for a cell when it is first asked for, and kept in a byte a cell,
/// which is there once somebody asked. Calls that are const are thread-safe, and their answers do
/// not depend on who asked before; the others are the committer's, while nobody asks.
class SoundCells {
public:
  explicit SoundCells(core::Memory& memory) : states_(memory, INSITU_MEMORY_QUERY) {}

  /// The cells are others, and validated; are_inverted: most are the other way round than VTK's
  /// rule. What of them folds is known.
  void begin(bool are_inverted);
  /// The vertices moved: nothing is known any more.
  void forget();
  /// A search over all cells has told which fold, so nobody need ask, but for geometry between two
  /// steps.
  void close() { is_open_ = false; }
  /// There are no cells that could be asked for.
  void end() { is_there_ = false; }
  bool are_inverted() const { return are_inverted_; }
  /// Whether cells can be asked for; moves: for geometry between two steps.
  bool serves(bool moves) const { return is_there_ && (is_open_ || moves); }

  enum class Known : std::uint8_t { unknown, sound, odd };
  /// What is known of a cell by now.
  Known known(std::int64_t cell) const;
  /// A cell and its vertices at the current coordinates.
  struct Asked {
    std::int64_t cell;
    const math::Vec3d* vertices;
    Known* to; ///< where the answer goes
  };
  /// Finds out about cells of one shape. cell_count: of the mesh; the first call makes room for so
  /// many, and cells with higher ids are examined at every call. May throw for want of memory.
  void find(std::int64_t cell_count, mesh::Shape shape, std::span<const Asked> asked) const;
  /// The same for one, if it is not known.
  bool is_sound(const mesh::MeshView& mesh, std::int64_t cell) const;

private:
  void make_room(std::int64_t cell_count) const;

  bool is_there_ = false, is_open_ = false, are_inverted_ = false;
  /// In the upper bits of a state: those of commits before count as unknown.
  static constexpr unsigned most_epochs = 63;
  unsigned epoch_ = 1;
  mutable std::mutex mutex_; ///< of making room
  mutable std::atomic<std::uint8_t*> room_{nullptr};
  mutable core::Buffer<std::uint8_t> states_;
};

} // namespace insitu::query
