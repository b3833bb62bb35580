#include "device/launch.cuh"
#include "query/device/caller_ids.h"

namespace insitu::query::on_device {

namespace {

/// Writes what callers see of flat ids.
struct WriteIds {
  mesh::MeshView mesh;
  const std::int64_t* flat;
  std::int64_t* cells; ///< may be flat; these may be null
  std::int32_t* pieces;
  std::uint8_t* found;
  bool by_piece;
  std::int64_t base;

  INSITU_HD void operator()(std::int64_t i) const {
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

} // namespace

CallerIds::CallerIds(const device::DeviceMesh& mesh, const DeviceQuery& asked)
    : mesh_(mesh), asked_(asked), flat_(asked) {
  const bool local = asked.by_piece && mesh.host_view().piece_count > 1;
  changes_ = asked.pieces || asked.found || (asked.cells && (asked.cell_base != 0 || local));
  if (!changes_ || asked.cells || asked.count == 0)
    return;
  if (asked.on_device) {
    on_device_ = static_cast<std::int64_t*>(device::allocate_on(
        static_cast<device::StreamHandle>(asked.stream),
        std::size_t(asked.count) * sizeof(std::int64_t), "memory for cell ids"));
    flat_.cells = on_device_;
  } else {
    on_host_.resize(std::size_t(asked.count));
    flat_.cells = on_host_.data();
  }
}

CallerIds::~CallerIds() {
  if (on_device_)
    device::free_on(static_cast<device::StreamHandle>(asked_.stream), on_device_);
}

void CallerIds::finish() {
  if (!changes_ || asked_.count == 0)
    return;
  const mesh::MeshView& mesh = asked_.on_device ? mesh_.view() : mesh_.host_view();
  const WriteIds write{mesh,         flat_.cells,     asked_.cells,    asked_.pieces,
                       asked_.found, asked_.by_piece, asked_.cell_base};
  if (asked_.on_device)
    return device::launch(asked_.count, write, static_cast<device::StreamHandle>(asked_.stream),
                          "writing cell ids");
  for (std::int64_t i = 0; i < asked_.count; ++i)
    write(i);
}

} // namespace insitu::query::on_device
