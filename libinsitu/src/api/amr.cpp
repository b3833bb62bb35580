/// The entry points of insitu/c/amr.h.
#include "api/entry.h"

using namespace insitu;
using api::with_mesh;

extern "C" {

insitu_status insitu_mesh_amr(insitu_mesh mesh, const insitu_amr* amr) {
  return with_mesh(mesh, [&](api::Session&, query::CommittedMesh& m) { m.mesh().set_amr(amr); });
}

insitu_status insitu_mesh_patch(insitu_mesh mesh, int32_t piece, const insitu_patch* patch) {
  return with_mesh(
      mesh, [&](api::Session&, query::CommittedMesh& m) { m.mesh().set_patch(piece, patch); });
}

insitu_status insitu_mesh_leaves(insitu_mesh mesh, int32_t piece, const insitu_leaves* leaves) {
  return with_mesh(
      mesh, [&](api::Session&, query::CommittedMesh& m) { m.mesh().set_leaves(piece, leaves); });
}

} // extern "C"
