#pragma once

#include <memory>
#include <string>
#include <vector>

#include "output/files/csv.h"
#include "scene/parse/description.h"
#include "scene/probes/probe_answers.h"
#include "scene/probes/probe_netcdf.h"
#include "scene/probes/resolve_points.h"
#include "scene/run/environment.h"
#include "scene/run/failures.h"
#include "scene/run/growing_table.h"
#include "scene/run/step.h"
#include "scene/tracers/vtp_series.h"

namespace insitu::scene {

/// The files of a probe, which the root writes. CSV: one table that grows, with the columns
/// cycle, time, point, [name,] [x, y, z,] [distance, depth,] cell, [piece,] [process,] r, s, t,
/// fields; cell is -1 and the values are empty outside. name stands where the points have names,
/// x, y, z where they go with the material, distance along the path and depth (or height, or z) of
/// a curtain's, piece and process as CellNames says.
class ProbeTables {
public:
  ProbeTables(const Probe& probe, const Environment& environment);

  /// Writes a due cycle's rows to all formats. Throws core::Error with all that failed.
  void write(const commit::CommittedMesh& mesh, const Step& step, const ScenePoints& points,
             const ProbeAnswers& answers, const CellNames& names);
  void finish();

private:
  struct Rows;

  void count(const Rows& rows);
  void write_csv(const Rows& rows);
  void add_rows(const Rows& rows);
  void write_vtp(const Rows& rows);
  void write_json(const Rows& rows);

  std::string name_;
  std::vector<TableFormat> formats_;
  bool moves_;
  Environment environment_;
  std::unique_ptr<output::AppendTable> table_;
  RowsOfStep rows_;                  ///< in it
  std::vector<std::string> columns_; ///< of it
  CellNames names_;                  ///< in it
  OnePieceNote one_piece_;
  VtpSeries series_;
  ProbeNetcdf netcdf_;
  Formats written_;
  StepNote note_;
  bool counted_ = false; ///< the step's rows, in the statistics
};

} // namespace insitu::scene
