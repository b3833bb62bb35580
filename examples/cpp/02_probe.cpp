// 02: the solver's own queries. No scene: commit, then locate and sample points at any time until
// the arrays change.
#include <cmath>
#include <insitu/insitu.hpp>
#include <iostream>

int main() try {
  // Two tetrahedra; temperature 1 + 2x + 3y + 4z on vertices, a material number on cells.
  const std::vector<float> xyz{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  const std::vector<int> connectivity{0, 1, 2, 3, 1, 2, 3, 4};
  const std::vector<double> temperature{1, 3, 4, 5, 10};
  const std::vector<float> material{7, 8};

  insitu::Session session;
  insitu::Mesh mesh = session.mesh("solid");
  mesh.points(xyz); // containers bring their sizes
  mesh.tetrahedra(connectivity);
  mesh.vertex_field("temperature", temperature);
  mesh.cell_field("material", material);
  mesh.commit();

  // Many points and several fields at once.
  const std::vector<std::array<double, 3>> points{{0.1, 0.2, 0.3}, {0.6, 0.6, 0.5}, {2, 2, 2}};
  const insitu::FieldSamples samples = mesh.sample_fields({"temperature", "material"}, points);
  for (std::size_t p = 0; p < points.size(); ++p)
    std::cout << "cell " << samples.cells[p] << ", temperature " << samples.values[0].values[p]
              << ", material " << samples.values[1].values[p] << '\n';

  // One field, exactly decided at boundaries: the vertex shared by both belongs to the lower cell.
  insitu::LocateOptions exact;
  exact.accuracy = insitu::Accuracy::exact;
  const std::vector<double> vertex{0, 1, 0};
  const insitu::Samples t = mesh.sample("temperature", vertex, exact);
  std::cout << "at a vertex: cell " << t.cells[0] << ", temperature " << t(0) << '\n';

  // One point, nothing allocated.
  double value = 0;
  const bool inside = mesh.sample_point("temperature", points[0], {&value, 1});

  const bool right = std::abs(samples.values[0].values[1] - 6.0) < 1e-6 && !samples.found[2] &&
                     std::isnan(samples.values[1].values[2]) && t.cells[0] == 0 && inside &&
                     value == samples.values[0].values[0];
  return right ? 0 : 1;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
