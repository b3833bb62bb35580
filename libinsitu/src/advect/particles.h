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
  std::array<std::int64_t, INSITU_END_COUNT> by_ending{}; ///< [INSITU_END_ALIVE]: still alive

  std::int64_t alive() const { return by_ending[INSITU_END_ALIVE]; }
  std::int64_t sum() const;
  Counts& operator+=(const Counts& b);
};

/// "200 seeded = 150 alive + 50 left": the endings that there are.
std::string describe(const Counts& counts);

/// The name of an ending in files and messages, such as "left"; "unknown" for another number.
const char* ending_name(insitu_ending ending);

/// What effects know of a particle besides its State.
struct Carried {
  std::int64_t id = 0;
  std::int64_t walk_steps = 0; ///< of the random walk so far
  math::Vec3d velocity;        ///< its own, under inertia; NaN: none yet
};

/// Particles, as a structure of arrays of equal length; ids count up from 0 in the order of seeding
/// and are never used again. None is lost: a particle is here, with its ending, or was dropped
/// after it had ended and is counted.
class Particles {
public:
  explicit Particles(core::Memory& memory);

  /// What some effects keep for every particle, from now on.
  void keep_walk_steps();
  void keep_velocities();
  void keep_parametric();

  /// Adds particles at rest, alive, in no cell.
  void seed(std::span<const math::Vec3d> points, double time);

  /// Ends those that are still alive as killed.
  void kill();

  /// Forgets the particles that have ended; the others keep their order. Counts stay.
  void drop_ended();

  std::size_t size() const { return ids.size(); }
  std::int64_t seeded() const { return seeded_; }

  /// Recounted from the particles. Throws Error(INSITU_ERROR_INTERNAL) if they do not sum up to
  /// what was seeded.
  Counts counts() const;

  /// Everything, to a checkpoint or back.
  void keep(core::Archive& archive);

  State state(std::size_t i) const;
  void set_state(std::size_t i, const State& s, std::int64_t cell);
  Carried carried(std::size_t i) const;
  void set_carried(std::size_t i, const Carried& carried);

  core::Buffer<std::int64_t> ids;
  core::Buffer<math::Vec3d> positions;
  core::Buffer<std::int64_t> cells;   ///< flat id of the last cell, the next query's hint; -1: none
  core::Buffer<double> times;         ///< of the position
  core::Buffer<double> seeding_times; ///< age = time - seeding time
  core::Buffer<double> lengths;       ///< of the path so far
  core::Buffer<double> steps;         ///< that the integrator wants next; 0: none yet
  core::Buffer<std::uint8_t> endings; ///< insitu_ending
  core::Buffer<std::uint8_t> fresh;   ///< 1: not found inside yet
  // Of effects; empty without them.
  core::Buffer<std::int64_t> walk_steps; ///< of the random walk so far
  core::Buffer<math::Vec3d> velocities;  ///< of particles with inertia; NaN: none yet
  core::Buffer<math::Vec3d> parametric;  ///< in their cells, of attached particles

private:
  template <class F>
  void for_each_array(F&& f);

  bool keeps_walk_steps_ = false, keeps_velocities_ = false, keeps_parametric_ = false;
  std::int64_t seeded_ = 0;
  Counts dropped_; ///< by_ending alone
};

} // namespace insitu::advect
