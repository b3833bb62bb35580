#pragma once

#include <cstdint>

#include "accel/faces/face_triangle.h"
#include "math/vec.h"
#include "query/device/locate_kernels.h"

/// What a launch of programs.cu is given; host and device see the same bytes.
namespace insitu::query::optix {

using accel::FaceTriangle;

/// What the rays are asked for. Each is compiled by itself, with nothing that it does not need.
enum class Ask : std::uint32_t {
  candidates,  ///< cells that may hold the points, for who verifies them
  cells,       ///< the answers of `fast`: owners alone
  cell_values, ///< and values of cell fields: no coordinates are found for them
  interpolated ///< and parametric coordinates, and values of any field
};

/// Set beside the number of a triangle whose back was hit.
constexpr std::uint32_t hit_back = 0x80000000u;

/// Pointers are the device's. The first three have the pipeline's values: its module is compiled
/// for these (bound values).
struct Launch {
  std::uint32_t method;
  std::uint32_t ask;
  std::uint32_t shape;     ///< of all cells, as device::with_shape has it; else Shape::none
  float length;            ///< of the rays
  unsigned long long tree; ///< OptixTraversableHandle
  math::Vec3d origin;      ///< of the local frame

  const FaceTriangle* triangles; ///< face methods
  const math::Vec3f* vertices;   ///< in the local frame, by flat id
  const std::uint32_t* owners;   ///< user_geometry: the flat cell of a primitive

  /// The cells that were found, or `none`; null if not wanted. What else is wanted of `fast`, and
  /// the mesh and the points, are the query's.
  std::uint32_t* candidates;
  std::uint32_t* others; ///< of Ask::candidates: cells beyond the faces that were hit
  on_device::LocateArguments query;
};

} // namespace insitu::query::optix
