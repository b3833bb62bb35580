/// Walls, periodic sides, releases, lines, effects and lights of a scene: mpiexec -n 1, 2, 4. What
/// the session of all processes writes is what one process writes that has the whole meshes.
#include <filesystem>
#include <functional>
#include <insitu/insitu.hpp>
#include <string>
#include <vector>

#include "api/mpi/files.h"
#include "api/mpi/main.h"
#include "api/mpi/slab.h"

namespace {

/// The slab's vertices move, but for the planes that are the sides of the whole.
void keep_sides(Slab& slab, int cycle) {
  constexpr int n = side + 1;
  std::size_t at = 0;
  for (const std::int64_t v : slab.vertices) {
    const double i = double(v % n), j = double(v / n % n), k = double(v / n / n);
    const double inside = 0.004 * i * (side - i) * j * (side - j) * k * (side - k) / 27;
    for (const double x :
         {i + inside * std::sin(j + k), j + inside * std::cos(i + 0.3 * cycle), k - inside})
      slab.points[at++] = x;
  }
}

/// A smaller mesh that stands in the first one.
void shrink(Slab& slab) {
  for (double& x : slab.points)
    x = 1.7 + 0.45 * x;
}

/// One process of a solver, with a slab of mesh 'm' and one of mesh 'n', which lie on processes in
/// opposite orders.
struct Solver {
  Slab m, n;
  std::vector<double> spread; ///< at the vertices of m, above 0

  Solver(int rank, int size)
      : m(side * rank / size, side * (rank + 1) / size),
        n(side * (size - 1 - rank) / size, side * (size - rank) / size) {
    for (const std::int64_t v : m.vertices)
      spread.push_back(0.1 + 0.01 * double(v % (side + 1)));
  }

  void step(int cycle) {
    m.step(cycle);
    keep_sides(m, cycle);
    n.step(cycle + 5);
    shrink(n);
  }
};

using Then = std::function<void(insitu::Session&)>;

/// comm: null: of this process alone. then: after all cycles.
void run(Solver solver, const MPI_Comm* comm, const std::string& output, const std::string& scene,
         const Then& then) {
  insitu::Options options;
  options.scene_text = scene;
  options.output = output;
  options.communicator = comm;
  options.log_level = insitu::LogLevel::error;
  insitu::Session session(options);
  for (int cycle = 0; cycle < 4; ++cycle) {
    solver.step(cycle);
    insitu::Mesh m = session.mesh("m"), n = session.mesh("n");
    if (cycle == 0) {
      solver.m.give(m);
      if (!solver.m.empty())
        m.piece(0).vertex_field("spread", solver.spread);
      solver.n.give(n);
    } else { // the arrays stay where they are
      if (!solver.m.empty())
        m.changed(insitu::geometry | insitu::fields);
      if (!solver.n.empty())
        n.changed(insitu::geometry | insitu::fields);
    }
    session.execute(cycle, 0.5 * cycle);
  }
  if (then)
    then(session);
}

void expect_files_of_one_process(const std::string& name, const std::string& scene,
                                 std::size_t least, const Then& then = {}) {
  const std::string alone = name + "_alone", together = name + "_together";
  const std::string text = "insitu: 1\npage: false\n" + scene;
  if (rank() == 0) {
    std::filesystem::remove_all(together);
    std::filesystem::remove_all(alone);
    run(Solver(0, 1), nullptr, alone, text, then);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const MPI_Comm world = MPI_COMM_WORLD;
  run(Solver(rank(), size()), &world, together, text, then);
  if (rank() == 0)
    expect_same_files(alone, together, least);
}

/// A tracer whose seeds lie in both meshes, some on faces and some outside.
std::string tracer(const std::string& name, const std::string& kind, const std::string& more) {
  return "  - {name: " + name + ", velocity: u, kind: " + kind +
         ", seeds: {box: {min: [0.5, 0.5, 0.5], max: [5.5, 4.5, 6.5], counts: [3, 3, 3]}}, "
         "fields: [p, c], " +
         more + "}\n";
}

TEST(ScenesOverMpi, EffectsOnParticles) {
  const auto path = [](const std::string& name, const std::string& effects,
                       const std::string& more = "output: [csv]") {
    return tracer(name, "pathline", more + ", effects: [" + effects + "]");
  };
  expect_files_of_one_process(
      "effects",
      "tracers:\n" + path("slide", "{boundary: slide}, {settling: {speed: 1}}") +
          path("stop", "{boundary: stop}, {windage: {field: u, factor: 0.5}}") +
          path("back", "{boundary: put_back}, {age_limit: 1.2}") +
          path("reflect", "{boundary: reflect}, {remove: {when: p > 1.2 or age > 1.1}}") +
          path("walk", "{diffusion: {horizontal: 0.2, vertical: 0.1, seed: 3}}",
               "times: {interval: 0.2}, output: [csv, vtp, netcdf]") +
          path("field", "{diffusion: {coefficient: spread}}, {boundary: reflect}") +
          path("heavy", "{boundary: {other: reflect, restitution: 0.5}}, {inertia: {response_time: "
                        "0.2, gravity: [0, 0, -2]}}, {coriolis: {rotation: [0, 0, 1]}}") +
          path("massed", "{boundary: slide}, {inertia: {diameter: 0.3, density: 2, fluid_density: "
                         "1, viscosity: 0.2, added_mass: true, velocity: [1, 0, 0]}}"),
      11);
}

TEST(ScenesOverMpi, PeriodicSides) {
  const auto path = [](const std::string& name, const std::string& effects,
                       const std::string& more = "output: [csv, vtp]") {
    return tracer(name, "pathline", more + ", effects: [" + effects + "]");
  };
  expect_files_of_one_process(
      "periodic",
      "tracers:\n" +
          path("all", "{boundary: {periodic: [x, y, z]}}, {settling: {speed: 2}}",
               "times: {interval: 0.2}, output: [csv, netcdf]") +
          path("walk", "{boundary: {periodic: [z], other: reflect}}, {diffusion: {coefficient: "
                       "0.3}}, {settling: {speed: -2}}") +
          path("heavy", "{boundary: {periodic: [x, z], other: slide}}, {inertia: {response_time: "
                        "0.2, gravity: [0, 0, -4]}}") +
          tracer("lines", "streamline",
                 "direction: both, until: {duration: 4}, spacing: {length: 0.2}, every: 3, output: "
                 "[csv, vtp], effects: [{boundary: {periodic: [x, z], other: slide}}, {settling: "
                 "{speed: 1}}]"),
      10);
}

TEST(ScenesOverMpi, ReleasesAndLines) {
  const std::string few = "seeds: [[1, 1, 1], [3, 3, 3], [4.2, 2.1, 5], [9, 0, 0]]";
  expect_files_of_one_process(
      "releases",
      "tracers:\n"
      "  - {name: smoke, velocity: u, kind: streakline, " +
          few +
          ", release: {interval: 0.07}, fields: [p, u, c], output: [csv, vtp, netcdf]}\n"
          "  - {name: puffs, velocity: u, kind: streakline, " +
          few +
          ", release: {every: 2, when: mean(p) < 10}, times: {interval: 0.3}, output: [csv]}\n"
          "  - {name: smaller, mesh: n, velocity: u, kind: pathline, " +
          few + ", release: {interval: 0.2, until: 1}, integrator: {method: rk4, step: 0.7}}\n" +
          tracer("cubic", "pathline",
                 "time_interpolation: cubic, integrator: {method: bs32}, until: {length: 5}") +
          "  - {name: body, kind: pathline, attached: body, " + few +
          ", effects: [{age_limit: 1}]}\n" +
          tracer("both", "streamline",
                 "direction: both, until: {duration: 3}, output: [csv, vtp], every: 2") +
          tracer("even", "streamline",
                 "spacing: {time: 0.1}, until: {duration: 3}, integrator: {method: rk4, step: "
                 "1.5}, effects: [{boundary: slide}], every: 2") +
          tracer("heavy", "streamline",
                 "until: {duration: 2}, every: 2, effects: [{boundary: reflect}, {inertia: "
                 "{response_time: 0.2, gravity: [0, 0, -1]}}]"),
      18);
}

TEST(ScenesOverMpi, LightAndPaths) {
  expect_files_of_one_process(
      "light",
      "frames:\n"
      "  - name: paths\n    size: [24, 22]\n    images: [color, depth, cell]\n    every: 2\n"
      "    volume: {field: p, opacity: [[-1, 0], [1, 0.5]]}\n"
      "    isosurfaces: [{field: p, values: [0.5], opacity: 0.5}]\n"
      "    lights: [{directional: [1, 1, 2]}, {dome: true}]\n"
      "    effects: [multiple_scattering, volume_shadows]\n"
      "    path_tracing: {samples: 2, anisotropy: 0.4}\n"
      "  - name: meshes\n    size: [24, 66]\n    format: [png, exr]\n    every: 2\n"
      "    lights: [{directional: [1, 1, 2]}, {point: [1.5, 0.4, 8], intensity: 20}]\n"
      "    effects: [shadows, volume_shadows, {ambient_occlusion: {samples: 3}}]\n"
      "    scalar_bar: true\n    outline: {ticks: true}\n    meshes:\n"
      "      - {mesh: m, volume: {field: p, opacity: [[-1, 0], [1, 0.1]], shading: true},\n"
      "         isosurfaces: [{field: p, values: [0.9], opacity: 0.7, normals: smooth}]}\n"
      "      - {mesh: n, volume: {field: c, smooth: true, opacity: [[-1, 0], [1, 0.1]]},\n"
      "         boundary: {opacity: 0.6, color: {field: c}}}\n"
      "  - name: held\n    size: [40, 40]\n    samples_per_pixel: 2\n"
      "    clip: [{plane: {point: [3, 3, 3], normal: [1, 0.2, 0.1]}}]\n"
      "    volume: {field: c, tolerance: 0.05, opacity: [[-1, 0], [1, 0.4]]}\n",
      14);
}

/// Steps that are held answer on all processes as they did when they were live.
TEST(ScenesOverMpi, HeldSteps) {
  expect_files_of_one_process(
      "held",
      "hold: {steps: 2}\n"
      "probes:\n"
      "  - {name: gauges, points: [[1, 1, 1], [3, 3, 3], [9, 9, 9]], fields: [p, c], outside: "
      "nearest}\n"
      "tracers:\n" +
          tracer("lines", "streamline", "until: {duration: 1}") +
          "frames:\n"
          "  - {name: seen, size: [24, 24], isosurfaces: [{field: c, values: [0.5]}]}\n",
      14, [](insitu::Session& session) {
        for (const int cycle : {2, 3, 2}) {
          session.show(cycle);
          session.execute(100 + cycle, 0.5 * cycle);
        }
        session.show_live();
      });
}

} // namespace

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}
