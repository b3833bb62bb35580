#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/timer.h"
#include "scene/run/environment.h"
#include "scene/run/failures.h"
#include "scene/run/output_times.h"
#include "scene/run/step.h"
#include "scene/tracers/field_between.h"
#include "scene/tracers/kept_particles.h"
#include "scene/tracers/particle_cycle.h"
#include "scene/tracers/release.h"
#include "scene/tracers/tracer_action.h"
#include "scene/tracers/tracer_cells.h"
#include "scene/tracers/track_writer.h"

namespace insitu::scene {

/// Pathlines and streaklines: particles that live from cycle to cycle. How they move is here; how
/// they are written is the writers'.
class ParticleTracer final : public TracerAction {
public:
  ParticleTracer(const Tracer& tracer, const Environment& environment)
      : TracerAction(tracer, environment), particles_(settings(), environment.context.memory),
        own_(tracer.direction == TracerDirection::backward), clock_(tracer.release, own_),
        geodesics_(tracer.geodesics, environment.context.memory),
        output_clock_(tracer.times, own_) {
    for (const TableFormat format : tracer_.output)
      writers_.push_back(make_track_writer(format, tracer_, environment_));
  }

  /// Of all processes.
  advect::Counts counts() const override { return across() ? counts_ : particles_.counts(); }
  std::optional<advect::Counts> particles_here() const override { return particles_.counts(); }
  std::vector<mesh::KeptField> needs_earlier() const override;

  bool serves_held_steps() const override { return false; }
  bool goes_on_to_other_cells() const override { return tracer_.attached != Attached::body; }

  void execute(commit::CommittedMesh& mesh, const Step& step, bool due) override;

  void meet_checkpoint(const commit::CommittedMesh* mesh) override;
  void keep(core::Archive& archive) override;
  void keep_at_root(core::Archive& archive) override;
  void take_up_cells(const std::shared_ptr<const KeptCells>& cells) override {
    kept_cells_ = cells;
    same_cells_ = cells->stand();
  }

  /// The particles of all processes go to the root, which will write how they ended.
  void meet_end() override;
  /// The solver's arrays may be gone: what needs no field is written.
  void finish() override;

private:
  advect::TracerSettings settings() const;

  /// Whether the mesh's cells are those of the step that the particles are at.
  bool knows_cells(const commit::CommittedMesh& mesh) const {
    return topology_ == mesh.topology_version() || same_cells_;
  }

  bool may_release(const commit::CommittedMesh& mesh, const Step& step) const;

  /// How many steps before this one may serve, if they are kept: if the last is the step that the
  /// particles are at, on the same cells.
  int earlier_steps(const commit::CommittedMesh& mesh, const Step& step) const {
    const bool known = knows_cells(mesh) && !step.first && settled_ == step.earlier_time;
    return known ? advect::steps_of(tracer_.time_interpolation) - 1 : 0;
  }

  /// The step that the particles are at, if its cells are others; or null.
  const commit::EarlierMesh* other_cells(const commit::CommittedMesh& mesh, const Step& step) const;

  /// Between which steps the particles move now.
  void begin_interval(const commit::CommittedMesh& mesh, const Step& step);
  advect::Snapshots* snapshots() { return at_times_ ? &*at_times_ : nullptr; }

  /// Says when the velocity is interpolated through fewer steps than were asked for, and when
  /// through all of them again.
  void note_steps(const Step& step, const advect::Advance& advance);

  /// Begins a step; returns whether it comes again, and the particles are where they are to be.
  bool goes_on(const Step& step) {
    if (!note_.again(step))
      released_ = moved_ = followed_ = false;
    return moved_;
  }

  /// Throws if the particles cannot go on to this step's time.
  void check_geodesics(const commit::CommittedMesh& mesh) const;
  void check_time(const Step& step) const;
  /// Adds the particles that begin between the last step and this one.
  void release(const commit::CommittedMesh& mesh, const Step& step);

  void advance(commit::CommittedMesh& mesh, const mesh::FieldView& velocity, const Step& step);

  /// The particles of a restart go to their cells. Collective.
  void bring_home(const commit::CommittedMesh& mesh);

  void write(const commit::CommittedMesh& mesh, const Step& step, bool due);
  bool keeps_ended() const;
  void write_step(const commit::CommittedMesh& mesh, const Step& step, bool due,
                  const core::Timer& timer);

  // On several processes (particle_tracer_across.cpp), all of these are collective.
  bool across() const { return environment_.world.size() > 1; }
  void execute_across(commit::CommittedMesh& mesh, const Step& step, bool due);
  int agree_on_steps(const commit::CommittedMesh& mesh, const Step& step);
  void release_across(const commit::CommittedMesh& mesh, const Step& step,
                      const advect::Across& across);
  void look_at_cells_across(commit::CommittedMesh& mesh);
  void advance_across(commit::CommittedMesh& mesh, const mesh::FieldView& velocity,
                      const Step& step, const advect::Across& across);
  void gather_cells_before(const commit::CommittedMesh& mesh, const Step& step);
  void follow_across(const commit::CommittedMesh& mesh, const Step& step,
                     const advect::Across& across);
  void write_across(const commit::CommittedMesh& mesh, const Step& step, bool due);

  advect::Tracer particles_;
  TracerCells cells_{environment_.context.memory};
  OwnTime own_;
  ReleaseClock clock_;
  TrackGeodesics geodesics_;
  OutputClock output_clock_;
  // Of one execution.
  std::vector<DueTime> due_times_; ///< of the tracer's own times
  std::optional<advect::Snapshots> at_times_;
  StepInterval interval_;
  // How far it came, so that it goes on there where the step comes again.
  StepNote note_;
  bool released_ = false, moved_ = false;
  bool followed_ = false;                 ///< by the geodesics, on several processes
  Formats written_;                       ///< by writer
  std::vector<mesh::FieldView> recorded_; ///< fields, on several processes
  CellNames names_;
  std::vector<std::unique_ptr<TrackWriter>> writers_;
  bool seeded_ = false;
  bool mesh_moved_ = false; ///< under the particles, ever
  double settled_ = 0.0;    ///< the time that the particles are at
  int served_steps_ = 0;    ///< through which the velocity was interpolated last
  std::uint64_t topology_ = 0, own_topology_ = 0; ///< the mesh's versions then
  bool same_cells_ = false; ///< as at the checkpoint of a restart
  struct {
    std::int64_t cycle = 0;
    double time = 0.0;
  } last_; ///< the last execution
  // Of a checkpoint.
  std::optional<KeptParticles> kept_;           ///< at the root, while it is written
  bool is_restored_ = false;                    ///< the particles are to be dealt to their cells
  std::vector<mesh::CellName> cell_names_;      ///< of theirs then, at the root
  std::shared_ptr<const KeptCells> kept_cells_; ///< null: the mesh was not in the checkpoint
  // Of all processes, where there are several.
  advect::Counts counts_;
  std::unique_ptr<commit::EarlierMesh> cells_before_; ///< in this execution
  bool had_cells_ = false;                            ///< this process, at the last execution
  std::optional<advect::Particles> all_;              ///< at the end, at the root
};

} // namespace insitu::scene
