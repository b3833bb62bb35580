#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/log.h"
#include "output/files/csv.h"
#include "render/camera/camera.h"
#include "scene/parse/description.h"

namespace insitu::scene {

/// The number by which a frame colours, in the names of columns: "density", "velocity",
/// "velocity_0"; of several meshes "water_velocity_0".
std::string range_label(const Frame& frame, const FrameLayer& layer, const ColorBy& by);

/// One file of a frame, for the table.
struct CinemaRow {
  std::int64_t cycle = 0;
  double time = 0;
  std::string name, camera; ///< of the frame, and of its camera where it has several
  ImageKind image = ImageKind::color;
  std::string mesh; ///< of an image of its cells, where the frame has several
  ImageFormat format = ImageFormat::png;
  render::Camera view;
  std::vector<std::pair<std::string, ValueRange>> ranges; ///< of the colours, by range_label()
  std::optional<ValueRange> depth;                        ///< of a depth image
  std::string file;                                       ///< relative to the table's folder
};

/// The table of the files of all frames, `data.csv` in the output folder, which makes the folder a
/// Cinema database of specification D (cinemascience.org): one row a file, its parameters in
/// columns, its name in the last one, FILE. Rows go by steps and in these by the scene's frames:
/// those of a frame that is done when a step comes again are put before those of later frames.
/// Columns that the scene's frames do not need are left out. It is opened with the first row: rows
/// of an earlier run from that cycle on go, the others stay, and columns that only the earlier run
/// had stay too, empty from then on. Where the file cannot be opened a warning says so, and frames
/// are drawn without it.
class CinemaTable {
public:
  CinemaTable(const std::vector<Frame>& frames, const std::string& folder);
  ~CinemaTable();

  /// A step begins, or comes again.
  void begin_step(bool again);
  /// Writes the step's rows of one camera of a frame, in place of any that are there; returns
  /// whether it opened the file. Throws core::Error (INSITU_ERROR_FILE) if they cannot be appended.
  bool put(const std::vector<CinemaRow>& rows, const core::Log& log);
  void finish();

  const std::vector<std::string>& columns() const { return columns_; }

private:
  /// Rows of one camera of a frame, and the frame's place in the scene.
  struct Rows {
    std::size_t place;
    std::string camera;
    std::vector<std::vector<std::string>> cells; ///< [row][column]
  };
  void open(std::int64_t cycle);
  std::vector<std::string> cells_of(const CinemaRow& row) const;
  void add(const Rows& rows);

  std::string path_;
  std::vector<std::string> frames_; ///< names, as the scene has them
  std::vector<Rows> step_;          ///< what the step has in the table
  std::int64_t begin_ = 0;          ///< where that begins: AppendTable::end() then
  std::vector<std::string> columns_;
  std::unique_ptr<output::AppendTable> table_;
  bool given_up_ = false;
};

/// Degrees, as in a scene: the direction from what a camera looks at to the camera, around +z from
/// +x, and above the xy plane; rounded to 1e-6.
struct CameraAngles {
  double azimuth = 0, elevation = 0;
};
CameraAngles angles_of(const render::Camera& camera);

} // namespace insitu::scene
