#include "core/status.h"
#include "output/netcdf/netcdf_table.h"
#include "scene/earth/cf.h"
#include "scene/run/environment.h"
#include "scene/run/growing_table.h"
#include "scene/tracers/track_table.h"

namespace insitu::scene {

namespace {

/// `<name>.nc`: the rows of the CSV table as CF trajectories, an indexed ragged array. The
/// instances are the particles' ids from 0 up to the dimension's length, which doubles when more
/// are released; those beyond the particles have no observation.
class TrackNetcdf final : public TrackTable {
public:
  TrackNetcdf(const Tracer& tracer, const Environment& environment)
      : name_(tracer.name), path_(environment.output + "/" + tracer.name + ".nc"),
        environment_(environment), geodesics_(tracer.geodesics) {}

private:
  void open(const TrackRows& rows, std::int64_t seeded) override {
    if (table_) {
      if (rows.columns != columns_)
        throw core::Error(INSITU_ERROR_FIELD,
                          "'" + path_ +
                              "' was opened for other fields than this cycle's: they changed "
                              "during the run");
      names_.require_for(path_, rows.names);
      one_piece_.say(!names_.pieces && !names_.global && rows.names.pieces, path_,
                     environment_.context.log);
      if (seeded > instances_) {
        const std::int64_t more = enough(instances_, seeded);
        table_->change(layout(rows, more));
        instances_ = more;
      }
      return;
    }
    const auto from = rows.cycle == TrackRows::no_cycle ? std::nullopt : std::optional(rows.cycle);
    const auto old = output::summary_before(path_, from);
    names_ = rows.names;
    const std::int64_t instances =
        enough(old ? old->dimension("trajectory") : seeded, std::max<std::int64_t>(seeded, 1));
    table_ = std::make_unique<output::NetcdfTable>(path_, layout(rows, instances), from);
    ++environment_.statistics.files;
    columns_ = rows.columns;
    instances_ = instances;
  }

  static std::int64_t enough(std::int64_t instances, std::int64_t seeded) {
    instances = std::max<std::int64_t>(instances, 1);
    while (instances < seeded)
      instances *= 2;
    return instances;
  }

  output::NetcdfLayout layout(const TrackRows& rows, std::int64_t instances) const {
    output::NetcdfLayout out;
    out.record_dimension = "obs";
    out.dimensions = {{"trajectory", instances}};
    out.attributes = cf_attributes("trajectory", name_);
    output::NetcdfVariable ids;
    ids.name = "trajectory";
    ids.type = output::NetcdfType::int64;
    ids.per_record = false;
    ids.dimensions = {"trajectory"};
    ids.attributes = {{"long_name", std::string("particle")},
                      {"cf_role", std::string("trajectory_id")}};
    for (std::int64_t i = 0; i < instances; ++i)
      ids.integers.push_back(i);
    output::NetcdfVariable index;
    index.name = "particle";
    index.type = output::NetcdfType::int64;
    index.attributes = {{"long_name", std::string("which trajectory this observation is of")},
                        {"instance_dimension", std::string("trajectory")}};
    const auto position = cf_position(rows.frame);
    const auto mapping = cf_grid_mapping(rows.frame);
    out.variables = {cf_cycle(), cf_time(), index};
    out.variables.insert(out.variables.end(), position.begin(), position.end());
    out.variables.push_back(cf_cell());
    if (names_.pieces)
      out.variables.push_back(cf_piece());
    if (names_.processes)
      out.variables.push_back(cf_process());
    out.variables.push_back(cf_ending());
    out.variables.push_back(std::move(ids));
    if (mapping)
      out.variables.push_back(*mapping);
    const std::string coordinates =
        "time " + position[0].name + " " + position[1].name + " " + position[2].name;
    const std::size_t fields = rows.columns.size() - geodesics_.size();
    for (std::size_t c = 0; c < rows.columns.size(); ++c) {
      output::NetcdfVariable v = cf_values(out, rows.columns[c], coordinates, mapping);
      if (c >= fields)
        cf_geodesic(geodesics_[c - fields], v);
      out.variables.push_back(std::move(v));
    }
    return out;
  }

  void add(const TrackRows& rows) override {
    output::NetcdfRecords& to = table_->rows();
    const std::size_t width = columns_.size();
    for (std::size_t r = 0; r < rows.rows.size(); ++r) {
      const TrackRow& row = rows.rows[r];
      to.put(rows.cycle).put(row.time).put(row.particle);
      to.put(row.position.x).put(row.position.y).put(row.position.z);
      to.put(names_.cell(row.cell));
      if (names_.pieces)
        to.put(row.cell.piece);
      if (names_.processes)
        to.put(row.cell.process);
      to.put(std::int8_t(row.ending)).put(std::span(rows.values).subspan(r * width, width));
    }
  }

  bool is_open() const override { return table_ != nullptr; }
  void flush() override { flush_table(*table_); }
  void close() override { table_.reset(); }
  std::int64_t size() const override { return table_->records(); }
  void shorten(std::int64_t size) override { table_->shorten(size); }
  std::int64_t end() const override { return table_->end(); }
  void cut_back(std::int64_t end) override { table_->cut_back(end); }
  const std::vector<std::string>& value_columns() const override { return columns_; }
  const CellNames& cell_names() const override { return names_; }

  std::string name_, path_;
  Environment environment_;
  std::unique_ptr<output::NetcdfTable> table_;
  std::vector<TrackGeodesic> geodesics_;
  std::vector<std::string> columns_;
  CellNames names_;
  OnePieceNote one_piece_;
  std::int64_t instances_ = 0;
};

} // namespace

std::unique_ptr<TrackWriter> make_track_netcdf(const Tracer& tracer,
                                               const Environment& environment) {
  return std::make_unique<TrackNetcdf>(tracer, environment);
}

} // namespace insitu::scene
