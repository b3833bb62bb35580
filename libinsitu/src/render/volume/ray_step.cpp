#include "render/volume/ray_step.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "accel/tree/tree.h"
#include "mesh/box.h"

namespace insitu::render {

using math::Vec3d;

double mesh_diagonal(const query::Sampler& sampler) {
  if (sampler.tree().empty())
    return 1.0;
  const Vec3d d = sampler.tree().bounds_max() - sampler.tree().bounds_min();
  const double length = std::sqrt(dot(d, d));
  return length > 0 ? length : 1.0;
}

double typical_cell_size(const query::Sampler& sampler) {
  const accel::Tree& tree = sampler.tree();
  const double across = mesh_diagonal(sampler);
  if (tree.empty())
    return across;
  constexpr std::int64_t most = 4096;
  const std::int64_t count = tree.cell_count(), picked = std::min(count, most);
  std::vector<double> sizes;
  sizes.reserve(std::size_t(picked));
  mesh::CellVertices cell;
  for (std::int64_t i = 0; i < picked; ++i) {
    mesh::gather(sampler.mesh(), std::int64_t(tree.cells()[i * count / picked]), cell);
    const Vec3d d = mesh::box_of(cell).size();
    sizes.push_back(std::cbrt(d.x * d.y * d.z));
  }
  const auto middle = sizes.begin() + std::ptrdiff_t(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle > 0 ? std::max(*middle, across / 16384) : across / 256;
}

} // namespace insitu::render
