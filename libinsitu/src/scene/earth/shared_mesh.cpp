#include "scene/earth/shared_mesh.h"

namespace insitu::scene {

commit::CommittedMesh& SharedMesh::update(const commit::CommittedMesh& own, core::Context& context,
                                          core::FunctionRef<const math::Vec3d*()> points) {
  const bool topology = topology_ != own.topology_version();
  const bool geometry = topology || geometry_ != own.geometry_version();
  if (!geometry && fields_ == own.fields_version())
    return drawn_;
  topology_ = geometry_ = fields_ = 0; // until it is done
  if (geometry)
    points_ = points();
  drawn_.lent_fields_named_in = own.lent_fields_named_in;
  drawn_.mesh().share(own.mesh(), points_);
  drawn_.mesh().clear_pending();
  drawn_.mesh().set_changed(topology   ? INSITU_CHANGED_ALL
                            : geometry ? INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS
                                       : INSITU_CHANGED_FIELDS);
  // What is wrong with the cells was said of own; in coordinates whose third counts downwards they
  // may also be the other way around than here.
  const core::Log silent(
      INSITU_LOG_ERROR, [](insitu_log_level, const char*, void*) {}, nullptr);
  drawn_.commit(context.threads, silent, context.memory, false);
  topology_ = own.topology_version();
  geometry_ = own.geometry_version();
  fields_ = own.fields_version();
  return drawn_;
}

} // namespace insitu::scene
