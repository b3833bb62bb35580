#include "commit/committed_mesh.h"
#include "core/status.h"

/// What a committed mesh has to do with the locator that its user chose.
namespace insitu::commit {

/// Structures of the locator beside the tree, which stands.
void CommittedMesh::update_locators(std::uint32_t pending, const core::Threads& threads) {
  const auto view = [this]() -> const mesh::MeshView& { return mesh_.view(); };
  const bool anew = locators_.pending() || (pending & INSITU_CHANGED_TOPOLOGY);
  if (anew)
    locators_.make_faces(view, threads);
  const bool moved = (pending & INSITU_CHANGED_GEOMETRY) != 0;
  // Without it candidates prove nothing; on a device that is worth it to many points alone.
  if (!folds_are_known_ && (locators_.rays() || (locators_.device() && many_were_located())))
    set_odd_cells(cells::find_odd_cells(mesh_.view(), threads), threads);
  if ((anew || moved) && folds_are_known_)
    look_for_overlaps(threads);
  locators_.commit(mesh_, view, pending, threads);
}

bool CommittedMesh::many_were_located() const {
  return located_lately_ > 2 * mesh_.view().cell_count();
}

insitu_locator_info CommittedMesh::locator_info() const {
  require_a_commit();
  return locators_.info(tree_);
}

void CommittedMesh::note(const query::DeviceCounts& counts,
                         std::span<const std::uint8_t> reasons) const {
  locators_.note(counts);
  std::int64_t by_reason[query::reason_count] = {};
  for (const std::uint8_t reason : reasons)
    ++by_reason[reason];
  locate_counts_.add(by_reason);
}

} // namespace insitu::commit
