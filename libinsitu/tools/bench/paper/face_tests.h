#pragma once

#include <cstdint>
#include <span>

#include "query/sampler.h"

namespace insitu::bench::paper {

/// What it costs to tell whether a point lies in a cell, once the cell is known: nanoseconds on one
/// core, in double.
struct FaceTests {
  std::int64_t cells = 0;
  double planar_ns = 0.0;   ///< its side of each face's plane, through three of the vertices
  double bilinear_ns = 0.0; ///< the inverse of the trilinear map by Newton's method, as Open VKL's
  std::int64_t otherwise = 0; ///< told otherwise by the planar one
};
/// Of the points that have a cell, each in its own.
FaceTests time_face_tests(const mesh::MeshView& mesh, std::span<const math::Vec3d> points,
                          std::span<const query::Location> at, int repetitions);

} // namespace insitu::bench::paper
