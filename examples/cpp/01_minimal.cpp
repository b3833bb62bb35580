// 01: the smallest coupling. Hand over pointers once, execute once a step; the scene says what is
// done: here, a probe that appends a row to insitu_out/point.csv at each cycle.
#include <insitu/insitu.hpp>
#include <iostream>

constexpr const char* scene = R"(
insitu: 1
output: insitu_out
probes:
  - {name: point, points: [[0.25, 0.5, 0.5]], fields: [pressure]}
)";

int main() try {
  // The solver's arrays: one hexahedron.
  const std::vector<double> x{0, 1, 1, 0, 0, 1, 1, 0}, y{0, 0, 1, 1, 0, 0, 1, 1},
      z{0, 0, 0, 0, 1, 1, 1, 1};
  const std::vector<int> connectivity{0, 1, 2, 3, 4, 5, 6, 7};
  std::vector<double> pressure(8);

  insitu::Session session({.scene_text = scene}); // in C++17, set the members of insitu::Options
  insitu::Mesh mesh = session.mesh("hydro");
  mesh.points(x.data(), y.data(), z.data(), x.size());
  mesh.hexahedra(connectivity.data(), 1);
  mesh.vertex_field("pressure", pressure.data());

  int failed = 0;
  for (int cycle = 0; cycle < 5; ++cycle) {
    for (std::size_t v = 0; v < 8; ++v) // the solver's step
      pressure[v] = cycle + x[v];
    mesh.changed(insitu::fields);
    failed += !session.execute(cycle, 0.1 * cycle);
  }
  std::cout << "5 cycles, " << failed << " failed; see insitu_out/point.csv\n";
  return failed;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
