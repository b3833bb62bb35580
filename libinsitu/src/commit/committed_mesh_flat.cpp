/// What a committed mesh knows of a flat mesh of all processes.
#include "commit/committed_mesh.h"
#include "core/status.h"
#include "geo/chart.h"

namespace insitu::commit {

using parallel::Reduction;

/// Longitudes go round, in degrees or radians.
void CommittedMesh::set_flat_turn() {
  const geo::ChartUnits units{reference_frame.angle == INSITU_RADIANS, false, false};
  mesh_.set_flat_turn(reference_frame.kind == INSITU_FRAME_GEODETIC ? units.turn() : 0.0);
}

/// After the mesh's update().
void CommittedMesh::prepare_flat(bool topology, const core::Log& log) {
  if (const std::string left_out = mesh_.left_out();
      topology && !in_halo_commit_ && !left_out.empty())
    log.warning(left_out);
  if (mesh_.is_flat() && locators_.pick().backend != accel::Backend::cpu)
    throw core::Error(INSITU_ERROR_UNSUPPORTED, "mesh '" + mesh_.name() +
                                                    "' is flat: it is located on the CPU, not by " +
                                                    accel::name(locators_.pick().method) + " on " +
                                                    accel::name(locators_.pick().backend));
}

/// What is known of a flat mesh becomes what all processes know. Collective.
void CommittedMesh::reduce_flat(parallel::World& world) {
  const mesh::FlatFacts& mine = mesh_.flat_facts();
  mesh::FlatFacts whole = mine;
  double ends[] = {mine.least, -mine.greatest};
  world.reduce(std::span(ends), Reduction::least);
  whole.least = ends[0];
  whole.greatest = -ends[1];
  world.reduce(std::span(whole.lengths), Reduction::sum);
  world.reduce(std::span(&whole.volumes, 1), Reduction::sum);
  world.agree_after([&] {
    if (whole.any() && whole.volumes > 0)
      throw core::Error(INSITU_ERROR_MESH,
                        "mesh '" + mesh_.name() +
                            "' has volume cells on some processes, and flat ones alone on others");
    const double apart = whole.greatest - whole.least;
    if (whole.any() && apart > mesh::FlatSlab::of(whole).out_of_plane())
      throw core::Error(INSITU_ERROR_MESH, "mesh '" + mesh_.name() +
                                               "' is flat, but from process to process its "
                                               "planes are " +
                                               std::to_string(apart) +
                                               " apart; one plane expected");
  });
  whole_flat_ = whole;
  agreed_flat_ = mine;
  mesh_.set_whole_flat(whole.any() ? &whole_flat_ : nullptr);
}

} // namespace insitu::commit
