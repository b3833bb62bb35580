/// What a committed mesh keeps of the step before, for pathlines.
#include <utility>

#include "commit/committed_mesh.h"
#include "commit/earlier/adaptive_cells.h"
#include "commit/standins/adaptive.h"
#include "mesh/registered/earlier_parts.h"

namespace insitu::commit {

namespace {

/// Whether what is kept on one chart has a place on the other: both are none, or count alike.
bool are_alike(const std::optional<query::ChartImage>& a,
               const std::optional<query::ChartImage>& b) {
  return a.has_value() == b.has_value() && (!a || a->units == b->units);
}

} // namespace

std::optional<query::ChartImage> CommittedMesh::chart() const {
  const query::ChartImage* const image = stand_in_ ? stand_in_->chart() : nullptr;
  return image ? std::optional(*image) : std::nullopt;
}

std::int64_t CommittedMesh::earlier_cells_bytes(const core::Threads& threads) const {
  return is_made() ? 0 : mesh::CellsCopy::bytes_for(mesh_.view(), threads);
}

void CommittedMesh::release_earlier() {
  mesh_.release_earlier();
  earlier_cells_.release();
  earlier_mesh_.reset();
  kept_ = {};
}

bool CommittedMesh::show_earlier(const core::Threads& threads, bool even_if_still) {
  displacement_.forget();
  const bool shows = mesh_.show_earlier(threads, even_if_still);
  if (shows)
    displacement_.put_off(threads.count());
  return shows;
}

void CommittedMesh::hide_earlier() {
  displacement_.forget();
  mesh_.hide_earlier();
}

/// With a halo these are known by their names.
EarlierMesh::Own CommittedMesh::own_cells() const {
  EarlierMesh::Own own{mesh_.view().own_cell_count(), {}, {}};
  if (!halo_ || (is_made() && mesh_.has_stand_in())) // a dual's have numbers
    return own;
  if (mesh_.has_global_ids(INSITU_CELL))
    for (std::int64_t flat = 0; flat < mesh_.own_view().own_cell_count(); ++flat)
      own.global.push_back(mesh_.global_id(INSITU_CELL, flat));
  if (is_copied() && mesh_.has_stand_in())
    for (std::int64_t flat = 0; flat < own.cells; ++flat)
      own.places.push_back(stand_in_->place(flat));
  return own;
}

void CommittedMesh::keep_earlier(const std::vector<mesh::KeptField>& fields, bool with_cells,
                                 const core::Threads& threads) {
  if (fields.empty())
    return release_earlier();
  earlier_mesh_.reset();
  mesh_.keep_earlier(fields, threads);
  kept_ = {with_cells,       mesh_.view().covers_once,
           folds_are_known_, sound_.are_inverted(),
           tree_version_,    odd_cells_,
           chart()};
  const bool is_other =
      std::exchange(earlier_cells_version_, topology_version_) != topology_version_;
  if (!kept_.with_cells || is_made())
    earlier_cells_.release();
  else if (earlier_cells_.empty() || is_other)
    earlier_cells_.copy(mesh_.view(), threads);
  if (kept_.with_cells && (is_other || earlier_own_.cells == 0))
    earlier_own_ = own_cells();
  earlier_cells_.set_one_mesh(mesh_.view().one_mesh);
}

void CommittedMesh::set_earlier_aside() {
  aside_.reset();
  aside_.emplace(Aside{mesh_.set_earlier_aside(), earlier_own_, kept_, std::move(earlier_mesh_),
                       topology_version_});
}

void CommittedMesh::put_earlier_back() {
  if (!aside_ || aside_->topology_version != topology_version_) {
    aside_.reset();
    return release_earlier();
  }
  mesh_.put_earlier_back(std::move(aside_->steps));
  earlier_own_ = std::move(aside_->own);
  kept_ = std::move(aside_->kept);
  earlier_mesh_ = std::move(aside_->mesh);
  aside_.reset();
}

/// The cells are about to be others: what was kept of them becomes a mesh of its own. What has
/// become one already, of a step whose particles wait, stays.
void CommittedMesh::part_from_earlier(const core::Threads& threads) {
  mesh::TakenStep step = mesh_.take_earlier(threads);
  const bool whole = !step.fields.empty() && kept_.with_cells && are_alike(kept_.chart, chart());
  const bool moved = kept_.tree_version != tree_version_ || fit_.is_due(); // and not the copies
  if (whole && is_made())
    earlier_mesh_ = std::make_unique<EarlierMesh>(std::move(step), std::move(stand_in_),
                                                  tree_.take(), topology_version_, threads);
  else if (whole && !earlier_cells_.empty() && !tree_is_stale_ && !fit_.lacks_tree())
    earlier_mesh_ =
        std::make_unique<EarlierMesh>(std::move(step), std::move(earlier_cells_), tree_.take(),
                                      moved, kept_, topology_version_, *memory_, threads);
  if (whole && earlier_mesh_)
    earlier_mesh_->set_own(std::exchange(earlier_own_, {}));
  earlier_cells_ = mesh::CellsCopy(*memory_);
  kept_ = {};
}

mesh::CellsCopy CommittedMesh::copy_earlier_cells(const core::Threads& threads) const {
  mesh::CellsCopy cells(*memory_);
  if (!is_made() && (kept_.with_cells || mesh_.has_global_ids(INSITU_CELL)))
    cells.copy(mesh::own_part(mesh_.view()), threads);
  return cells;
}

AdaptiveCells CommittedMesh::copy_earlier_adaptive() const {
  const auto* const adaptive = dynamic_cast<const Adaptive*>(stand_in_.get());
  return adaptive && kept_.with_cells ? AdaptiveCells(*adaptive, mesh_.view(), earlier_own_)
                                      : AdaptiveCells();
}

} // namespace insitu::commit
