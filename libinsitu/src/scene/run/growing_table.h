#pragma once

#include <string>
#include <vector>

#include "core/log.h"
#include "mesh/view.h"
#include "output/files/csv.h"
#include "output/netcdf/netcdf_table.h"
#include "scene/run/step.h"

/// Tables to which probes, tracers and frames add rows from cycle to cycle.
namespace insitu::scene {

/// Returns the names of the components of a field: "velocity_x" and so on.
std::vector<std::string> component_names(const mesh::FieldView& field);

/// Logs once, for a table that grows and was opened for a mesh of one piece, that the mesh has
/// several pieces by now, so that the table counts cells through them.
class OnePieceNote {
public:
  void say(bool several, const std::string& path, const core::Log& log);

private:
  bool said_ = false;
};

/// Throws INSITU_ERROR_FIELD if a table that is open cannot take these columns any more, since the
/// fields changed during the run.
void require_columns(const output::AppendTable& table, const std::vector<std::string>& open,
                     const std::vector<std::string>& now);

/// Writes the rows of a table. Rows that cannot be written wait for the next flush, up to a limit:
/// a disk that stays full must not fill the memory too.
void flush_table(output::AppendTable& table);
void flush_table(output::NetcdfTable& table);

/// Where the rows of a step begin in a table.
class RowsOfStep {
public:
  /// Adds a step's rows by add(), and writes them. What the step had there before, if it comes
  /// again, is taken back first, and so is all that add() did if it fails.
  template <class Table, class Add>
  void write(Table& table, const Step& step, Add&& add) {
    if (note_.again(step))
      table.cut_back(begin_);
    begin_ = table.end();
    try {
      add();
    } catch (...) {
      table.cut_back(begin_);
      throw;
    }
    flush_table(table);
  }

private:
  StepNote note_;
  std::int64_t begin_ = 0; ///< AppendTable::end() or NetcdfTable::end() then
};

} // namespace insitu::scene
