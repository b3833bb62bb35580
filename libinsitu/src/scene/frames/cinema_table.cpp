#include "scene/frames/cinema_table.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/status.h"
#include "core/text.h"
#include "core/unsigned_zero.h"
#include "output/files/atomic_file.h"
#include "scene/run/growing_table.h"

namespace insitu::scene {

namespace {

const char* name_of(ImageKind kind) {
  switch (kind) {
  case ImageKind::color:
    break;
  case ImageKind::depth:
    return "depth";
  case ImageKind::cell:
    return "cell";
  }
  return "color";
}

/// A number that is a number of floating point to every reader: tools for Cinema databases take a
/// column's type from its first row.
std::string real(double value) {
  std::string text;
  output::append_number(text, core::unsigned_zero(value));
  if (!text.empty() && text.find_first_not_of("-0123456789") == std::string::npos)
    text += ".0";
  return text;
}

void add_once(std::vector<std::string>& all, const std::string& one) {
  if (std::find(all.begin(), all.end(), one) == all.end())
    all.push_back(one);
}

/// The cells of a line of CSV without its end.
std::vector<std::string> cells_in(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += line[i++];
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += line[i];
  }
  return cells;
}

/// Gives the file the columns of both, unless it is absent, empty, or has them already. Returns
/// them.
std::vector<std::string> merge_columns(const std::string& path, std::vector<std::string> columns) {
  const std::string text = core::read_file(path).value_or("");
  std::string_view rest = text;
  std::optional<std::string_view> line = core::take_line(rest);
  if (!line)
    return columns;
  const std::vector<std::string> before = cells_in(*line);
  if (before == columns)
    return columns;
  if (before.front() != "cycle" || before.back() != "FILE")
    throw core::Error(INSITU_ERROR_FILE, "'" + path + "' is another file than a table of frames");
  columns.pop_back();
  for (const std::string& column : before)
    if (column != "FILE")
      add_once(columns, column);
  columns.emplace_back("FILE");
  output::CsvRows rows(columns.size());
  while ((line = core::take_line(rest))) {
    const std::vector<std::string> cells = cells_in(*line);
    for (const std::string& column : columns) {
      const auto at = std::size_t(std::find(before.begin(), before.end(), column) - before.begin());
      rows.cell(std::string_view(at < cells.size() ? cells[at] : std::string()));
    }
    rows.end_row();
  }
  output::write_csv(path, columns, rows);
  return columns;
}

} // namespace

std::string range_label(const Frame& frame, const FrameLayer& layer, const ColorBy& by) {
  const std::string of = frame.layers.size() > 1 ? layer.mesh.text + "_" : std::string();
  return of + (by.component.magnitude() ? by.field.text
                                        : by.field.text + "_" + std::to_string(by.component.index));
}

CameraAngles angles_of(const render::Camera& camera) {
  const math::Vec3d d = camera.position - camera.look_at;
  const auto degrees = [](double radians) {
    return std::round(radians * (180e6 / 3.14159265358979323846)) * 1e-6 + 0.0; // not -0
  };
  const double across = std::hypot(d.x, d.y);
  // Straight above there is no azimuth: that of the viewer who came up, as Camera::around() has it.
  const math::Vec3d from = across > 1e-9 * std::fabs(d.z) ? d : d.z > 0 ? -camera.up : camera.up;
  return {degrees(std::atan2(from.y, from.x)), degrees(std::atan2(d.z, across))};
}

CinemaTable::CinemaTable(const std::vector<Frame>& frames, const std::string& folder)
    : path_(folder + "/data.csv"), columns_{"cycle", "time", "name"} {
  bool cameras = false, images = false, meshes = false, formats = false, depth = false;
  std::vector<std::string> ranges;
  for (const Frame& frame : frames) {
    frames_.push_back(frame.name);
    cameras |= !frame.cameras.empty();
    images |= frame.images != std::vector{ImageKind::color};
    for (const ImageKind kind : frame.images)
      meshes |= image_meshes(frame, kind) != std::vector<std::string>{""};
    formats |= frame.formats != std::vector{ImageFormat::png};
    depth |= std::count(frame.images.begin(), frame.images.end(), ImageKind::depth) > 0;
    for (const FrameLayer& layer : frame.layers)
      for (const ColorBy* by : colorings_of(layer))
        add_once(ranges, range_label(frame, layer, *by));
  }
  if (cameras)
    columns_.emplace_back("camera");
  if (images)
    columns_.emplace_back("image");
  if (meshes)
    columns_.emplace_back("mesh");
  if (formats)
    columns_.emplace_back("format");
  columns_.insert(columns_.end(), {"phi", "theta", "camera_x", "camera_y", "camera_z"});
  for (const std::string& range : ranges) {
    columns_.push_back(range + "_low");
    columns_.push_back(range + "_high");
  }
  if (depth)
    columns_.insert(columns_.end(), {"depth_low", "depth_high"});
  columns_.emplace_back("FILE");
}

CinemaTable::~CinemaTable() = default;

void CinemaTable::open(std::int64_t cycle) {
  columns_ = merge_columns(path_, columns_);
  table_ = std::make_unique<output::AppendTable>(path_, columns_, cycle);
}

void CinemaTable::begin_step(bool again) {
  if (again)
    return;
  step_.clear();
  begin_ = table_ ? table_->end() : 0;
}

/// By column.
std::vector<std::string> CinemaTable::cells_of(const CinemaRow& row) const {
  const CameraAngles angles = angles_of(row.view);
  std::map<std::string, std::string> cells{
      {"cycle", std::to_string(row.cycle)},
      {"time", real(row.time)},
      {"name", row.name},
      {"camera", row.camera},
      {"image", name_of(row.image)},
      {"mesh", row.mesh},
      {"format", row.format == ImageFormat::exr ? "exr" : "png"},
      {"phi", real(angles.azimuth)},
      {"theta", real(angles.elevation)},
      {"camera_x", real(row.view.position.x)},
      {"camera_y", real(row.view.position.y)},
      {"camera_z", real(row.view.position.z)},
      {"FILE", row.file}};
  const auto add_range = [&](const std::string& label, const ValueRange& range) {
    cells.emplace(label + "_low", real(range.low)); // the first of one label counts
    cells.emplace(label + "_high", real(range.high));
  };
  for (const auto& [label, range] : row.ranges)
    add_range(label, range);
  if (row.depth)
    add_range("depth", *row.depth);
  std::vector<std::string> out;
  for (const std::string& column : columns_)
    out.push_back(cells[column]);
  return out;
}

void CinemaTable::add(const Rows& rows) {
  for (const std::vector<std::string>& row : rows.cells) {
    for (const std::string& cell : row)
      table_->rows().cell(std::string_view(cell));
    table_->rows().end_row();
  }
}

bool CinemaTable::put(const std::vector<CinemaRow>& rows, const core::Log& log) {
  const bool opens = !table_ && !given_up_;
  if (opens) {
    try {
      open(rows.front().cycle);
      begin_ = table_->end();
    } catch (const core::Error& e) {
      given_up_ = true;
      log.warning(std::string(e.what()) + "; frames are drawn without their table");
    }
  }
  if (given_up_)
    return false;
  const std::string& name = rows.front().name;
  Rows put{
      std::size_t(std::ranges::find(frames_, name) - frames_.begin()), rows.front().camera, {}};
  for (const CinemaRow& row : rows)
    put.cells.push_back(cells_of(row));
  const std::size_t erased = std::erase_if(step_, [&](const Rows& there) {
    return there.place == put.place && there.camera == put.camera;
  });
  const auto at = std::ranges::upper_bound(step_, put.place, {}, &Rows::place);
  const bool is_last = erased == 0 && at == step_.end();
  const Rows& added = *step_.insert(at, std::move(put));
  if (is_last) {
    add(added);
  } else { // all of the step anew
    table_->cut_back(begin_);
    for (const Rows& of_step : step_)
      add(of_step);
  }
  flush_table(*table_);
  return opens;
}

void CinemaTable::finish() {
  if (table_)
    table_->flush();
  table_.reset();
}

} // namespace insitu::scene
