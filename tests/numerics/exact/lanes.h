#pragma once

#include <cstdint>
#include <vector>

#include "cells/kernels/contain_filter.h"
#include "cells/kernels/kernels.h"

/// The kernels that run over packs, behind run-time dispatch to every SIMD target of the machine.
namespace insitu::test {

/// (cell, point) pairs of one shape, transposed.
struct LaneBlock {
  static constexpr int size = 64;
  int count = 0;
  alignas(64) double vertex[8][3][size];
  alignas(64) double point[3][size];

  void add(mesh::Shape shape, const math::Vec3d* x, const math::Vec3d& p) {
    for (int a = 0; a < 3; ++a) {
      for (int v = 0; v < mesh::vertex_count(shape); ++v)
        vertex[v][a][count] = x[v][a];
      point[a][count] = p[a];
    }
    ++count;
  }
};

/// cells::filter of each pair, on the target in use. block.count is a multiple of eight.
void filter_lanes(mesh::Shape shape, const LaneBlock& block, cells::FilterResult* out);

/// cells::inverse_map of each pair, likewise.
void invert_lanes(mesh::Shape shape, const LaneBlock& block, cells::InverseMap<double>* out);

} // namespace insitu::test
