// Tracers over processes: the particles of one process, to the bit.
#include <cstdlib>

#include "across_runs.h"

namespace insitu::test {
namespace {

TEST(Across, TheWholeMeshEverywhere) {
  for (const Method method : {Method::rk4, Method::dopri5})
    try_all({"hexahedra " + std::to_string(int(method)),
             mesh_of(MeshKind::hexahedra, 6),
             settings_of(method, method == Method::dopri5),
             {}},
            -1);
}

TEST(Across, OneLayerOnEveryShape) {
  for (const MeshKind kind : all_kinds)
    try_all({"shape " + std::to_string(int(kind)),
             mesh_of(kind, 5),
             settings_of(Method::dopri5, true),
             {}},
            1, {3, 8});
}

TEST(Across, OneLayerByEveryMethod) {
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5})
    try_all({"method " + std::to_string(int(method)),
             mesh_of(MeshKind::hexahedra, 6),
             settings_of(method, false),
             {}},
            1, {2, 4});
}

TEST(Across, AMeshThatMoves) {
  Scene scene{"moving", mesh_of(MeshKind::hexahedra, 6), settings_of(Method::dopri5, true), {}};
  scene.moves = true;
  try_all(scene, 1, {2, 4});
}

/// Sums are asserted in every advance. INSITU_TEST_PARTICLES: so many in each of three cycles.
TEST(Across, ManyParticles) {
  Scene scene{"many", mesh_of(MeshKind::hexahedra, 12), settings_of(Method::dopri5, true), {}};
  const char* const asked = std::getenv("INSITU_TEST_PARTICLES");
  scene.many = asked ? std::atoi(asked) : 4000;
  scene.takes_shots = false;
  scene.interval = 0.2;
  const Ran serial = run_on(scene, std::vector<int>(scene.mesh.cells.size()), 1, 0, true);
  EXPECT_EQ(serial.counts.seeded, 3 * scene.many);
  expect_the_same(serial, run_on(scene, boxes(scene.mesh, 8), 8, 1), "many");
}

/// Processes without cells, the root too.
TEST(Across, EmptyProcesses) {
  Scene scene{"empty", mesh_of(MeshKind::hexahedra, 6), settings_of(Method::dopri5, true), {}};
  const Ran serial = run_on(scene, std::vector<int>(scene.mesh.cells.size()), 1, 0, true);
  std::vector<int> process = slabs(scene.mesh, 2);
  for (int& p : process)
    p = 2 * p + 1;
  expect_the_same(serial, run_on(scene, process, 5, 1), "empty");
}

Scene effects_scene(const std::string& name, Method method = Method::dopri5) {
  return {name, mesh_of(MeshKind::hexahedra, 6), settings_of(method, method == Method::dopri5), {}};
}
advect::BoundaryEffect boundary(advect::AtBoundary response) {
  advect::BoundaryEffect effect;
  effect.response = response;
  return effect;
}

TEST(Across, DriftsAndWalls) {
  for (const advect::AtBoundary response :
       {advect::AtBoundary::leave, advect::AtBoundary::stop, advect::AtBoundary::slide,
        advect::AtBoundary::reflect}) {
    Scene scene = effects_scene("response " + std::to_string(int(response)));
    scene.effects.drifts.emplace_back().constant = {0.1, -0.2, 0.3};
    scene.effects.boundary = boundary(response);
    try_all(scene, 1, {2, 4});
  }
}

TEST(Across, PutBack) {
  Scene scene = effects_scene("put back");
  scene.effects.boundary = boundary(advect::AtBoundary::put_back);
  try_all(scene, 1, {2, 4});
  scene.effects.diffusion = advect::Diffusion{{0.02, {}}, {0.01, {}}, 0.0, 7};
  try_all(scene, 1, {2, 4});
}

TEST(Across, RandomWalks) {
  Scene scene = effects_scene("walk");
  scene.effects.diffusion = advect::Diffusion{{0.02, {}}, {0.01, {}}, 0.0, 7};
  try_all(scene, 1, {2, 4});
  scene.effects.boundary = boundary(advect::AtBoundary::slide);
  try_all(scene, 1, {4});
}

TEST(Across, Inertia) {
  for (const advect::AtBoundary response :
       {advect::AtBoundary::leave, advect::AtBoundary::slide, advect::AtBoundary::reflect}) {
    Scene scene = effects_scene("inertia " + std::to_string(int(response)));
    advect::Inertia inertia;
    inertia.response_time = 0.05;
    inertia.acceleration = {0.0, 0.0, -1.0};
    scene.effects.inertia = inertia;
    scene.effects.boundary = boundary(response);
    try_all(scene, 1, {2, 4});
  }
}

} // namespace
} // namespace insitu::test
