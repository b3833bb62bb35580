#pragma once

#include <memory>
#include <optional>

#include "advect/lines/streamlines.h"
#include "advect/pathlines.h"
#include "scene/expression/trigger.h"
#include "scene/parse/description.h"
#include "scene/run/action.h"
#include "scene/run/environment.h"

namespace insitu::scene {

/// A tracer of a scene. Path- and streaklines move at every cycle and write when due; streamlines
/// are traced when due.
///
/// Files of path- and streaklines: scene/tracers/track_writer.h. CSV of streamlines: a table a
/// cycle, with line, vertex, s, x, y, z, cell, [piece,] ending, fields. piece stands where the mesh
/// has several.
class TracerAction : public Action {
public:
  TracerAction(const Tracer& tracer, const Environment& environment);

  const char* kind() const override { return "tracer"; }
  const std::string& name() const override { return tracer_.name; }
  const Trigger& trigger() const override { return tracer_.trigger; }
  const Name& mesh_name() const override { return tracer_.mesh; }

  void plan(const commit::CommittedMesh& mesh, MeshList meshes, Plan& plan) const override;
  std::string state_name() const final;

  commit::PeriodicAxes periodic_axes() const final;
  std::optional<advect::Counts> particles() const final { return counts(); }
  virtual advect::Counts counts() const = 0;

  bool has_times() const { return tracer_.times.interval || !tracer_.times.at.empty(); }
  insitu_accuracy accuracy() const { return tracer_.accuracy; }
  const core::Threads& threads() const { return environment_.context.threads; }
  std::vector<mesh::FieldView> fields(const commit::CommittedMesh& mesh) const;
  std::vector<std::string> field_columns(std::span<const mesh::FieldView> fields) const;
  /// The fields' values at points whose cells are known (or -1), [point][column], NaN outside.
  std::vector<double> sample(const commit::CommittedMesh& mesh,
                             std::span<const mesh::FieldView> fields,
                             std::span<const math::Vec3d> points,
                             std::span<const std::int64_t> cells) const;
  /// The same at places, [place][column], NaN outside.
  std::vector<double> values_at(const commit::CommittedMesh& mesh,
                                std::span<const mesh::FieldView> fields,
                                std::span<const query::Location> places) const;

protected:
  advect::IntegratorSettings integrator() const;
  const std::vector<math::Vec3d>& seeds(const commit::CommittedMesh& mesh);
  /// The same of several processes, for which the root reads a file. Collective.
  const std::vector<math::Vec3d>& seeds_of_all(const commit::CommittedMesh& mesh);

  Tracer tracer_;
  Environment environment_;

private:
  void plan_neighbours(const commit::CommittedMesh& mesh, Plan& plan) const;

  std::optional<std::vector<math::Vec3d>> seeds_;
};

std::unique_ptr<TracerAction> make_tracer_action(const Tracer& tracer,
                                                 const Environment& environment);
std::unique_ptr<TracerAction> make_stream_tracer(const Tracer& tracer,
                                                 const Environment& environment);

} // namespace insitu::scene
