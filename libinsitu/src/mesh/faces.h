#pragma once

#include <cstdint>

#include "mesh/array_view.h"

namespace insitu::mesh {

/// Rings of vertex ids over the solver's arrays, as they were given: nothing is known of them but
/// that each array has the items that it should.
struct RingsView {
  std::int64_t count = 0;
  IndexView ids;     ///< face after face; if behind, pointers to the ids of each face
  IndexView offsets; ///< [count + 1] or [count] places in ids; if behind, [count] numbers of ids
  bool behind = false;
  std::int64_t bytes_behind = 0; ///< from the place that a pointer names to the first id

  /// The ids of a ring behind its pointer, which may be null: then data is null.
  IndexView ring_behind(std::int64_t face) const {
    const auto* const at = load_as<const std::byte*>(ids.data + face * ids.stride);
    return {at ? at + bytes_behind : nullptr, offsets.load(face), ids.is_int32 ? 4 : 8,
            ids.is_int32};
  }
};

/// The cells of a piece by their faces (insitu_faces), over the solver's arrays.
struct FacesView {
  bool by_cells = false; ///< cells list their faces; else faces name their cells
  std::int64_t index_base = 0;
  std::int64_t cell_count = 0;
  RingsView faces, boundary; ///< the numbers of the boundary's follow
  // Faces name their cells.
  IndexView owner, neighbour; ///< neighbour: of the first faces
  IndexView boundary_owner;
  std::int64_t far_cells = 0; ///< ids behind the cells' that stand for no cell here
  // Cells list their faces.
  IndexView cell_faces, cell_offsets;

  std::int64_t face_count() const { return faces.count + boundary.count; }
};

} // namespace insitu::mesh
