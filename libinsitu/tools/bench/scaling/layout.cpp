#include "scaling/layout.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "workload/flow.h"

namespace insitu::bench::scaling {

using math::Vec3d;

Layout::Part Layout::part(int rank) const {
  const std::array<int, 3> at = place(rank);
  Part part{};
  for (std::size_t a = 0; a < 3; ++a) {
    part.first[a] = int(std::int64_t(cells[a]) * at[a] / parts[a]);
    part.end[a] = int(std::int64_t(cells[a]) * (at[a] + 1) / parts[a]);
  }
  return part;
}

Vec3d Layout::vertex(int i, int j, int k) const {
  const auto [nx, ny, nz] = cells;
  const auto is_inside = [](int at, int n) { return at > 0 && at < n; };
  Vec3d x{width * i, width * j, width * k};
  const auto number = std::uint64_t(i + (nx + std::int64_t(1)) * (j + (ny + std::int64_t(1)) * k));
  if (is_inside(i, nx) && is_inside(j, ny) && is_inside(k, nz))
    for (int a = 0; a < 3; ++a)
      x[a] += jitter * width * (2 * core::random_unit(1, number, std::uint64_t(a)) - 1);
  return x;
}

Vec3d Layout::low(const Part& part) const {
  return {width * part.first[0], width * part.first[1], width * part.first[2]};
}
Vec3d Layout::high(const Part& part) const {
  return {width * part.end[0], width * part.end[1], width * part.end[2]};
}

Layout make_layout(int processes, std::int64_t cells, bool weak, double jitter) {
  Layout layout;
  layout.processes = processes;
  layout.jitter = jitter;
  int rest = processes;
  for (int factor = 2; rest > 1; ++factor)
    for (; rest % factor == 0; rest /= factor) // across the axis that has the fewest cuts
      *std::min_element(layout.parts.begin(), layout.parts.end()) *= factor;
  const int n = std::max(2, int(std::lround(std::cbrt(double(cells)))));
  layout.width = 1.0 / n;
  for (std::size_t a = 0; a < 3; ++a)
    layout.cells[a] = weak ? n * layout.parts[a] : n;
  return layout;
}

PartMesh make_part(const Layout& layout, int rank) {
  PartMesh mesh;
  const Layout::Part part = layout.part(rank);
  const Vec3d middle = 0.5 * layout.size();
  const std::int64_t nx = layout.cells[0], ny = layout.cells[1];
  for (int k = part.first[2]; k <= part.end[2]; ++k)
    for (int j = part.first[1]; j <= part.end[1]; ++j)
      for (int i = part.first[0]; i <= part.end[0]; ++i) {
        const Vec3d x = layout.vertex(i, j, k);
        const Vec3d flow = workload::abc_flow(x), from = x - middle;
        mesh.points.insert(mesh.points.end(), {x.x, x.y, x.z});
        mesh.velocity.insert(mesh.velocity.end(), {flow.x, flow.y, flow.z});
        mesh.distance.push_back(std::sqrt(dot(from, from)));
      }
  const int row = part.count(0) + 1, plane = row * (part.count(1) + 1);
  for (int k = 0; k < part.count(2); ++k)
    for (int j = 0; j < part.count(1); ++j)
      for (int i = 0; i < part.count(0); ++i) {
        const int v = i + row * j + plane * k;
        mesh.connectivity.insert(mesh.connectivity.end(),
                                 {v, v + 1, v + row + 1, v + row, v + plane, v + plane + 1,
                                  v + plane + row + 1, v + plane + row});
        mesh.ids.push_back((i + part.first[0]) +
                           std::int64_t(nx) *
                               ((j + part.first[1]) + std::int64_t(ny) * (k + part.first[2])));
      }
  return mesh;
}

} // namespace insitu::bench::scaling
