#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "advect/across/far_cells.h"
#include "advect/across/traveller.h"
#include "advect/lines/snapshots.h"
#include "advect/particles.h"
#include "core/parallel.h"
#include "parallel/world.h"
#include "query/elsewhere.h"
#include "query/sampler.h"

namespace insitu::advect {

/// The processes over which a tracer's mesh is spread.
struct Across {
  parallel::World& world;
  const Homes& homes; ///< of the cells of the sampler's mesh
};

/// Makes the cells of one interval, with none of other processes yet. here: of this process's
/// cells, and of those around them; fields_of() is called once, within an agreement, and its
/// fields become those of the cells' sampler. Collective; throws parallel::AgreedError.
void make_far_cells(const Across& across, const query::Sampler& here, const core::Threads& threads,
                    core::FunctionRef<std::vector<FarCells::InTime>()> fields_of,
                    std::optional<FarCells>& cells);

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
  /// The arguments must outlive the object. before: of the step before a change of cells, or null.
  Rounds(const Across& across, insitu_accuracy accuracy, FarCells& cells, FarCells* before,
         Particles& particles, Snapshots* snapshots);

  /// carry(particles) moves these, by their places among the particles, as far as that goes here;
  /// it tells of each that is not at its end by moves() or waits(). Not collective.
  void run(core::FunctionRef<void(std::span<const std::size_t>)> carry);
  /// At the end, particles that are alive, in `left` or in a cell that is not here go to the
  /// process that owns their cell, and so do snapshots in such cells; `left` is then that of the
  /// particles that are here.
  void bring_home(std::vector<LeftAt>& left);

  // For carry(), from any thread.
  /// Of all cells that are here.
  const Homes& homes() const { return homes_; }
  /// How a particle goes on.
  OnTheWay way_of(std::size_t particle) const;
  /// The particle's cell is another process's.
  void moves(std::size_t particle, const OnTheWay& way);
  /// Its next step needs a place that another process may hold.
  void waits(std::size_t particle, const OnTheWay& way, const query::Elsewhere& at);

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
    bool goes = false; ///< to the holder
    bool is_near = false;
    query::Location found = {};
    std::optional<math::Vec3d> nearest = {};

    bool may_go() const;
    void note(int rank, const Answer& answer);
  };
  std::int64_t sum(std::int64_t mine) const;
  std::vector<parallel::Parcel> exchange(std::span<const parallel::Parcel> parcels);
  void send(std::vector<LeftAt>* left);
  void receive(std::span<const parallel::Parcel> parcels, std::vector<LeftAt>* left);
  void ask();
  void answer(const Question& question, parallel::ByteWriter& to) const;
  void take_answers(const parallel::Parcel& parcel);
  void go_on(const Waiting& waiting);
  void send_snapshots();

  parallel::World& world_;
  insitu_accuracy accuracy_;
  FarCells& cells_;
  FarCells* before_;
  const Homes& homes_; ///< of all cells that are here
  Particles& particles_;
  Snapshots* snapshots_;
  std::mutex mutex_;
  std::vector<Moving> moving_;
  std::vector<Waiting> waiting_;
  std::unordered_map<std::size_t, OnTheWay> ways_; ///< of particles that are under way
  std::vector<std::size_t> todo_;
  std::int64_t hops_ = 0, questions_ = 0, rounds_ = 0, bytes_ = 0;
};

} // namespace insitu::advect
