/// What a committed mesh finds out about its cells for those who ask much: folds, overlaps,
/// neighbours.
#include <string>
#include <utility>

#include "commit/checks/overlaps.h"
#include "commit/committed_mesh.h"
#include "core/status.h"
#include "mesh/one_mesh.h"

namespace insitu::commit {

namespace {

/// How often the tree is asked in vain for a neighbour, a cell, until finding them all would have
/// been as fast. Finding took 0.1 to 0.34 us a tetrahedron, 0.28 a wedge and 0.55 a hexahedron, and
/// saved 0.15 to 0.5, 0.3 and 0.7 us a point on the same busy machine.
constexpr double neighbours_price = 1.0;

/// As the solver counts cells.
std::string sentence_on(const PiecesApart::Overlap& overlap, const mesh::Mesh& mesh,
                        const StandIn* stand_in) {
  const mesh::MeshView& own = mesh.own_view();
  std::string pieces, cells;
  for (const std::int64_t at : {overlap.cell, overlap.other}) {
    const std::int64_t flat = stand_in ? stand_in->place(at).own : at;
    const std::int32_t piece = own.piece_of(flat);
    const std::string number = std::to_string(piece);
    pieces += (pieces.empty() ? "" : " and ") + number;
    cells += (cells.empty() ? "cell " : " and cell ") +
             std::to_string(flat - own.first_cell[piece]) + " of piece " + number;
  }
  return "mesh '" + mesh.name() + "': pieces " + pieces + " overlap: " + cells +
         " share volume, the first such cells that were found; a point in cells of several pieces "
         "belongs to the lowest piece";
}

} // namespace

void CommittedMesh::look_for_folds(const core::Threads& threads) {
  require_committed();
  if (folds_are_known_ || is_made()) // which know their own
    return;
  set_odd_cells(cells::find_odd_cells(mesh_.view(), threads), threads);
}

void CommittedMesh::find_neighbours(const core::Threads& threads) {
  require_committed();
  if (neighbours_ || lies_on_device() || !accel::FaceNeighbours::fits(mesh_.view()))
    return;
  neighbours_ = std::make_unique<accel::FaceNeighbours>(*memory_);
  neighbours_->build(mesh_.view(), threads);
}

void CommittedMesh::find_neighbours_if_due(const core::Threads& threads) {
  if (double(unguided()) > neighbours_price * double(mesh_.view().cell_count()))
    find_neighbours(threads);
}

std::int64_t CommittedMesh::neighbours_bytes(const core::Threads& threads) const {
  const mesh::MeshView& view = mesh_.view();
  return lies_on_device() || !accel::FaceNeighbours::fits(view)
             ? 0
             : accel::FaceNeighbours::bytes(view, threads);
}

void CommittedMesh::forget_neighbours() {
  neighbours_.reset();
  unguided_before_ = locate_counts_.unguided();
}

/// The tree, if it is there, has the mesh's cells. Cells answer alone only in a mesh that is as
/// good as one piece.
void CommittedMesh::set_odd_cells(cells::OddCells odd, const core::Threads& threads) {
  folds_are_known_ = true;
  sound_.close();
  const mesh::MeshView& view = mesh_.view();
  // With a halo there was one a step before, so that the next one comes before this matters.
  const bool halo_follows = fit_.lacks_tree() && halo_ && !in_halo_commit_;
  overlap_.clear();
  if (!mesh::is_one(view) && !tells_one_mesh() && odd.few && !halo_follows && !tree().empty()) {
    const PiecesApart found = look_at_pieces(view, tree(), threads);
    mesh_.set_one_mesh(found.apart);
    if (found.overlap)
      overlap_ = sentence_on(*found.overlap, mesh_, stand_in_.get());
  }
  if (!mesh::is_one(view))
    odd = {};
  odd_cells_ = std::move(odd);
  mesh_.set_free_of_folds(odd_cells_.none());
  if (!odd_cells_.ids.empty())
    fit_.complete(); // which may be a build
  tree_.mark_odd(mesh_.view(), odd_cells_.ids, threads);
}

/// The mesh of a copy has told it, and so have a process's own cells before their halo.
void CommittedMesh::tell_overlap(const core::Log& log) const {
  if (!copied_ && !in_halo_commit_ && !overlap_.empty())
    log.warning(overlap_);
}

/// Worth its time only to candidates: they may then answer alone in `exact`.
void CommittedMesh::look_for_overlaps(const core::Threads& threads) {
  if (locators_.pick().method != accel::Method::bvh)
    mesh_.set_covers_once(covers_once(mesh_.view(), locators_.faces(), tree(), threads));
}

insitu_amr_info CommittedMesh::amr_info() const {
  require_a_commit();
  const auto info = stand_in_ ? stand_in_->amr_info() : std::nullopt;
  if (!info)
    throw core::Error(INSITU_ERROR_ORDER, "mesh '" + mesh_.name() + "' is not an adaptive mesh");
  return *info;
}

} // namespace insitu::commit
