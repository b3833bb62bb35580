// Tracers over processes whose steps go over the cells of several: the particles of one process, to
// the bit.
#include "across_runs.h"

namespace insitu::test {
namespace {

/// Long steps, in slabs that are one cell thick: a step goes over the cells of several processes.
Scene far_scene(const std::string& name, Method method) {
  Scene scene{name + " " + std::to_string(int(method)),
              mesh_of(MeshKind::hexahedra, 8),
              settings_of(method, false),
              {}};
  scene.settings.integrator.step = 0.7;
  scene.settings.integrator.max_step = 0.7;
  scene.settings.integrator.tolerance = 0.1;
  scene.interval = 1.0;
  return scene;
}

/// Steps over several cells at a time, of which others have some, within the mesh and out of it,
/// with snapshots along them.
TEST(Across, LongSteps) {
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5})
    for (const bool turns : {true, false}) {
      Scene scene = far_scene("long steps", method);
      scene.turns = turns;
      try_all(scene, 1, {2, 3, 4, 8});
    }
}

TEST(Across, LongStepsOnOtherShapes) {
  for (const MeshKind kind : {MeshKind::tetrahedra, MeshKind::wedges}) {
    Scene scene = far_scene("long steps of shape " + std::to_string(int(kind)), Method::rk4);
    scene.mesh = mesh_of(kind, 6);
    try_all(scene, 1, {3, 8});
  }
}

TEST(Across, LongStepsOfAMeshThatMoves) {
  for (const Method method : {Method::rk4, Method::dopri5}) {
    Scene scene = far_scene("long steps, moving", method);
    scene.moves = true;
    try_all(scene, 1, {2, 8});
  }
}

TEST(Across, LongStepsToWalls) {
  for (const advect::AtBoundary response :
       {advect::AtBoundary::leave, advect::AtBoundary::stop, advect::AtBoundary::slide,
        advect::AtBoundary::reflect, advect::AtBoundary::put_back}) {
    Scene scene = far_scene("long steps, response " + std::to_string(int(response)), Method::rk4);
    scene.effects.drifts.emplace_back().constant = {0.1, -0.2, 0.3};
    scene.effects.boundary.emplace().response = response;
    try_all(scene, 1, {2, 4, 8});
  }
}

TEST(Across, LongRandomWalks) {
  Scene scene = far_scene("long walk", Method::rk4);
  scene.effects.diffusion = advect::Diffusion{{0.2, {}}, {0.1, {}}, 0.5, 7};
  try_all(scene, 1, {2, 4, 8});
  scene.effects.boundary.emplace().response = advect::AtBoundary::slide;
  try_all(scene, 1, {8});
}

TEST(Across, LongFlights) {
  for (const advect::AtBoundary response :
       {advect::AtBoundary::leave, advect::AtBoundary::slide, advect::AtBoundary::reflect}) {
    Scene scene = far_scene("long flights " + std::to_string(int(response)), Method::rk4);
    advect::Inertia inertia;
    inertia.response_time = 0.5;
    inertia.acceleration = {0.0, 0.0, -1.0};
    scene.effects.inertia = inertia;
    scene.effects.boundary.emplace().response = response;
    try_all(scene, 1, {2, 8});
  }
}

TEST(Across, LongStepsOfManyParticles) {
  Scene scene = far_scene("many long steps", Method::rk4);
  scene.many = 1000;
  scene.effects.boundary.emplace().response = advect::AtBoundary::slide;
  const Ran serial = run_on(scene, std::vector<int>(scene.mesh.cells.size()), 1, 0, true);
  EXPECT_EQ(serial.counts.seeded, 3 * scene.many);
  expect_the_same(serial, run_on(scene, slabs(scene.mesh, 8), 8, 1), "many long steps");
}

} // namespace
} // namespace insitu::test
