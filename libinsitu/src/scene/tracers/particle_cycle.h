#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "advect/lines/snapshots.h"
#include "scene/tracers/field_between.h"
#include "scene/tracers/tracer_action.h"
#include "scene/tracers/track_writer.h"

namespace insitu::scene {

/// The particles of a tracer after they moved.
struct MovedParticles {
  const TracerAction& tracer;
  const advect::Particles& particles;
  const TrackGeodesics& geodesics;
  std::span<const DueTime> times;     ///< of the tracer's own, that this cycle reaches
  const advect::Snapshots* snapshots; ///< the particles at those times; null without any
  StepInterval interval;
  CellNames names; ///< of the mesh's cells
  const parallel::World& world;
  /// The mesh has moved under them: the cell of a particle on a face may be any of those there.
  bool mesh_moved;
  /// The tracer's fields, as all processes have them; null: they are the mesh's.
  const std::vector<mesh::FieldView>* fields = nullptr;
};

/// What the writers see of a cycle of path- and streaklines. The rows that one asked for last are
/// kept: the next one, of another format, mostly asks for the same.
class ParticleCycle final : public TrackCycle {
public:
  /// mesh and step must outlive this.
  ParticleCycle(const MovedParticles& moved, const commit::CommittedMesh& mesh, const Step& step,
                bool due)
      : moved_(moved), mesh_(mesh), step_(step), due_(due) {}

  const Step& step() const override { return step_; }
  bool due() const override { return due_; }
  const advect::Particles& particles() const override { return moved_.particles; }
  std::int64_t seeded() const override { return particles().seeded(); }
  const TrackGeodesics& geodesics() const override { return moved_.geodesics; }
  bool has_times() const override { return moved_.tracer.has_times(); }
  std::span<const DueTime> times() const override { return moved_.times; }
  const advect::Snapshots& snapshots() const override { return *moved_.snapshots; }
  const TrackRows& rows_at(std::size_t k) override;
  const TrackRows& rows(const std::vector<std::size_t>& indices) override;
  /// Rows of these particles get the values that other processes have where the mesh has left the
  /// places of particles that ended here. Collective; throws parallel::AgreedError.
  void add_values_of_others(const std::vector<std::size_t>& indices, TrackRows& rows,
                            parallel::World& world) const;

private:
  TrackRows no_rows() const;
  std::vector<mesh::FieldView> fields() const;
  OwnCell named_cell(std::int64_t flat, const math::Vec3d& x) const;
  TrackRows make_rows_at(std::size_t k) const;
  TrackRows make_rows(const std::vector<std::size_t>& indices) const;
  std::vector<query::Location> places(const std::vector<std::size_t>& indices) const;
  template <class Put>
  void add_geodesics(TrackRows& out, Put&& put) const;

  MovedParticles moved_;
  const commit::CommittedMesh& mesh_;
  const Step& step_;
  bool due_;
  std::optional<std::vector<std::size_t>> known_;
  TrackRows rows_;
  std::optional<std::size_t> known_time_;
  TrackRows rows_at_;
};

} // namespace insitu::scene
