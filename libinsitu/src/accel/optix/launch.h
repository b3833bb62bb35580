#pragma once

#include <cstdint>

#include "accel/cuda/device_mesh.h"
#include "accel/faces/face_triangle.h"
#include "math/vec.h"
#include "mesh/view.h"

/// What a launch of programs.cu is given; host and device see the same bytes.
namespace insitu::accel::optix {

/// What the rays are asked for. Each is compiled by itself, with nothing that it does not need.
enum class Ask : std::uint32_t {
  candidates,  ///< cells that may hold the points, for who verifies them
  cells,       ///< the answers of `fast`: owners alone
  cell_values, ///< and values of cell fields: no coordinates are found for them
  interpolated ///< and parametric coordinates, and values of any field
};
constexpr int ask_count = 4;

/// Pointers are the device's. The first two have the pipeline's values: its modules are compiled
/// for these (bound values).
struct Launch {
  std::uint32_t method;
  std::uint32_t ask;
  unsigned long long tree; ///< OptixTraversableHandle

  // The rays.
  const double* points; ///< [][3]
  math::Vec3d origin;   ///< of the local frame
  float length;

  // The primitives.
  const FaceTriangle* triangles; ///< face methods
  const math::Vec3f* vertices;   ///< in the local frame, by flat id
  const std::uint32_t* owners;   ///< user_geometry: the flat cell of a primitive; null: the same
  mesh::MeshView mesh;

  // Outputs by point; null where not asked for.
  std::uint32_t* candidates; ///< flat ids or `none`
  std::int64_t* cells;       ///< -1 outside
  double* parametric;        ///< [][3], NaN outside
  std::uint8_t* reasons;
  const cuda::DeviceField* fields;
  std::int32_t field_count;
  double* const* values; ///< by field: [][components], NaN outside
};

} // namespace insitu::accel::optix
