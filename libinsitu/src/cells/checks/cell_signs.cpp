#include "cells/checks/cell_signs.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cells/checks/cell_signs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/kernels/kernels_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::cells::HWY_NAMESPACE {

template <Shape S>
void look(const CellBlock& block, CellSigns& out) {
  const int lanes = int(hn::Lanes(PackTag()));
  for (int i = 0; i < block.count; i += lanes) {
    Vec3<Pack> x[8];
    for (int v = 0; v < vertex_count(S); ++v)
      x[v] = {load_pack(block.vertex[v][0] + i), load_pack(block.vertex[v][1] + i),
              load_pack(block.vertex[v][2] + i)};
    const JacobianSigns<Pack> found = jacobian_signs(S, x);
    out.positive |= std::uint64_t(lane_bits(found.positive)) << i;
    out.negative |= std::uint64_t(lane_bits(found.negative)) << i;
    out.coincident |= std::uint64_t(lane_bits(found.coincident)) << i;
    out.unsure |= std::uint64_t(lane_bits(found.unsure)) << i;
  }
}

void cell_signs_target(Shape shape, const CellBlock& block, CellSigns& out) {
  switch (shape) {
  case Shape::tetrahedron:
    return look<Shape::tetrahedron>(block, out);
  case Shape::voxel:
    return look<Shape::voxel>(block, out);
  case Shape::hexahedron:
    return look<Shape::hexahedron>(block, out);
  case Shape::wedge:
    return look<Shape::wedge>(block, out);
  case Shape::pyramid:
    return look<Shape::pyramid>(block, out);
  case Shape::none:
    break;
  }
}

} // namespace insitu::cells::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::cells {

HWY_EXPORT(cell_signs_target);

CellSigns cell_signs(mesh::Shape shape, CellBlock& block) {
  block.fill_up(shape);
  CellSigns out;
  HWY_DYNAMIC_DISPATCH(cell_signs_target)(shape, block, out);
  const std::uint64_t all = block.all();
  return {out.positive & all, out.negative & all, out.coincident & all, out.unsure & all};
}

} // namespace insitu::cells
#endif
