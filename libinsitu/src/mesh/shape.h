#pragma once

#include <cstdint>

#include "math/hd.h"

namespace insitu::mesh {

/// Cell shapes. Their values and their order of points are those of VTK.
enum class Shape : std::uint8_t {
  none = 0,
  tetrahedron = 10,
  voxel = 11,
  hexahedron = 12,
  wedge = 13,
  pyramid = 14,
};

INSITU_HD constexpr int vertex_count(Shape shape) {
  switch (shape) {
  case Shape::tetrahedron:
    return 4;
  case Shape::pyramid:
    return 5;
  case Shape::wedge:
    return 6;
  case Shape::voxel:
  case Shape::hexahedron:
    return 8;
  case Shape::none:
    break;
  }
  return 0;
}

INSITU_HD constexpr bool is_shape(int value) {
  return value >= 10 && value <= 14;
}

/// VTK's numbers of triangles, pixels and quads, which are cells of flat meshes and no Shape: what
/// is located is what FlatPiece makes of them.
INSITU_HD constexpr bool is_flat_shape(int value) {
  return value == 5 || value == 8 || value == 9;
}

/// The number of vertices of a cell by VTK's number of its type; 0: cells have no such type here.
INSITU_HD constexpr int vertex_count_of(int type) {
  return is_flat_shape(type) ? (type == 5 ? 3 : 4) : is_shape(type) ? vertex_count(Shape(type)) : 0;
}

/// VTK's numbers of cells of fewer than two dimensions, and of fewer than three.
INSITU_HD constexpr bool is_below_area(int value) {
  return (value >= 1 && value <= 4) || value == 21;
}
INSITU_HD constexpr bool is_below_volume(int value) {
  return (value >= 1 && value <= 9) || (value >= 21 && value <= 23);
}

INSITU_HD constexpr const char* shape_name(Shape shape) {
  switch (shape) {
  case Shape::tetrahedron:
    return "tetrahedron";
  case Shape::pyramid:
    return "pyramid";
  case Shape::wedge:
    return "wedge";
  case Shape::voxel:
    return "voxel";
  case Shape::hexahedron:
    return "hexahedron";
  case Shape::none:
    break;
  }
  return "none";
}

} // namespace insitu::mesh
