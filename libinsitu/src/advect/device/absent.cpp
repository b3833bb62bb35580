// The tracer on devices of a build without CUDA, in which no locator on a device is made.
#include "advect/device/device_tracer.h"
#include "core/status.h"

void insitu::advect::DeviceTracer::advance(const DeviceParticles&) const {
  throw core::Error(INSITU_ERROR_UNSUPPORTED, "tracers on the device: backend cuda has them");
}
