#pragma once

#include <optional>

#include "scene/expression/trigger.h"
#include "scene/parse/description.h"
#include "scene/probes/attached_points.h"
#include "scene/probes/probe_answers.h"
#include "scene/probes/probe_tables.h"
#include "scene/probes/resolve_points.h"
#include "scene/run/action.h"
#include "scene/run/environment.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// What a probe answered when it was due last, for those who act on it: the same on all processes.
struct KeptAnswers {
  std::int64_t cycle = 0;
  double time = 0.0;
  std::vector<std::string> columns;
  std::vector<const char*> column_names; ///< of these, for C
  std::vector<math::Vec3d> points;       ///< in the mesh's coordinates
  std::vector<std::uint8_t> inside;      ///< [point] whether a cell answered
  std::vector<double> values;            ///< [point][column], NaN where no cell answered
};

/// Samples fields at points whenever due, of all processes: the root writes what all of them answer
/// (ProbeTables). Where the scene names no fields, those that the mesh has when the probe is due
/// first are sampled.
class ProbeAction final : public Action {
public:
  ProbeAction(const Probe& probe, const Environment& environment);

  const char* kind() const override { return "probe"; }
  const std::string& name() const override { return probe_.name; }
  const Trigger& trigger() const override { return probe_.trigger; }
  const Name& mesh_name() const override { return probe_.mesh; }
  void execute(commit::CommittedMesh& mesh, const Step& step, bool due) override;
  bool serves_held_steps() const override { return !moves(); }
  void finish() override { tables_.finish(); }
  void plan(const commit::CommittedMesh& mesh, MeshList meshes, Plan& plan) const override;
  std::string state_name() const override;
  void meet_checkpoint(const commit::CommittedMesh* mesh) override;
  void keep(core::Archive& archive) override;
  void take_up_cells(const std::shared_ptr<const KeptCells>& cells) override {
    attached_.take_up_cells(cells);
  }

  /// From the next execute on all processes keep what the probe answers, or none does any more.
  void keep_answers(bool keep);
  /// Returns what the probe answered last; an empty optional means that nothing is kept (yet).
  const std::optional<KeptAnswers>& answers() const { return answers_; }

private:
  bool moves() const { return probe_.attached == Attached::body; }
  void resolve(const commit::CommittedMesh& mesh);
  bool name_fields(const commit::CommittedMesh& mesh);
  void share(const ProbeAnswers& answers, const Step& step);
  void write(const commit::CommittedMesh& mesh, const Step& step, const ProbeAnswers& answers,
             const CellNames& names);

  Probe probe_;
  Environment environment_;
  std::optional<ScenePoints> points_;
  AttachedPoints attached_;   ///< if they move
  StepNote note_;
  bool followed_ = false;     ///< to that step, by them
  AttachedPoints::Kept kept_; ///< at the root, while a checkpoint is written
  ProbeTables tables_;
  bool keeps_answers_ = false;
  std::optional<KeptAnswers> answers_;
};

} // namespace insitu::scene
