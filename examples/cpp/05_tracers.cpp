// 05: tracers. The scene asks for particles that follow the live velocity field from step to step;
// the solver does nothing but execute. Tracks are in insitu_out/drifters*.
#include <insitu/insitu.hpp>
#include <iostream>

constexpr const char* scene = R"(
insitu: 1
output: insitu_out
tracers:
  - name: drifters
    kind: pathline
    velocity: velocity
    seeds: {line: {from: [0.2, 0, 0], to: [0.8, 0, 0], count: 4}}
    output: [csv, vtp]
)";

int main() try {
  constexpr int n = 17;
  const double spacing = 2.0 / (n - 1);
  std::vector<double> u(n * n * n), v(n * n * n), w(n * n * n);

  insitu::Session session({.scene_text = scene});
  insitu::Mesh mesh = session.mesh("flow");
  mesh.uniform_block({n, n, n}, {-1.0, -1.0, -1.0}, {spacing, spacing, spacing});
  mesh.vertex_field("velocity", {u, v, w}); // one array a component
  for (int cycle = 0; cycle <= 20; ++cycle) {
    const double time = 0.1 * cycle;
    for (std::size_t i = 0; i < u.size(); ++i) { // a rotation around z that grows with time
      u[i] = -time * (-1.0 + spacing * static_cast<double>(i / n % n));
      v[i] = time * (-1.0 + spacing * static_cast<double>(i % n));
    }
    mesh.changed(insitu::fields);
    session.execute(cycle, time);
  }
  const insitu::Report report = session.report();
  std::cout << report.particles_seeded << " particles, " << report.particles[INSITU_END_ALIVE]
            << " still alive after 20 steps\n";
  session.close();
  return report.particles_seeded == 4 && report.particles[INSITU_END_ALIVE] == 4 ? 0 : 1;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
