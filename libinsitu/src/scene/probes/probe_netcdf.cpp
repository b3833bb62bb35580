#include "scene/probes/probe_netcdf.h"

#include <algorithm>
#include <limits>

#include "core/status.h"
#include "core/unsigned_zero.h"
#include "scene/earth/cf.h"

namespace insitu::scene {

ProbeNetcdf::ProbeNetcdf(const std::string& name, const Environment& environment, bool moves)
    : name_(name), path_(environment.output + "/" + name + ".nc"), environment_(environment),
      moves_(moves) {}

ProbeNetcdf::~ProbeNetcdf() = default;

namespace {

output::NetcdfVariable fixed(output::NetcdfVariable v, const std::string& dimension) {
  v.per_record = false;
  v.dimensions = {dimension};
  return v;
}

/// Places, levels and distances of a curtain, in its own frame.
void add_curtain(output::NetcdfLayout& out, const CurtainPlaces& curtain) {
  const auto position = cf_position(curtain.frame);
  for (int axis = 0; axis < 2; ++axis) {
    output::NetcdfVariable v = fixed(position[std::size_t(axis)], "station");
    for (const math::Vec3d& p : curtain.stations)
      v.doubles.push_back(core::unsigned_zero(p[axis]));
    out.variables.push_back(std::move(v));
  }
  output::NetcdfVariable levels = fixed(position[2], position[2].name); // its own dimension's
  levels.doubles = curtain.levels;
  out.variables.push_back(std::move(levels));
  output::NetcdfVariable distance;
  distance.name = "distance";
  distance.attributes = {{"long_name", std::string("distance along the curtain")}};
  if (curtain.frame.kind != INSITU_FRAME_CARTESIAN)
    distance.attributes.push_back({"units", std::string("m")});
  distance.doubles = curtain.distances;
  out.variables.push_back(fixed(std::move(distance), "station"));
}

void add_points(output::NetcdfLayout& out, const insitu_frame& frame,
                std::span<const math::Vec3d> points) {
  const auto position = cf_position(frame);
  for (int axis = 0; axis < 3; ++axis) {
    output::NetcdfVariable v = fixed(position[std::size_t(axis)], "station");
    for (const math::Vec3d& p : points)
      v.doubles.push_back(core::unsigned_zero(p[axis]));
    out.variables.push_back(std::move(v));
  }
}

void add_names(output::NetcdfLayout& out, const std::vector<std::string>& names) {
  output::NetcdfVariable v;
  v.name = "station_name";
  v.type = output::NetcdfType::text;
  v.attributes = {{"long_name", std::string("name of the point")}};
  std::size_t longest = 1;
  for (const std::string& name : names)
    longest = std::max(longest, name.size());
  out.dimensions.emplace_back("name_length", std::int64_t(longest));
  for (std::string name : names) {
    name.resize(longest, '\0');
    v.text += name;
  }
  v = fixed(std::move(v), "station");
  v.dimensions.push_back("name_length");
  out.variables.push_back(std::move(v));
}

} // namespace

output::NetcdfLayout ProbeNetcdf::layout(const commit::CommittedMesh& mesh,
                                         const ScenePoints& points,
                                         const ProbeAnswers& answers) const {
  using output::NetcdfVariable;
  const CurtainPlaces* curtain = points.curtain ? &*points.curtain : nullptr;
  const insitu_frame& frame = curtain ? curtain->frame : mesh.reference_frame;
  const auto position = cf_position(frame);
  const auto mapping = cf_grid_mapping(frame);
  const std::size_t n = curtain ? curtain->stations.size() : points.mesh_points.size();
  std::vector<std::string> places{"station"}; // the dimensions of a record
  output::NetcdfLayout out;
  out.record_dimension = "time";
  out.dimensions = {{"station", std::int64_t(n)}};
  if (curtain) {
    places.push_back(position[2].name);
    out.dimensions.emplace_back(places.back(), std::int64_t(curtain->levels.size()));
  }
  out.attributes = curtain ? cf_attributes("timeSeriesProfile", name_, "the curtain's")
                           : cf_attributes(moves_ ? "trajectory" : "timeSeries", name_);
  const auto of_all = [&](NetcdfVariable v) {
    v.dimensions = places;
    return v;
  };
  out.variables = {cf_cycle(), cf_time(), of_all(cf_cell())};
  if (names_.pieces)
    out.variables.push_back(of_all(cf_piece()));
  if (names_.processes)
    out.variables.push_back(of_all(cf_process()));
  if (curtain)
    add_curtain(out, *curtain);
  else if (moves_)
    for (const NetcdfVariable& axis : position)
      out.variables.push_back(of_all(axis));
  else
    add_points(out, frame, points.mesh_points);
  NetcdfVariable station;
  station.name = "station";
  station.type = output::NetcdfType::int64;
  station.attributes = {
      {"long_name", std::string(curtain ? "place along the curtain" : "point of the probe")},
      {"cf_role", std::string(moves_ ? "trajectory_id" : "timeseries_id")}};
  for (std::size_t i = 0; i < n; ++i)
    station.integers.push_back(std::int64_t(i));
  out.variables.push_back(fixed(std::move(station), "station"));
  std::string coordinates =
      position[0].name + " " + position[1].name + " " + (curtain ? "distance" : position[2].name);
  if (!points.names.empty()) {
    add_names(out, points.names);
    coordinates += " station_name";
  }
  if (mapping)
    out.variables.push_back(*mapping);
  for (const char* axis : {"r", "s", "t"}) {
    NetcdfVariable v = of_all(cf_values(out, axis, {}, std::nullopt));
    v.attributes.front() = {"long_name", std::string("parametric coordinate in the cell")};
    out.variables.push_back(std::move(v));
  }
  for (const std::string& column : answers.columns)
    out.variables.push_back(of_all(cf_values(out, column, coordinates, mapping)));
  return out;
}

void ProbeNetcdf::write(const commit::CommittedMesh& mesh, const Step& step,
                        const ScenePoints& points, const ProbeAnswers& answers,
                        const CellNames& names) {
  if (!table_) {
    columns_ = answers.columns;
    names_ = names;
    table_ =
        std::make_unique<output::NetcdfTable>(path_, layout(mesh, points, answers), step.cycle);
    ++environment_.statistics.files;
  } else if (answers.columns != columns_) {
    throw core::Error(INSITU_ERROR_FIELD,
                      "'" + path_ +
                          "' was opened for other fields than this cycle's: they changed during "
                          "the run");
  } else {
    names_.require_for(path_, names);
    one_piece_.say(!names_.pieces && !names_.global && names.pieces, path_,
                   environment_.context.log);
  }
  rows_.write(*table_, step, [&] { add_record(step, points, answers); });
}

void ProbeNetcdf::add_record(const Step& step, const ScenePoints& points,
                             const ProbeAnswers& answers) {
  output::NetcdfRecords& to = table_->rows();
  const std::size_t n = answers.cells.size(), width = answers.columns.size();
  to.put(step.cycle).put(step.time);
  for (const OwnCell& own : answers.cells)
    to.put(names_.cell(own));
  for (std::size_t i = 0; names_.pieces && i < n; ++i)
    to.put(answers.cells[i].piece);
  for (std::size_t i = 0; names_.processes && i < n; ++i)
    to.put(answers.cells[i].process);
  for (int c = 0; moves_ && c < 3; ++c)
    for (const math::Vec3d& x : points.mesh_points)
      to.put(core::unsigned_zero(x[c]));
  for (int c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < n; ++i)
      to.put(answers.found(i) ? answers.parametric[i][c]
                              : std::numeric_limits<double>::quiet_NaN());
  for (std::size_t c = 0; c < width; ++c)
    for (std::size_t i = 0; i < n; ++i)
      to.put(answers.values[i * width + c]);
}

void ProbeNetcdf::finish() {
  if (table_)
    table_->flush();
  table_.reset();
}

} // namespace insitu::scene
