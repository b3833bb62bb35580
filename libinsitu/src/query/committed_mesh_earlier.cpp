/// What a committed mesh keeps of the step before, for pathlines.
#include "query/committed_mesh.h"

namespace insitu::query {

/// On a geodetic mesh steps go by charts that are made from its cells; leaves by `nearest` are the
/// solver's arrays.
bool CommittedMesh::can_keep_cells() const {
  return frame.kind != INSITU_FRAME_GEODETIC && !geodetic_ &&
         (!adaptive_ || adaptive_->dual_view());
}

std::int64_t CommittedMesh::earlier_cells_bytes(const core::Threads& threads) const {
  return can_keep_cells() && !adaptive_ ? mesh::CellsCopy::bytes_for(mesh_.view(), threads) : 0;
}

void CommittedMesh::release_earlier() {
  mesh_.release_earlier();
  earlier_cells_.release();
  earlier_mesh_.reset();
  kept_ = {};
}

void CommittedMesh::keep_earlier(const std::vector<mesh::KeptField>& fields, bool with_cells,
                                 const core::Threads& threads) {
  if (fields.empty())
    return release_earlier();
  earlier_mesh_.reset();
  mesh_.keep_earlier(fields, threads);
  kept_ = {with_cells && can_keep_cells(), mesh_.view().covers_once, tree_version_, odd_cells_};
  if (!kept_.with_cells || adaptive_) {
    earlier_cells_.release();
  } else if (earlier_cells_.empty() || earlier_cells_version_ != topology_version_) {
    earlier_cells_.copy(mesh_.view(), threads);
    earlier_cells_version_ = topology_version_;
  }
}

/// The cells are about to be others: what was kept of them becomes a mesh of its own. What has
/// become one already, of a step whose particles wait, stays.
void CommittedMesh::part_from_earlier(const core::Threads& threads) {
  mesh::TakenStep step = mesh_.take_earlier();
  const bool whole = !step.fields.empty() && kept_.with_cells && can_keep_cells();
  const bool moved = kept_.tree_version != tree_version_; // and not the copies
  if (whole && adaptive_)
    earlier_mesh_ = std::make_unique<EarlierMesh>(std::move(step), std::move(adaptive_),
                                                  tree_.take(), topology_version_);
  else if (whole && !earlier_cells_.empty() && !tree_is_stale_)
    earlier_mesh_ = std::make_unique<EarlierMesh>(std::move(step), std::move(earlier_cells_),
                                                  tree_.take(), moved, kept_.odd, kept_.covers_once,
                                                  topology_version_, threads);
  earlier_cells_ = mesh::CellsCopy(*memory_);
  kept_ = {};
}

void CommittedMesh::restore_earlier_mesh(const mesh::EarlierStep& step, mesh::CellsCopy cells,
                                         const core::Threads& threads) {
  earlier_mesh_ = EarlierMesh::restored(step, std::move(cells), *memory_, threads);
}

} // namespace insitu::query
