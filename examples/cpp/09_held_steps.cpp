// 09: times side by side. The session holds the last three steps; when a gauge has met a threshold,
// the solver looks back at what the gauge read before.
#include <insitu/insitu.hpp>
#include <iostream>

int main() try {
  // One hexahedron whose pressure rises.
  const std::vector<double> x{0, 1, 1, 0, 0, 1, 1, 0}, y{0, 0, 1, 1, 0, 0, 1, 1},
      z{0, 0, 0, 0, 1, 1, 1, 1};
  const std::vector<int> connectivity{0, 1, 2, 3, 4, 5, 6, 7};
  std::vector<double> pressure(8);

  insitu::Session session;
  insitu::Mesh mesh = session.mesh("hydro");
  mesh.points(x.data(), y.data(), z.data(), x.size());
  mesh.hexahedra(connectivity.data(), 1);
  mesh.vertex_field("pressure", pressure.data());
  session.hold(3);

  const std::array<double, 3> gauge{0.5, 0.5, 0.5};
  const auto read_gauge = [&] {
    double value = 0;
    (void)mesh.sample_point("pressure", gauge, {&value, 1});
    return value;
  };
  int cycle = 0;
  for (; cycle == 0 || read_gauge() < 50; ++cycle) {
    for (std::size_t v = 0; v < 8; ++v) // the solver's step
      pressure[v] = cycle * cycle + x[v];
    mesh.changed(insitu::fields);
    session.execute(cycle, 0.1 * cycle);
  }

  std::vector<double> before;
  for (const std::int64_t held : session.held()) {
    session.show(held);
    before.push_back(read_gauge());
    std::cout << "cycle " << held << ": " << before.back() << '\n';
  }
  session.show_live();
  return before == std::vector<double>{36.5, 49.5, 64.5} ? 0 : 1;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
