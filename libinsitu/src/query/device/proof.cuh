#pragma once

#include "cells/kernels/contain_filter.h"
#include "cells/kernels/kernels.h"
#include "device/cell.cuh"
#include "query/device/searched_mesh.h"

/// What kernels can tell of a point and a cell in plain double.
namespace insitu::query::on_device {

using device::CellPlace;
using device::for_shape;
using device::Gathered;
using device::place_of;
using math::Vec3d;
using mesh::Shape;

/// What plain double tells of a point and a cell.
enum class Proof : std::uint8_t { outside, inside, undecided, on_vertex };

/// vertex: the first that p is, where that is all that is known.
template <Shape S>
INSITU_HD inline Proof prove(const SearchedMesh& in, std::uint32_t flat, const Vec3d& p,
                             int& vertex) {
  const CellPlace at = place_of<S>(in.mesh, flat);
  return for_shape<S>(at, [&]<Shape Of>() {
    const Gathered<Of> cell(at);
    const cells::FilterResult result = cells::contain_filter<Of>(cell.x, p);
    if (result != cells::FilterResult::undecided)
      return result == cells::FilterResult::inside ? Proof::inside : Proof::outside;
    bool on_vertex = false;
    INSITU_UNROLL
    for (int v = Gathered<Of>::count - 1; v >= 0; --v)
      if (cell.x[v] == p) {
        on_vertex = true;
        vertex = v;
      }
    return on_vertex ? Proof::on_vertex : Proof::undecided;
  });
}

template <Shape S>
INSITU_HD inline cells::InverseMap<double> invert(const Vec3d* x, const Vec3d& p) {
  if constexpr (S == Shape::tetrahedron)
    return cells::inverse_tetrahedron(x, p);
  else if constexpr (S == Shape::pyramid)
    return cells::inverse_pyramid(x, p);
  else if constexpr (S == Shape::wedge)
    return cells::inverse_wedge(x, p);
  else
    return cells::inverse_hexahedron(S, x, p);
}

} // namespace insitu::query::on_device
