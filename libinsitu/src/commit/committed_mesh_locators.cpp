#include <cmath>

#include "commit/committed_mesh.h"
#include "core/status.h"

/// What a committed mesh has to do with the locator that its user chose.
namespace insitu::commit {

namespace {

bool is_within(const math::Vec3d& p, double bound) {
  return std::abs(p.x) < bound && std::abs(p.y) < bound && std::abs(p.z) < bound;
}

} // namespace

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

/// The tree of a mesh that is spread over processes is built with its halo, if somebody asks for
/// that, which looks for it without a tree; cells that wait are not asked for here.
bool CommittedMesh::build_may_wait(const core::Threads& threads) const {
  constexpr double bound = 0.25 * math::largest_coordinate;
  if (cells_wait())
    return true;
  const query::LocatorPick& pick = locators_.pick();
  return mesh_.adaptive().is_part && !in_halo_commit_ && !stand_in_ &&
         pick.method == accel::Method::bvh && pick.backend == accel::Backend::cpu &&
         mesh_.vertices_are_within(bound, threads);
}

/// Rays, devices and stand-ins have structures beside the tree that are made with it. Vertices that
/// are not finite are told by the commit.
bool CommittedMesh::fit_may_wait(const core::Threads& threads) const {
  constexpr double bound = 0.25 * math::largest_coordinate; // from any origin within as well
  const query::LocatorPick& pick = locators_.pick();
  return !locators_.pending() && pick.method == accel::Method::bvh &&
         pick.backend == accel::Backend::cpu && !stand_in_ &&
         (tree_.empty() ? mesh_.adaptive().is_part && fit_.lacks_tree()
                        : is_within(tree_.origin(), bound)) &&
         mesh_.vertices_are_within(bound, threads);
}

std::int64_t CommittedMesh::located() const {
  std::int64_t sum = 0;
  for (const std::int64_t n : locate_counts_.totals())
    sum += n;
  return sum;
}

bool CommittedMesh::many_were_located() const {
  return located_lately_ > 2 * mesh_.view().cell_count();
}

insitu_locator_info CommittedMesh::locator_info() const {
  require_a_commit();
  return locators_.info(fit_.lacks_tree() ? tree() : tree_);
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
