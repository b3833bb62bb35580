#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "records/record.h"

namespace insitu_replay {

/// The arrays of a piece that were read, by name: dense, in this program's memory.
using PieceArrays = std::map<std::string, insitu_array>;

/// Hides the ghost cells of a piece of a run of several processes, whose own cells are all there:
/// ghosts are of VTK's convention then. The arrays are written to.
void hide_ghosts(RecordedPiece& piece, PieceArrays& arrays);

/// The mesh that the pieces of several processes are parts of, as one process would have it: a
/// piece of all cells that are no ghosts in the order of their global ids, on vertices that are one
/// where their global ids are equal. A point on a face is then the same cell's as in the run.
class Assembly {
public:
  /// An empty optional where the pieces do as they are: their cells ascend; or where they are no
  /// cells with shapes, no blocks, or lack global ids.
  static std::optional<Assembly> make(const RecordedMesh& mesh,
                                      const std::vector<PieceArrays>& arrays);

  /// The cells, over memory of this object.
  insitu_cells cells() const;
  insitu_array global_ids(insitu_association association) const;
  /// Puts values of the pieces together; of pieces without the array there are no cells.
  /// item_bytes: those of all components; `to` gets so many an item.
  std::int64_t count(insitu_association association) const;
  void gather(insitu_association association, const std::vector<const insitu_array*>& from,
              std::size_t item_bytes, std::byte* to) const;
  /// The coordinates [vertex][3]; points: null of a block whose axes tell them.
  std::vector<double> points(const RecordedMesh& mesh, const std::vector<PieceArrays>& arrays,
                             const std::vector<const insitu_array*>& points) const;

private:
  struct Place {
    std::int32_t piece;
    std::int64_t item;
  };
  std::vector<Place> from_[2]; ///< [association]
  std::vector<std::int64_t> ids_[2], connectivity_, offsets_;
  std::vector<std::uint8_t> types_;
};

} // namespace insitu_replay
