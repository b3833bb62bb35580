#include "scene/run/mesh_plan.h"

namespace insitu::scene {

void plan_mesh(const commit::CommittedMesh& mesh, Plan& plan) {
  const auto held = [&](const char* item, std::int64_t bytes, std::string why) {
    plan.need(item, bytes, std::move(why), Plan::Held::with_mesh);
  };
  const insitu_locator_info info = mesh.locator_info();
  const std::int64_t tree = mesh.standing_tree().bytes(), faces = mesh.locators().faces().bytes();
  held("tree", tree, "built at the first commit");
  if (faces > 0) {
    held("face table of the locator", faces, "the faces that its method shoots rays at");
    held("structures of the locator", info.bytes - tree - faces, info.reason);
  } else if (info.bytes > tree) {
    held("structures of the locator", info.bytes - tree, info.reason);
  } else {
    plan.skip("face table of the locator", "points are located by the tree");
  }
  if (!mesh.mesh().is_adaptive())
    plan.skip("dual mesh", "the mesh is not adaptive");
  else if (mesh.mesh().reconstruction() != INSITU_DUAL)
    plan.skip("dual mesh", "the reconstruction is by nearest leaves");
  if (const auto more = mesh.stand_in() ? mesh.stand_in()->held() : std::nullopt)
    held(more->item, more->bytes, more->why);
}

} // namespace insitu::scene
