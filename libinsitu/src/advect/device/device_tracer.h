#pragma once

#include <cstdint>

#include "mesh/registered/mesh.h"
#include "query/device/device_locator.h"

namespace insitu::advect {

/// Particles in device memory, and the steady velocity through which they move.
struct DeviceParticles {
  double* positions = nullptr;     ///< [count][3], moved in place
  std::uint32_t* cells = nullptr;  ///< [count] where they are: `none` at first, flat ids after
  std::uint8_t* endings = nullptr; ///< [count] insitu_ending; particles alive are moved
  std::int64_t count = 0;
  mesh::FieldView velocity; ///< of three components
  double step = 0.0;        ///< negative: backwards
  std::int64_t steps = 0;
  void* stream = nullptr; ///< cudaStream_t; null: the default stream
};

/// Moves particles on the device of a locator, which finds their cells.
class DeviceTracer {
public:
  explicit DeviceTracer(const query::DeviceLocator& locator) : locator_(&locator) {}

  /// Queues steps of Kutta's method of order 4, as advect::Rk4 takes them, on the stream, and waits
  /// for nothing. A particle that a step takes out of the mesh, or to a velocity that is not
  /// finite, ends where it was before that step. A point that double leaves undecided is in the
  /// lowest cell where Newton's method puts it. Throws core::Error.
  void advance(const DeviceParticles& particles) const;

private:
  const query::DeviceLocator* locator_;
};

} // namespace insitu::advect
