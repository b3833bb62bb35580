#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <unordered_map>
#include <vector>

#include "advect/across/cell_boxes.h"
#include "advect/across/traveller.h"
#include "advect/lines/snapshots.h"
#include "advect/particles.h"
#include "core/parallel.h"
#include "parallel/world.h"
#include "query/sampler.h"

namespace insitu::advect {

/// The processes over which a tracer's mesh is spread.
struct Across {
  parallel::World& world;
  const Homes& homes; ///< of the cells of the sampler's mesh
};

/// Adds particles at points that all processes have: each keeps those that its cells own, and the
/// root those that no process has. Collective; throws parallel::AgreedError.
void seed_across(Particles& particles, std::span<const math::Vec3d> points, double time,
                 const query::Sampler& sampler, insitu_accuracy accuracy, const Across& across);

/// Living particles, but for fresh ones, go to the process that owns the cell that holds their
/// place, if there is one. Collective; throws parallel::AgreedError.
void bring_to_cells(Particles& particles, const query::Sampler& sampler, insitu_accuracy accuracy,
                    const Across& across, const core::Threads& threads);

/// The sum of what all processes have counted. Collective.
Counts counts_of_all(parallel::World& world, const Counts& here);
/// Throws Error(INSITU_ERROR_INTERNAL) unless all that was seeded is there.
void check_counts(const Particles& here, const Counts& all);

/// Takes the particles of all processes through one interval: each process moves those that it has
/// until their cells are others' or a step asks for a place elsewhere; then they change process,
/// and questions are answered; until an exact sum says that nobody moves or waits. Collective, on
/// the thread that called the library, but for what says otherwise.
class Rounds {
public:
  /// The arguments must outlive the object. sampler: without an outlook, among images.
  Rounds(const Across& across, const query::Sampler& sampler, insitu_accuracy accuracy,
         OtherCells& others, Particles& particles, Snapshots* snapshots);

  /// carry(particles) moves these, by their places among the particles, as far as that goes here;
  /// it tells of each that is not at its end by moves() or waits(). Not collective.
  /// velocity(x, t, v, cell): here, where a cell of this process holds x.
  using Evaluate = core::FunctionRef<Sampled(const math::Vec3d&, double, math::Vec3d&)>;
  void run(core::FunctionRef<void(std::span<const std::size_t>)> carry, Evaluate velocity);
  /// At the end, particles that are alive or in `left` go to the process that owns their cell;
  /// `left` is then that of the particles that are here.
  void bring_home(std::vector<LeftAt>& left);

  // For carry(), from any thread.
  /// How a particle goes on.
  OnTheWay way_of(std::size_t particle) const;
  /// What is known for its next step of places elsewhere.
  std::span<const FarValue> far_of(std::size_t particle) const;
  /// The particle's cell is another process's.
  void moves(std::size_t particle, const OnTheWay& way);
  /// Its next step needs a place that another process may hold.
  void waits(std::size_t particle, const OnTheWay& way, const query::Elsewhere& at);

  /// The particle ended its way in a cell elsewhere (Journey::far_cell).
  void ends_far(std::size_t particle, std::int64_t cell);

  /// So often particles changed process, and asked for places, of this process; its rounds, and the
  /// bytes that it sent.
  std::int64_t hops() const { return hops_; }
  std::int64_t questions() const { return questions_; }
  std::int64_t rounds() const { return rounds_; }
  std::int64_t bytes() const { return bytes_; }

private:
  struct Moving {
    std::size_t particle;
    int to;
    OnTheWay way;
  };
  struct Waiting {
    std::size_t particle;
    OnTheWay way;
    query::Elsewhere at;
    int holder = -1;
    bool knows_cell = false;
    FarValue value = {};
  };
  std::int64_t sum(std::int64_t mine) const;
  std::vector<parallel::Parcel> exchange(std::span<const parallel::Parcel> parcels);
  void send(std::vector<LeftAt>* left);
  void receive(std::span<const parallel::Parcel> parcels, std::vector<LeftAt>* left);
  void ask(Evaluate velocity);
  std::vector<Answer> answers_to(std::span<const Question> questions, Evaluate velocity) const;
  void go_on(const Waiting& waiting);
  CellName name_for(std::size_t particle, std::int64_t cell) const;

  parallel::World& world_;
  const Homes& homes_;
  const query::Sampler sampler_;
  insitu_accuracy accuracy_;
  OtherCells& others_;
  Particles& particles_;
  Snapshots* snapshots_;
  std::mutex mutex_;
  std::vector<Moving> moving_;
  std::vector<Waiting> waiting_;
  std::unordered_map<std::size_t, OnTheWay> ways_; ///< of particles that are under way
  std::unordered_map<std::size_t, std::vector<FarValue>> far_;
  std::unordered_map<std::size_t, CellName> ends_far_;
  std::vector<std::size_t> todo_;
  std::int64_t hops_ = 0, questions_ = 0, rounds_ = 0, bytes_ = 0;
};

} // namespace insitu::advect
