#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "advect/integrate/settings.h"
#include "core/archive.h"
#include "core/memory.h"

namespace insitu::advect {

/// How many particles were seeded, and what became of them.
struct Counts {
  std::int64_t seeded = 0;
  std::array<std::int64_t, INSITU_END_COUNT> by_ending{}; ///< [insitu_ending]; INSITU_END_ALIVE
                                                          ///< counts particles that still live

  std::int64_t alive() const { return by_ending[INSITU_END_ALIVE]; }
  std::int64_t sum() const;
  Counts& operator+=(const Counts& b);
};

/// Returns a text such as "200 seeded = 150 alive + 50 left", with the endings that occur.
std::string describe(const Counts& counts);

/// Returns the name of an ending in files and messages, such as "left", and "unknown" for any other
/// number.
const char* ending_name(insitu_ending ending);

/// What effects know of a particle besides its State.
struct Carried {
  std::int64_t id = 0;
  std::int64_t walk_steps = 0; ///< steps of the random walk so far
  math::Vec3d velocity;        ///< velocity of the particle under inertia; NaN: none yet
};

/// Particles as a structure of arrays of equal length. Ids count up from 0 in the order of seeding,
/// and no id is used twice. No particle is lost: it is here, with its ending, or it was dropped
/// after it had ended, and is counted.
class Particles {
public:
  explicit Particles(core::Memory& memory);

  /// Make the arrays that some effects need, from now on, for every particle.
  void keep_walk_steps();
  void keep_velocities();
  void keep_parametric();

  /// Adds particles that are alive, in no cell, and have no velocity of their own yet.
  void seed(std::span<const math::Vec3d> points, double time);
  /// Takes memory for so many more, whose seeding then does not fail.
  void reserve(std::size_t more);
  /// Of seeds that all processes have, adds those that are kept here: keeps[i] of points[i]. Ids
  /// count all of them.
  void seed(std::span<const math::Vec3d> points, double time, std::span<const std::uint8_t> keeps);

  // Particles that go from process to process. Those that are here are counted here.

  /// The ending of a particle that went to another process: its place among the particles stays
  /// until drop_gone().
  static constexpr std::uint8_t gone = INSITU_END_COUNT;
  /// A particle in plain data; its cell is of this process.
  struct Record {
    std::int64_t id;
    math::Vec3d position;
    std::int64_t cell;
    double time, seeding_time, length, step;
    std::uint8_t ending, fresh;
    std::int64_t walk_steps;
    math::Vec3d velocity;
  };
  Record record(std::size_t i) const;
  void leave(std::size_t i);
  /// Adds one that comes from another process.
  void arrive(const Record& from);
  /// Takes back the last that arrived, down to so many particles.
  void take_back_to(std::size_t size);
  void drop_gone();

  /// Ends the particles that are still alive as killed.
  void kill();

  /// Forgets the particles that have ended. Particles that are alive keep their order, and counts
  /// stay.
  void drop_ended();
  /// The mesh's cells are others by now, and particles that have ended are in none of them.
  void leave_cells_of_ended();

  std::size_t size() const { return ids.size(); }
  std::int64_t seeded() const { return seeded_; }

  /// Returns the counts, recounted from the particles. Throws Error(INSITU_ERROR_INTERNAL) if they
  /// do not sum up to the particles that were seeded; of several processes, of those that are here.
  Counts counts() const;

  /// Makes these, of which there are none yet, the particles of all processes, which are to
  /// arrive(): here are those of one process. dropped: by ending, on all processes.
  void begin_all(const Particles& here, std::span<const std::int64_t> dropped);
  /// How many have been dropped on this process, by their endings.
  std::span<const std::int64_t> dropped() const { return dropped_.by_ending; }

  /// Writes what all processes know alike to a checkpoint, or reads it from one.
  void keep_common(core::Archive& archive);
  /// The same with all particles, after keep_common().
  void keep(core::Archive& archive);

  State state(std::size_t i) const;
  void set_state(std::size_t i, const State& s, std::int64_t cell);
  Carried carried(std::size_t i) const;
  void set_carried(std::size_t i, const Carried& carried);

  core::Buffer<std::int64_t> ids;
  core::Buffer<math::Vec3d> positions;
  core::Buffer<std::int64_t> cells;   ///< flat id of the last cell, which is the hint of the next
                                      ///< query; -1: none
  core::Buffer<double> times;         ///< times of the positions
  core::Buffer<double> seeding_times; ///< age = time - seeding time
  core::Buffer<double> lengths;       ///< lengths of the paths so far
  core::Buffer<double> steps;         ///< steps that the integrator wants next; 0: none yet
  core::Buffer<std::uint8_t> endings; ///< an insitu_ending each
  core::Buffer<std::uint8_t> fresh;   ///< 1: the particle was not found inside yet
  // The arrays below serve effects, and are empty without them.
  core::Buffer<std::int64_t> walk_steps; ///< steps of the random walk so far
  core::Buffer<math::Vec3d> velocities;  ///< velocities of particles with inertia; NaN: none yet
  core::Buffer<math::Vec3d> parametric;  ///< coordinates of attached particles in their cells

private:
  template <class F>
  void for_each_array(F&& f);
  void set(std::size_t i, const Record& from);

  bool keeps_walk_steps_ = false, keeps_velocities_ = false, keeps_parametric_ = false;
  std::int64_t seeded_ = 0; ///< on all processes
  std::int64_t here_ = 0;   ///< of them, those that are here or have ended here
  Counts dropped_;          ///< by_ending of dropped particles; seeded is not used
};

} // namespace insitu::advect
