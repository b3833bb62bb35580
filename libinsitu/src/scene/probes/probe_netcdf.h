#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "output/netcdf/netcdf_table.h"
#include "scene/probes/probe_answers.h"
#include "scene/probes/resolve_points.h"
#include "scene/run/environment.h"
#include "scene/run/growing_table.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// `<name>.nc`: a probe as CF time series, a record for each due cycle: the multidimensional
/// array of stations and times. Of a curtain the stations are profiles: one more dimension, of its
/// levels, with their coordinate; places and distances along the path are those it was given in.
/// Points that move are trajectories: their places are in each record. cell is -1 and the values
/// are NaN outside.
class ProbeNetcdf {
public:
  ProbeNetcdf(const std::string& name, const Environment& environment, bool moves);
  ~ProbeNetcdf();
  void write(const commit::CommittedMesh& mesh, const Step& step, const ScenePoints& points,
             const ProbeAnswers& answers, const CellNames& names);
  void finish();

private:
  void add_record(const Step& step, const ScenePoints& points, const ProbeAnswers& answers);
  output::NetcdfLayout layout(const commit::CommittedMesh& mesh, const ScenePoints& points,
                              const ProbeAnswers& answers) const;

  std::string name_, path_;
  Environment environment_;
  std::unique_ptr<output::NetcdfTable> table_;
  RowsOfStep rows_; ///< in it
  std::vector<std::string> columns_;
  bool moves_ = false;
  CellNames names_; ///< in the table
  OnePieceNote one_piece_;
};

} // namespace insitu::scene
