#pragma once

#include <memory>
#include <vector>

#include "core/parallel.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

/// Calls f(pointer, count, name) for each array of the piece, so that views can be moved to copies.
/// count: 0 if the piece has none.
template <class F>
void for_each_array(PieceView& piece, F&& f) {
  f(piece.connectivity.data, piece.layout == CellLayout::block ? 0 : piece.connectivity.count,
    "connectivity");
  f(piece.offsets.data, piece.offsets.count, "offsets");
  f(piece.types, piece.types ? piece.cell_count : 0, "types");
  for (const std::byte*& axis : piece.axis)
    f(axis, std::int64_t(axis ? 1 : 0), "axis");
  for (const std::byte*& component : piece.points.component)
    f(component, piece.points.layout.count, "points");
  f(piece.ghosts, piece.ghost_layout.count, "ghosts");
}

/// A copy, on the host, of the cells, coordinates and ghosts of a mesh in device memory: for what
/// only the host does, validation and face tables, at changes of topology.
class HostMirror {
public:
  /// copy(to, from, bytes): from the device.
  using Copy = core::FunctionRef<void(std::byte* to, const std::byte* from, std::size_t bytes)>;
  HostMirror(const Mesh& mesh, Copy copy);

  const MeshView& view() const { return view_; }

private:
  struct Range {
    ExternalArray::Range of;
    std::vector<std::byte> bytes;
  };
  std::vector<std::unique_ptr<Range>> ranges_;
  std::vector<PieceView> pieces_;
  MeshView view_;
};

} // namespace insitu::mesh
