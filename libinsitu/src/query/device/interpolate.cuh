#pragma once

#include "cells/kernels/kernels.h"
#include "device/cell.cuh"

/// Values of fields in kernels. The sums are those of query::Sampler::interpolate, term by term.
namespace insitu::query::on_device {

/// One component at a place in a gathered cell, from its vertices. weight: of the shape functions.
template <mesh::Shape S>
INSITU_HD inline double interpolated(const mesh::FieldPieceView& from, int component,
                                     const device::Gathered<S>& cell, const double* weight) {
  double sum = weight[0] * from.load(cell.ids[0], component);
  INSITU_UNROLL
  for (int v = 1; v < device::Gathered<S>::count; ++v)
    sum += weight[v] * from.load(cell.ids[v], component);
  return sum;
}

} // namespace insitu::query::on_device
