#pragma once

#include <memory>
#include <optional>

#include "output/files/csv.h"
#include "scene/expression/trigger.h"
#include "scene/parse/description.h"
#include "scene/probes/probe_netcdf.h"
#include "scene/probes/resolve_points.h"
#include "scene/run/action.h"
#include "scene/run/environment.h"
#include "scene/run/growing_table.h"
#include "scene/run/step.h"
#include "scene/tracers/vtp_series.h"

namespace insitu::scene {

/// Samples fields at fixed points whenever due. CSV: one table that grows, with the columns
/// cycle, time, point, [name,] [distance, depth,] cell, [piece,] r, s, t, fields; cell is -1 and
/// the values are empty outside. name stands where the points have names, distance along the path
/// and depth (or height, or z) of a curtain's, piece where the mesh has several; x, y, z after the
/// point and its name where it goes with the material. Where the scene
/// names no fields, those that the mesh has when the probe is due first are sampled.
class ProbeAction final : public Action {
public:
  ProbeAction(const Probe& probe, const Environment& environment);

  const char* kind() const override { return "probe"; }
  const std::string& name() const override { return probe_.name; }
  const Trigger& trigger() const override { return probe_.trigger; }
  const Name& mesh_name() const override { return probe_.mesh; }
  void execute(commit::CommittedMesh& mesh, const Step& step, bool due) override;
  void finish() override;
  void plan(const commit::CommittedMesh& mesh, Plan& plan) const override;
  std::string state_name() const override;
  void keep(core::Archive& archive) override;
  void take_up_cells() override { same_cells_ = true; }

private:
  ProbeAnswers sample(const commit::CommittedMesh& mesh, std::span<const mesh::FieldView> fields);
  void write(TableFormat format, const commit::CommittedMesh& mesh, const Step& step,
             const ProbeAnswers& answers);
  void write_table(const commit::CommittedMesh& mesh, const Step& step,
                   const ProbeAnswers& answers);
  void write_vtp(const commit::CommittedMesh& mesh, const Step& step, const ProbeAnswers& answers);
  void write_json(const commit::CommittedMesh& mesh, const Step& step, const ProbeAnswers& answers);

  bool moves() const { return probe_.attached == Attached::body; }
  void follow(commit::CommittedMesh& mesh);

  Probe probe_;
  Environment environment_;
  std::optional<ScenePoints> points_;
  // Of points that are attached to the material.
  std::vector<query::Location> places_;
  std::uint64_t topology_ = 0;
  bool same_cells_ = false; ///< as at the checkpoint of a restart
  std::unique_ptr<output::AppendTable> table_;
  std::vector<std::string> columns_; ///< of the table
  bool pieces_ = false;              ///< among them
  OnePieceNote one_piece_;
  VtpSeries series_;
  ProbeNetcdf netcdf_;
};

} // namespace insitu::scene
