// Cells that processes tell each other: see FarCells.
#include <algorithm>
#include <string>

#include "advect/across/far_cells.h"
#include "core/status.h"
#include "query/on_demand.h"
#include "query/point_locator.h"
#include "query/sound_cells.h"

namespace insitu::advect {

using math::Vec3d;

void FarCells::tell(std::int64_t cell, insitu_accuracy accuracy, parallel::ByteWriter& to) const {
  const mesh::MeshView& mesh = here_.mesh();
  // As of kept cells: see CellCache.
  const query::SoundCells* const sound = here_.sound_cells(moves_);
  const bool is_alone = !here_.locator().dual() &&
                        (mesh.free_of_folds || (sound && sound->is_sound(mesh, cell))) &&
                        (accuracy != INSITU_EXACT || mesh.covers_once);
  mesh::CellVertices c, before;
  mesh::gather(mesh, cell, c);
  to.value(cell);
  to.value(homes_.name(cell));
  to.value(std::uint8_t(c.shape));
  to.value(std::uint8_t(mesh.pieces[c.piece].pole));
  to.value(std::uint8_t(c.count));
  to.value(std::uint8_t(is_alone));
  to.array(std::span<const Vec3d>(c.x, std::size_t(c.count)));
  if (moves_) {
    mesh::gather(mesh, cell, before, 0.0);
    to.array(std::span<const Vec3d>(before.x, std::size_t(c.count)));
  }
  const std::int64_t local = cell - mesh.first_cell[c.piece];
  for (const auto& field : fields_) {
    const bool by_cell = field->view.association == INSITU_CELL;
    const mesh::FieldPieceView& from = field->pieces[std::size_t(c.piece)];
    for (int v = 0; v < (by_cell ? 1 : c.count); ++v)
      for (int k = 0; k < field->view.components; ++k)
        to.value(from.load(by_cell ? local : c.ids[v], k));
  }
}

std::int64_t FarCells::take(int rank, parallel::ByteReader& from) {
  const auto there = from.value<std::int64_t>();
  const auto name = from.value<CellName>();
  const auto shape = from.value<std::uint8_t>(), pole = from.value<std::uint8_t>();
  const std::size_t count = from.value<std::uint8_t>();
  const bool is_alone = from.value<std::uint8_t>() != 0;
  if (pole >= far_.size() || count > 8)
    throw core::Error(INSITU_ERROR_INTERNAL,
                      "tracer: a cell of process " + std::to_string(rank) + " is none");
  // One that is here already, in the halo or told before, keeps its id: walks compare ids.
  const auto told = ids_.find({rank, there});
  const std::int64_t here = told != ids_.end() ? told->second
                            : name.rank >= 0   ? homes_.find(name)
                                               : -1;
  const bool is_new = here < 0;
  Piece none, &piece = is_new ? far_[pole] : none;
  const auto first = std::int32_t(piece.points.size());
  const auto add = [&](std::vector<Vec3d>& to) {
    const std::vector<Vec3d> more = from.array<Vec3d>(count);
    to.insert(to.end(), more.begin(), more.end());
  };
  add(piece.points);
  if (moves_)
    add(piece.earlier);
  for (const auto& field : fields_) {
    const bool by_cell = field->view.association == INSITU_CELL;
    const std::vector<double> values =
        from.array<double>((by_cell ? 1 : count) * std::size_t(field->view.components));
    if (is_new)
      field->of[pole].values.insert(field->of[pole].values.end(), values.begin(), values.end());
  }
  if (!is_new)
    return here;
  piece.offsets.push_back(std::int64_t(piece.connectivity.size()));
  for (std::size_t v = 0; v < count; ++v)
    piece.connectivity.push_back(first + std::int32_t(v));
  piece.names.push_back(name);
  piece.types.push_back(shape);
  const std::int64_t id = first_cell_[first_piece() + pole] + std::int64_t(piece.types.size()) - 1;
  ids_[{rank, there}] = id;
  by_name_[name] = id;
  if (is_alone)
    add_alone(id, piece, std::size_t(first));
  return id;
}

/// first: of the cell's vertices in its piece, the last ones there.
void FarCells::add_alone(std::int64_t id, const Piece& piece, std::size_t first) {
  mesh::Box box{piece.points.back(), piece.points.back()};
  for (std::size_t v = first; v < piece.points.size(); ++v) {
    box.extend({piece.points[v], piece.points[v]});
    if (moves_)
      box.extend({piece.earlier[v], piece.earlier[v]});
  }
  // Coordinates between the steps may be beyond both by rounding.
  box = wider_box(box, 1e-9 * std::max({box.size().x, box.size().y, box.size().z}));
  if (groups_.empty() || groups_.back().cells.size() == Group::size)
    groups_.push_back({box, {}, {}});
  groups_.back().all.extend(box);
  groups_.back().boxes.push_back(box);
  groups_.back().cells.push_back(id);
}

} // namespace insitu::advect
