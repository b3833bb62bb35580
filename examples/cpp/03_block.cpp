// 03: structured blocks. A solver with ghost layers around its (i, j, k) arrays hands over the
// inner part in place: where it starts, how long it is, and the strides. No connectivity, no copy.
#include <insitu/insitu.hpp>
#include <iostream>

int main() try {
  constexpr std::int64_t n = 6, g = 2, m = n + 2 * g; // cells along each axis, ghost layers
  std::vector<double> rho(m * m * m);                 // i runs fastest
  const auto at = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<std::size_t>((i + g) + m * ((j + g) + m * (k + g)));
  };
  for (std::int64_t k = -g; k < n + g; ++k)
    for (std::int64_t j = -g; j < n + g; ++j)
      for (std::int64_t i = -g; i < n + g; ++i)
        rho[at(i, j, k)] = static_cast<double>(i + 10 * j + 100 * k);

  insitu::Session session;
  insitu::Mesh mesh = session.mesh("block");
  // Evenly spaced here; block() takes points, rectilinear_block() one array an axis.
  mesh.uniform_block({n + 1, n + 1, n + 1}, {0.0, 0.0, 0.0}, {0.5, 0.5, 0.5});
  constexpr std::int64_t bytes = sizeof(double);
  mesh.cell_field(
      "density",
      insitu::Array(&rho[at(0, 0, 0)]).block({n, n, n}, {bytes, bytes * m, bytes * m * m}));
  mesh.commit();

  const std::vector<double> middle_of_4_2_1{2.25, 1.25, 0.75};
  const insitu::Samples density = mesh.sample("density", middle_of_4_2_1);
  std::cout << "density of cell (4, 2, 1): " << density(0) << '\n';
  const bool in_place = mesh.audit().front().data == &rho[at(0, 0, 0)];
  return density(0) == 124.0 && in_place ? 0 : 1;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
