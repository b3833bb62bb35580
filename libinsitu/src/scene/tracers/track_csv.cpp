#include "output/files/csv.h"
#include "scene/run/environment.h"
#include "scene/run/growing_table.h"
#include "scene/tracers/track_table.h"

namespace insitu::scene {

namespace {

/// `<name>.csv`: cycle, time, particle, x, y, z, cell, [piece,] [process,] ending, and the values.
class TrackCsv final : public TrackTable {
public:
  TrackCsv(const Tracer& tracer, const Environment& environment)
      : path_(environment.output + "/" + tracer.name + ".csv"), environment_(environment) {}

private:
  void open(const TrackRows& rows, std::int64_t) override {
    std::vector<std::string> columns{"cycle", "time", "particle", "x", "y", "z", "cell"};
    const CellNames& names = table_ ? names_ : rows.names;
    if (names.pieces)
      columns.push_back("piece");
    if (names.processes)
      columns.push_back("process");
    columns.push_back("ending");
    columns.insert(columns.end(), rows.columns.begin(), rows.columns.end());
    if (table_) {
      require_columns(*table_, columns_, columns);
      names_.require_for(path_, rows.names);
      one_piece_.say(!names_.pieces && !names_.global && rows.names.pieces, path_,
                     environment_.context.log);
      return;
    }
    table_ = std::make_unique<output::AppendTable>(
        path_, columns,
        rows.cycle == TrackRows::no_cycle ? std::nullopt : std::optional(rows.cycle));
    ++environment_.statistics.files;
    columns_ = std::move(columns);
    value_columns_ = rows.columns;
    names_ = rows.names;
  }

  void add(const TrackRows& rows) override {
    output::CsvRows& csv = table_->rows();
    const std::size_t width = value_columns_.size();
    for (std::size_t r = 0; r < rows.rows.size(); ++r) {
      const TrackRow& row = rows.rows[r];
      csv.cell(rows.cycle).cell(row.time).cell(row.particle);
      csv.cell(row.position.x).cell(row.position.y).cell(row.position.z);
      csv.cell(names_.cell(row.cell));
      if (names_.pieces)
        csv.cell(int(row.cell.piece));
      if (names_.processes)
        csv.cell(int(row.cell.process));
      csv.cell(advect::ending_name(row.ending));
      for (std::size_t c = 0; c < width; ++c)
        csv.cell(rows.values[r * width + c]);
      csv.end_row();
    }
  }

  bool is_open() const override { return table_ != nullptr; }
  void flush() override { flush_table(*table_); }
  void close() override { table_.reset(); }
  std::int64_t size() const override { return table_->size(); }
  void shorten(std::int64_t size) override { table_->shorten(size); }
  std::int64_t end() const override { return table_->end(); }
  void cut_back(std::int64_t end) override { table_->cut_back(end); }
  const std::vector<std::string>& value_columns() const override { return value_columns_; }
  const CellNames& cell_names() const override { return names_; }

  std::string path_;
  Environment environment_;
  std::unique_ptr<output::AppendTable> table_;
  std::vector<std::string> columns_, value_columns_;
  CellNames names_;
  OnePieceNote one_piece_;
};

} // namespace

std::unique_ptr<TrackWriter> make_track_csv(const Tracer& tracer, const Environment& environment) {
  return std::make_unique<TrackCsv>(tracer, environment);
}

} // namespace insitu::scene
