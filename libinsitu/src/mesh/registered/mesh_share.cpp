#include <limits>

#include "mesh/registered/mesh.h"

namespace insitu::mesh {

void Mesh::share(const Mesh& from, const math::Vec3d* points) {
  pieces_ = from.pieces_;
  separate_pieces_ = from.separate_pieces_;
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    Piece& piece = pieces_[p];
    piece.hidden_points = {}; // the fields' values tell
    if (!points) {
      piece.flat.reset(); // which is from's
      continue;
    }
    if (piece.flat) { // as the volume cells that it stands as
      piece.view = from.piece_views_[p];
      piece.view.flat_vertices = 0;
      piece.flat_cells = {};
      piece.flat.reset();
      piece.left_out.reset();
      piece.global_ids[INSITU_VERTEX] = {};
    }
    const std::int64_t first = from.first_vertex_[p];
    insitu_array array = insitu_array_default();
    array.data = points + first;
    array.type = INSITU_FLOAT64;
    array.count = from.first_vertex_[p + 1] - first;
    array.components = 3;
    const ExternalArray adopted = adopt(&array, "mesh '" + name_ + "', vertices in its place");
    for (int a = 0; a < 3; ++a)
      piece.view.points.component[a] = adopted.data + a * adopted.component_stride;
    piece.view.points.layout = adopted.layout;
    piece.view.points.is_float32 = false;
    piece.view.implicit_points = false; // a block becomes a curvilinear one
    piece.view.parts = nullptr;         // which are from's
    piece.points = {adopted};
    piece.point_components = 3;
    piece.has_points = true;
    for (ExternalArray& axis : piece.axes)
      axis = {};
  }
  fields_.clear();
  for (const auto& field : from.fields_) {
    Field& to = *fields_.emplace_back(std::make_unique<Field>(*field));
    for (std::size_t p = 0; p < to.pieces.size(); ++p) {
      FieldPiece& piece = to.pieces[p];
      piece.pointers_checked = true; // by from's update()
      if (piece.blanked) {           // as from has made them
        piece.components = piece.blanked->components();
        piece.behind.clear();
        piece.layout = piece.blanked->layout();
      }
      piece.in_rows.reset(); // which is from's
      if (points && p < from.pieces_.size() && from.pieces_[p].flat &&
          to.association == INSITU_VERTEX) {
        const FieldPieceView& twice = field->views[p];
        piece.components.assign(twice.component, twice.component + to.components);
        piece.behind.clear();
        piece.layout = twice.layout;
      }
    }
    if (from.has_blanks(*field))
      to.blanks = {std::numeric_limits<double>::quiet_NaN()};
    to.views.clear();
  }
}

} // namespace insitu::mesh
