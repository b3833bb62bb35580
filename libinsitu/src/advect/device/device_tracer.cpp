#include "advect/device/device_tracer.h"

#include "accel/cuda/device_tree.h"
#include "advect/device/advance.h"
#include "core/status.h"
#include "device/device_mesh.h"

namespace insitu::advect {

void DeviceTracer::advance(const DeviceParticles& particles) const {
  const mesh::FieldView& velocity = particles.velocity;
  if (velocity.components != 3)
    throw core::Error(INSITU_ERROR_FIELD, std::string("field '") + velocity.name +
                                              "': " + std::to_string(velocity.components) +
                                              " components; a velocity has 3");
  locator_->use_structures([&](const query::DeviceStructures& on) {
    const auto stream = static_cast<device::StreamHandle>(particles.stream);
    on_device::AdvanceArguments a;
    a.in.mesh = on.mesh.in_kernels();
    a.in.tree = on.tree.view();
    a.in.alone = on.mesh.host_view().free_of_folds;
    a.velocity = on.mesh.fields(std::span(&velocity, 1), stream);
    a.positions = particles.positions;
    a.cells = particles.cells;
    a.endings = particles.endings;
    a.step = particles.step;
    a.steps = particles.steps;
    on_device::launch_advance(a, particles.count, stream);
  });
}

} // namespace insitu::advect
