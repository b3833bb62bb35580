#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "mesh/registered/adaptive_piece.h"
#include "mesh/registered/external_array.h"

/// What a caller gave for a mesh, over the caller's arrays, as records keep it.
namespace insitu::mesh {

/// The cells of a piece that is no patch and no leaves, in the caller's own struct.
using GivenCells = std::variant<std::monostate, insitu_cells, insitu_faces, insitu_block>;

/// The values of a field on a piece.
struct GivenField {
  std::string name;
  insitu_association association = INSITU_VERTEX;
  std::vector<ExternalArray> arrays; ///< one, or one a component
};

struct GivenPiece {
  GivenCells cells;
  std::vector<std::pair<std::string, ExternalArray>> cell_arrays; ///< of `cells` and of leaves, by
                                                                  ///< their names in these structs
  AmrPiece amr;                                                   ///< of an adaptive mesh
  std::vector<ExternalArray> points;
  ExternalArray ghosts, hidden_points, global_ids[2]; ///< not given() where there are none
  insitu_ghost_convention convention = INSITU_GHOSTS_VTK;
  std::vector<GivenField> fields; ///< those that the piece has, in the order of the mesh's
};

/// What is given apart from the pieces.
struct GivenMesh {
  const AmrLevels* levels = nullptr; ///< null: not adaptive
  bool separate_pieces = false;
  struct Field {
    std::string name;
    std::vector<double> blanks;
  };
  std::vector<Field> fields;
};

} // namespace insitu::mesh
