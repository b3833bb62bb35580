#pragma once

#include <cstdint>

#include "core/memory.h"
#include "math/vec.h"
#include "render/structures/scalar_field.h"
#include "render/structures/vertex_cells.h"

namespace insitu::render {

/// The gradient of a vertex field made continuous: at each vertex the plain average of its
/// cells' gradients (VertexCells; zero where there is none). A vertex's is found when it is first
/// asked for, since an isosurface meets few of a mesh's cells, and kept: new values cost no more
/// than forgetting. The same for any number of threads. At borders of pieces, where no vertices
/// coincide and no duplicates lend their values, and of gridlets there may be a step. 25 bytes a
/// vertex.
class VertexGradients {
public:
  VertexGradients(const mesh::MeshView& mesh, core::Memory& memory);

  /// Values or coordinates are others.
  void forget();

  /// Interpolated at a place of a cell. mesh, field and cells are the same in all calls from one
  /// forget() to the next, but for where their views lie. Thread-safe.
  math::Vec3d at(const mesh::MeshView& mesh, const ScalarField& vertex_field,
                 const VertexCells& around, std::int64_t flat_cell,
                 const math::Vec3d& parametric) const;

  static constexpr std::int64_t bytes_a_vertex = sizeof(math::Vec3d) + 1;

private:
  math::Vec3d of(const mesh::MeshView& mesh, const ScalarField& field, const VertexCells& around,
                 std::int32_t piece, std::int64_t vertex) const;

  mutable core::Buffer<math::Vec3d> gradients_; ///< by flat vertex
  mutable core::Buffer<std::uint8_t> is_known_;
};

} // namespace insitu::render
