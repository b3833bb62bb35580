#pragma once

#include <span>
#include <string>

#include "cells/polyhedra/findings.h"
#include "core/memory.h"
#include "mesh/faces.h"
#include "mesh/piece.h"

namespace insitu::cells {

/// The ring of a face: the vertices' ids as given.
struct FaceRing {
  mesh::IndexView ids;
  std::int64_t first = 0, size = 0; ///< places in ids
  std::int64_t id(std::int64_t k) const { return ids.load(first + k); }
};

/// Whether the offsets of a face tell places in the ids, or its pointer leads to some; `out` then
/// is the ring.
bool find_ring(const mesh::FacesView& faces, std::int64_t face, FaceRing& out);

/// The faces of each cell of a piece: by number where faces name their cells, else as the cell
/// lists them.
class CellFaces {
public:
  explicit CellFaces(core::Memory& memory)
      : first_(memory, INSITU_MEMORY_BUILD), faces_(memory, INSITU_MEMORY_BUILD) {}

  /// own: the piece, whose cells that do not exist may hold anything. name: what messages call it.
  void build(const mesh::FacesView& faces, const mesh::PieceView& own, const std::string& name,
             FaceFindings& findings);

  std::span<const std::int64_t> of(std::int64_t cell) const {
    const auto c = std::size_t(cell);
    return {faces_.data() + first_[c], std::size_t(first_[c + 1] - first_[c])};
  }

private:
  void sort_by_owner(const mesh::FacesView& faces, const std::string& name, FaceFindings& findings);
  void take_lists(const mesh::FacesView& faces, const mesh::PieceView& own, const std::string& name,
                  FaceFindings& findings);

  core::Buffer<std::int64_t> first_; ///< [cell + 1]
  core::Buffer<std::int64_t> faces_;
};

} // namespace insitu::cells
