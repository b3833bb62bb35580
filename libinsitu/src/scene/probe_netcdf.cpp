#include "scene/probe_netcdf.h"

#include <algorithm>
#include <limits>

#include "core/status.h"
#include "scene/cf.h"

namespace insitu::scene {

ProbeNetcdf::ProbeNetcdf(const std::string& name, const Environment& environment)
    : name_(name), path_(environment.output + "/" + name + ".nc"), environment_(environment) {}

ProbeNetcdf::~ProbeNetcdf() = default;

output::NetcdfLayout ProbeNetcdf::layout(const query::CommittedMesh& mesh,
                                         const ScenePoints& points,
                                         const ProbeAnswers& answers) const {
  using output::NetcdfType;
  using output::NetcdfVariable;
  const std::size_t n = points.mesh_points.size();
  output::NetcdfLayout out;
  out.record_dimension = "time";
  out.dimensions = {{"station", std::int64_t(n)}};
  out.attributes = cf_attributes("timeSeries", name_);
  const auto of_station = [](NetcdfVariable v) {
    v.per_record = false;
    v.dimensions = {"station"};
    return v;
  };
  const auto of_both = [](NetcdfVariable v) {
    v.dimensions = {"station"};
    return v;
  };
  out.variables = {cf_cycle(), cf_time(), of_both(cf_cell())};
  if (pieces_)
    out.variables.push_back(of_both(cf_piece()));

  auto position = cf_position(mesh.frame);
  const auto mapping = cf_grid_mapping(mesh.frame);
  for (int axis = 0; axis < 3; ++axis) {
    NetcdfVariable v = of_station(position[std::size_t(axis)]);
    for (const math::Vec3d& p : points.mesh_points)
      v.doubles.push_back(p[axis]);
    out.variables.push_back(std::move(v));
  }
  NetcdfVariable station;
  station.name = "station";
  station.type = NetcdfType::int64;
  station.attributes = {{"long_name", std::string("point of the probe")},
                        {"cf_role", std::string("timeseries_id")}};
  for (std::size_t i = 0; i < n; ++i)
    station.integers.push_back(std::int64_t(i));
  out.variables.push_back(of_station(std::move(station)));
  std::string coordinates = position[0].name + " " + position[1].name + " " + position[2].name;
  if (!points.names.empty()) {
    NetcdfVariable names;
    names.name = "station_name";
    names.type = NetcdfType::text;
    names.attributes = {{"long_name", std::string("name of the point")}};
    std::size_t longest = 1;
    for (const std::string& name : points.names)
      longest = std::max(longest, name.size());
    out.dimensions.emplace_back("name_length", std::int64_t(longest));
    for (std::string name : points.names) {
      name.resize(longest, '\0');
      names.text += name;
    }
    names = of_station(std::move(names));
    names.dimensions.push_back("name_length");
    out.variables.push_back(std::move(names));
    coordinates += " station_name";
  }
  if (mapping)
    out.variables.push_back(*mapping);
  for (const char* axis : {"r", "s", "t"}) {
    NetcdfVariable v = of_both(cf_values(out, axis, {}, std::nullopt));
    v.attributes.front() = {"long_name", std::string("parametric coordinate in the cell")};
    out.variables.push_back(std::move(v));
  }
  for (const std::string& column : answers.columns)
    out.variables.push_back(of_both(cf_values(out, column, coordinates, mapping)));
  return out;
}

void ProbeNetcdf::write(const query::CommittedMesh& mesh, const Step& step,
                        const ScenePoints& points, const ProbeAnswers& answers) {
  const mesh::MeshView& view = mesh.mesh().own_view();
  const bool pieces = view.piece_count > 1;
  if (!table_) {
    columns_ = answers.columns;
    pieces_ = pieces;
    table_ =
        std::make_unique<output::NetcdfTable>(path_, layout(mesh, points, answers), step.cycle);
    ++environment_.statistics.files;
  } else if (pieces != pieces_ || answers.columns != columns_) {
    throw core::Error(INSITU_ERROR_FIELD,
                      "'" + path_ +
                          "' was opened for other fields or pieces than this cycle's: they "
                          "changed during the run");
  }
  output::NetcdfRecords& to = table_->rows();
  const std::size_t n = answers.locations.size(), width = answers.columns.size();
  to.put(step.cycle).put(step.time);
  std::vector<OwnCell> cells;
  for (const query::Location& at : answers.locations)
    cells.push_back(own_cell(view, at.cell));
  for (const OwnCell& own : cells)
    to.put(own.cell);
  for (std::size_t i = 0; pieces && i < n; ++i)
    to.put(cells[i].piece);
  for (int c = 0; c < 3; ++c)
    for (const query::Location& at : answers.locations)
      to.put(at ? at.parametric[c] : std::numeric_limits<double>::quiet_NaN());
  for (std::size_t c = 0; c < width; ++c)
    for (std::size_t i = 0; i < n; ++i)
      to.put(answers.values[i * width + c]);
  flush_table(*table_);
}

void ProbeNetcdf::finish() {
  if (table_)
    table_->flush();
  table_.reset();
}

} // namespace insitu::scene
