#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace insitu::output {

enum class VtkScalar { float32, float64, int8, uint8, int32, int64 };

/// A named array of a VTK file: `tuples` items of `components` values, interleaved, in the caller's
/// memory until the file is written.
struct VtkArray {
  std::string name;
  VtkScalar scalar = VtkScalar::float64;
  int components = 1;
  const void* data = nullptr;
  std::size_t tuples = 0;
};

/// `values` holds components values a tuple. Throws core::Error (INSITU_ERROR_INTERNAL) if its size
/// is no multiple of that.
VtkArray vtk_array(std::string name, std::span<const double> values, int components = 1);
VtkArray vtk_array(std::string name, std::span<const float> values, int components = 1);
VtkArray vtk_array(std::string name, std::span<const std::int64_t> values, int components = 1);
VtkArray vtk_array(std::string name, std::span<const std::int32_t> values, int components = 1);
VtkArray vtk_array(std::string name, std::span<const std::uint8_t> values, int components = 1);

/// What every file holds: points as x, y, z interleaved (float32 or float64), data on points and on
/// cells, and, if has_time, the time as field data "TimeValue", which ParaView shows.
struct VtkDataSet {
  VtkArray points;
  std::vector<VtkArray> point_data;
  std::vector<VtkArray> cell_data;
  bool has_time = false;
  double time = 0;
};

/// Particles (no lines, no quads: each point is a vertex cell), tracks (polylines over the points)
/// or a surface (quads). Cell data: of the lines, then of the quads.
struct VtkPolyData : VtkDataSet {
  /// For polylines: where each line ends in line_points, ascending. A line has at least
  /// one point; since VTK wants two, the file holds a single one twice.
  std::span<const std::int64_t> line_ends;
  /// The point ids of all lines, one after another; empty means 0, 1, 2, ...: points stored line by
  /// line.
  std::span<const std::int64_t> line_points;
  /// Four point ids each, all around.
  std::span<const std::int64_t> quads;
};

/// Writes a file atomically: VTK XML 1.0, UInt64 headers, arrays appended raw in this machine's byte
/// order (named in the file), so nothing is copied or encoded. Throws core::Error:
/// INSITU_ERROR_ARGUMENT naming the array whose count does not fit, INSITU_ERROR_FILE if the file
/// cannot be written.
void write_vtp(const std::string& path, const VtkPolyData& data);

} // namespace insitu::output
