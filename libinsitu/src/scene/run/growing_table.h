#pragma once

#include <string>
#include <vector>

#include "core/log.h"
#include "mesh/view.h"
#include "output/files/csv.h"
#include "output/netcdf/netcdf_table.h"

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

} // namespace insitu::scene
