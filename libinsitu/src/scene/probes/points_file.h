#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "math/vec.h"
#include "scene/parse/description.h"

namespace insitu::scene {

/// The points of a CSV file, in its order.
struct PointTable {
  std::string file;
  std::vector<math::Vec3d>
      points; ///< x, y, z; or longitude, latitude (degrees) and height or depth (metres)
  std::vector<std::string> names; ///< of the column "name"; one for each point, or none
  bool geographic = false;        ///< the columns are longitude and latitude
  bool depth = false;             ///< geographic: the third is a depth, positive down
};

/// Reads a CSV file of points. The first line names the columns, in any order and case: x, y, z, or
/// lon (longitude), lat (latitude) and height or depth; optionally name. Other columns are left
/// aside. Fields are separated by commas and may stand within double quotes; blank lines and lines
/// that begin with '#' are skipped. Throws core::Error(INSITU_ERROR_FILE) where the file cannot be
/// read, core::Error(INSITU_ERROR_SCENE) with the problems
/// ("file:line:column: ...", Problems::most at most; the column counts bytes from 1) of its text.
PointTable read_points_file(const std::string& path);

/// The text of the file alone.
std::string read_points_text(const std::string& path);
/// The same of a text; `file` stands in messages.
PointTable parse_points_text(std::string_view text, const std::string& file);

/// The frame that the table's points are in: the one that the scene states, or geodetic where it
/// states none and the columns are longitude and latitude. Throws core::Error(INSITU_ERROR_SCENE)
/// where both contradict each other.
FrameOfReference frame_of(const PointTable& table, const FrameOfReference& stated,
                          const std::string& scene_file);

} // namespace insitu::scene
