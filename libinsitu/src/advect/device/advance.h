#pragma once

#include "device/stream.h"
#include "query/device/searched_mesh.h"

namespace insitu::advect::on_device {

/// What the kernel is given that moves particles; see DeviceParticles.
struct AdvanceArguments {
  query::on_device::SearchedMesh in;
  const device::KernelField* velocity = nullptr;
  double* positions = nullptr;
  std::uint32_t* cells = nullptr;
  std::uint8_t* endings = nullptr;
  double step = 0.0;
  std::int64_t steps = 0;
};

void launch_advance(const AdvanceArguments& arguments, std::int64_t count,
                    device::StreamHandle stream);

} // namespace insitu::advect::on_device
