#pragma once

#include <functional>
#include <vector>

#include "fixtures/committed.h"
#include "render/structures/scalar_field.h"
#include "unit/render/render_mesh.h"

namespace insitu::test {

constexpr insitu_block_kind block_kinds[] = {INSITU_BLOCK_UNIFORM, INSITU_BLOCK_RECTILINEAR,
                                             INSITU_BLOCK_CURVILINEAR};

/// The unit box as a structured block of n vertices a side with a field of its vertices; all but a
/// uniform one have uneven planes.
struct BlockMesh {
  BlockMesh(insitu_block_kind kind, int n, const std::function<double(const Vec3d&)>& f) {
    const int last = n - 1;
    for (int i = 0; i < n; ++i)
      axis.push_back(kind == INSITU_BLOCK_UNIFORM
                         ? i / double(last)
                         : double(i * i + 3 * i) / (last * last + 3 * last));
    for (const double z : axis)
      for (const double y : axis)
        for (const double x : axis) {
          points.insert(points.end(), {x, y, z});
          values.push_back(f({x, y, z}));
        }
    insitu_block block = insitu_block_default();
    block.kind = kind;
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = n;
      block.spacing[a] = 1.0 / last;
    }
    mesh::Mesh& mesh = committed.mesh.mesh();
    const insitu_array along_axis = insitu_array_of(axis.data(), INSITU_FLOAT64, n, 1);
    const insitu_array all =
        insitu_array_of(points.data(), INSITU_FLOAT64, std::int64_t(points.size() / 3), 3);
    if (kind == INSITU_BLOCK_RECTILINEAR)
      for (insitu_array& coordinates : block.coordinates)
        coordinates = along_axis;
    else if (kind == INSITU_BLOCK_CURVILINEAR)
      mesh.set_points(0, &all, 1);
    mesh.set_block(0, &block);
    const insitu_array v =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
    mesh.set_field(0, "f", INSITU_VERTEX, &v, 1);
    committed.commit();
    field = {mesh.field("f"), -1};
  }

  fixtures::Committed committed;
  std::vector<double> axis, points, values;
  render::ScalarField field;
};

} // namespace insitu::test
