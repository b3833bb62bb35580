#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "measure.h"
#include "options.h"
#include "setup.h"

namespace insitu::bench {

/// An effect on particles: the same advances without any, and with it, in turns.
struct ParticleRow {
  std::string effect;
  Series bare, with;
  std::int64_t particles = 0;
  std::int64_t steps = 0, evaluations = 0; ///< with it: of the velocity's integrator
  std::int64_t evaluations_bare = 0;
  std::int64_t walk_steps = 0, contacts = 0;
  std::int64_t bytes_bare = 0, bytes_with = 0; ///< at most, while they move
};

/// Particles in a flow over the mesh's unit box, ten advances long, by the options' threads.
std::vector<ParticleRow> particle_effects(const Options& options, Setup& setup,
                                          const commit::CommittedMesh& mesh);

} // namespace insitu::bench
