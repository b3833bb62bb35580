#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "advect/lines/snapshots.h"
#include "advect/particles.h"
#include "parallel/world.h"
#include "scene/tracers/particle_cycle.h"
#include "scene/tracers/track_writer.h"

namespace insitu::scene {

/// The particles of all processes at the root, as the writers there see a cycle: in the order of
/// their ids, as in one process. On other processes it has none. Rows are made where the particles
/// are, or where they were at a tracer's own time.
class GatheredCycle final : public TrackCycle {
public:
  struct Geodesics {
    TrackGeodesics& of_all;
    bool are_there; ///< they have followed to this step
  };
  /// Collective; throws parallel::AgreedError. here: this process's. all: those alive, too; false:
  /// only those that ended and are still among the particles. geodesics: of all particles, at the
  /// root; follows them, if it has columns, which takes all.
  GatheredCycle(ParticleCycle& here, bool all, const Geodesics& geodesics, parallel::World& world,
                const core::Threads& threads, core::Memory& memory);

  const Step& step() const override { return here_.step(); }
  bool due() const override { return here_.due(); }
  const advect::Particles& particles() const override { return particles_; }
  std::int64_t seeded() const override { return here_.seeded(); }
  const TrackGeodesics& geodesics() const override { return here_.geodesics(); }
  bool has_times() const override { return here_.has_times(); }
  std::span<const DueTime> times() const override { return here_.times(); }
  const advect::Snapshots& snapshots() const override { return *snapshots_; }
  const TrackRows& rows_at(std::size_t k) override { return at_times_[k]; }
  const TrackRows& rows(const std::vector<std::size_t>& indices) override;

private:
  struct Parts;
  void merge(Parts& parts);
  void merge_times(Parts& parts);
  void follow(const Geodesics& geodesics, const core::Threads& threads);

  ParticleCycle& here_;
  core::Memory& memory_;
  advect::Particles particles_;
  TrackRows all_;                   ///< of the particles, in their order
  std::vector<TrackRows> at_times_; ///< [time]
  std::optional<advect::Snapshots> snapshots_;
  TrackRows asked_;
};

/// The particles of all processes that have not been dropped, at the root, without rows, in the
/// order of their ids; none on other processes. Collective.
void gather_particles(const advect::Particles& here, parallel::World& world,
                      advect::Particles& all);

} // namespace insitu::scene
