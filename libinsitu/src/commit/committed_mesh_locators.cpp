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

void CommittedMesh::note(const accel::DeviceCounts& counts,
                         std::span<const std::uint8_t> reasons) const {
  locators_.note(counts);
  std::int64_t by_reason[query::reason_count] = {};
  for (const std::uint8_t reason : reasons)
    ++by_reason[reason];
  locate_counts_.add(by_reason);
}

void CommittedMesh::require_adaptive_locator() const {
  const std::string name = "mesh '" + mesh_.name() + "' is adaptive: ";
  if (on_device_)
    throw core::Error(INSITU_ERROR_UNSUPPORTED, name + "its arrays in device memory are not read");
  if (locators_.pick().method != accel::Method::bvh ||
      locators_.pick().backend != accel::Backend::cpu)
    throw core::Error(INSITU_ERROR_UNSUPPORTED, name + "it is located by bvh on the CPU, not by " +
                                                    accel::name(locators_.pick().method) + " on " +
                                                    accel::name(locators_.pick().backend));
}

void CommittedMesh::require_geodetic_locator() const {
  const std::string name = "mesh '" + mesh_.name() + "' is geodetic: ";
  if (mesh_.is_adaptive())
    throw core::Error(INSITU_ERROR_UNSUPPORTED, name + "adaptive meshes are not located in "
                                                       "longitude and latitude; give it in local "
                                                       "or UTM metres");
  if (on_device_ || locators_.pick().backend != accel::Backend::cpu)
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      name + "it is located on the CPU, in host memory, not by " +
                          accel::name(locators_.pick().method) + " on " +
                          accel::name(locators_.pick().backend));
}

} // namespace insitu::commit
