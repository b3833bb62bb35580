#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "cells/kernels/faces.h"
#include "cells/kernels/ray_cell.h"
#include "query/walk/face_crossing.h"

/// The faces of one cell through which a segment may go out of it.
namespace insitu::query {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// The largest coordinate, without its sign.
double largest(const math::Vec3d& v);
/// The same of all vertices of a cell.
double largest_coordinate(const mesh::CellVertices& c);
/// Of unit length, or 0; neither overflows nor underflows.
math::Vec3d unit(math::Vec3d v);

struct FacePoint {
  math::Vec3d point, normal;
};

/// A segment, and distances along it.
struct Segment {
  math::Vec3d a, b, direction;
  double length;
  cells::RaySpace space;

  Segment(const math::Vec3d& from, const math::Vec3d& to);
  bool valid() const { return length > 0.0 && std::isfinite(length); }
  math::Vec3d at(double distance) const { return distance >= length ? b : a + distance * direction; }
};

/// A face through which the segment may go out, and a point of it a little towards its middle, to
/// look beyond.
struct WayOut : FaceCrossing {
  FacePoint within;
};

/// The ways out of a cell at one distance: faces that meet there.
struct WaysOut {
  double distance = -1.0;
  int count = 0;
  WayOut faces[cells::most_crossings];
};

/// Where the segment, in the cell at distance `from`, leaves it. None: it meets no face, as a
/// segment that grazes a corner may.
WaysOut ways_out(const mesh::CellVertices& c, std::int64_t flat, const Segment& s, double from);

/// The way out at the point of a face where the shape functions are n, brought onto the face.
WayOut on_parametric_face(const mesh::CellVertices& c, std::int64_t flat, int face, const double* n,
                          double t);

} // namespace insitu::query
