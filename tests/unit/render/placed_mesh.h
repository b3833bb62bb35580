#pragma once

#include <utility>
#include <vector>

#include "unit/render/render_mesh.h"

namespace insitu::test {

/// A box of cells, moved and stretched.
inline TestMesh placed(int n, Shape shape, const Vec3d& scale, const Vec3d& offset,
                       double jitter = 0.2) {
  TestMesh mesh = box_cells(n, shape, jitter);
  for (Vec3d& p : mesh.vertices)
    for (int a = 0; a < 3; ++a)
      p[a] = offset[a] + scale[a] * p[a];
  return mesh;
}

struct PlacedMesh {
  explicit PlacedMesh(TestMesh from) : cells(std::move(from)), committed(cells) {}
  render::ScalarField field(std::vector<double> of,
                            insitu_association association = INSITU_VERTEX) {
    values = std::move(of);
    const insitu_array a =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
    const char* const name = association == INSITU_VERTEX ? "f" : "c";
    committed.mesh.mesh().set_field(0, name, association, &a, 1);
    committed.commit(INSITU_CHANGED_FIELDS);
    return {committed.mesh.mesh().field(name), -1};
  }
  TestMesh cells;
  fixtures::Committed committed;
  std::vector<double> values;
};

} // namespace insitu::test
