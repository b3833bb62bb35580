#include "accel/cuda/caller_ids.h"
#include "accel/cuda/launch.h"

namespace insitu::accel::cuda {

namespace {

/// What callers see of one flat id.
struct Outputs {
  const std::int64_t* flat;
  std::int64_t* cells; ///< may be flat; these may be null
  std::int32_t* pieces;
  std::uint8_t* found;
  bool by_piece;
  std::int64_t base;

  INSITU_HD void write(const mesh::MeshView& mesh, std::int64_t i) const {
    const std::int64_t cell = flat[i];
    const std::int32_t piece = cell < 0 ? -1 : mesh.piece_of(cell);
    if (pieces)
      pieces[i] = piece;
    if (found)
      found[i] = std::uint8_t(cell >= 0);
    if (cells)
      cells[i] = cell - (cell >= 0 && by_piece ? mesh.first_cell[piece] : 0) + base;
  }
};

__global__ void write_outputs(mesh::MeshView mesh, Outputs outputs, std::int64_t count) {
  if (const std::int64_t i = global_thread(); i < count)
    outputs.write(mesh, i);
}

} // namespace

CallerIds::CallerIds(const DeviceMesh& mesh, const DeviceQuery& asked)
    : mesh_(mesh), asked_(asked), flat_(asked) {
  const bool local = asked.by_piece && mesh.host_view().piece_count > 1;
  changes_ = asked.pieces || asked.found || (asked.cells && (asked.cell_base != 0 || local));
  if (!changes_ || asked.cells || asked.count == 0)
    return;
  if (asked.on_device) {
    check(cudaMallocAsync(reinterpret_cast<void**>(&on_device_),
                          std::size_t(asked.count) * sizeof(std::int64_t),
                          static_cast<cudaStream_t>(asked.stream)),
          "memory for cell ids");
    flat_.cells = on_device_;
  } else {
    on_host_.resize(std::size_t(asked.count));
    flat_.cells = on_host_.data();
  }
}

CallerIds::~CallerIds() {
  if (on_device_)
    (void)cudaFreeAsync(on_device_, static_cast<cudaStream_t>(asked_.stream));
}

void CallerIds::finish() {
  if (!changes_ || asked_.count == 0)
    return;
  const Outputs outputs{flat_.cells,  asked_.cells,    asked_.pieces,
                        asked_.found, asked_.by_piece, asked_.cell_base};
  if (!asked_.on_device) {
    for (std::int64_t i = 0; i < asked_.count; ++i)
      outputs.write(mesh_.host_view(), i);
    return;
  }
  write_outputs<<<blocks_for(asked_.count), threads_a_block, 0,
                  static_cast<cudaStream_t>(asked_.stream)>>>(mesh_.view(), outputs, asked_.count);
  check_launch("writing cell ids");
}

} // namespace insitu::accel::cuda
