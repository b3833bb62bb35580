/// What was given for a mesh, for records.
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

GivenPiece Mesh::given_piece(std::int32_t piece) const {
  const auto p = std::size_t(piece);
  const Piece& from = pieces_[p];
  GivenPiece out;
  out.cells = from.given;
  out.amr = from.amr;
  const auto add = [&](const char* name, const ExternalArray& array) {
    if (array.given())
      out.cell_arrays.emplace_back(name, array);
  };
  add("connectivity", from.connectivity);
  add("types", from.types);
  add("offsets", from.offsets);
  add("coordinates 0", from.axes[0]);
  add("coordinates 1", from.axes[1]);
  add("coordinates 2", from.axes[2]);
  for (const auto& [array, name] : from.face_arrays)
    add(name, array);
  add("levels", from.amr.levels);
  add("corners", from.amr.corners);
  out.points = from.points;
  out.ghosts = from.ghosts;
  out.hidden_points = from.hidden_points;
  out.global_ids[INSITU_VERTEX] = from.global_ids[INSITU_VERTEX];
  out.global_ids[INSITU_CELL] = from.global_ids[INSITU_CELL];
  out.convention = from.ghosts.given() && from.view.ghost_mask == 0xff ? INSITU_GHOSTS_ASCENT
                                                                       : INSITU_GHOSTS_VTK;
  for (const auto& field : fields_)
    if (p < field->pieces.size() && !field->pieces[p].arrays.empty())
      out.fields.push_back({field->name, field->association, field->pieces[p].arrays});
  return out;
}

GivenMesh Mesh::given() const {
  GivenMesh out;
  out.levels = amr_ ? &*amr_ : nullptr;
  out.separate_pieces = separate_pieces_;
  for (const auto& field : fields_)
    out.fields.push_back({field->name, field->blanks});
  return out;
}

} // namespace insitu::mesh
