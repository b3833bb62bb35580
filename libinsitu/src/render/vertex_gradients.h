#pragma once

#include <cstdint>

#include "core/memory.h"
#include "core/parallel.h"
#include "math/vec.h"
#include "render/scalar_field.h"

namespace insitu::render {

/// The gradient of a vertex field made continuous: at each vertex the plain average of the owning
/// cells' gradients there (zero where there is none). The same for any number of threads. Vertices
/// are those of one piece, and of one gridlet: at their borders there may be a step. 24 bytes a
/// vertex, and while it is made 8 bytes more per vertex and 4 per corner of a cell.
class VertexGradients {
public:
  VertexGradients(const mesh::MeshView& mesh, const ScalarField& vertex_field,
                  const core::Threads& threads, core::Memory& memory);

  /// Other values at the same vertices, in place.
  void refresh(const mesh::MeshView& mesh, const ScalarField& vertex_field,
               const core::Threads& threads);

  /// Interpolated at a place of a cell.
  math::Vec3d at(const mesh::MeshView& mesh, std::int64_t flat_cell,
                 const math::Vec3d& parametric) const;

private:
  void average_piece(const mesh::MeshView& mesh, const ScalarField& field, std::int32_t piece,
                     const core::Threads& threads);

  core::Memory* memory_;
  core::Buffer<math::Vec3d> gradients_; ///< by flat vertex
};

} // namespace insitu::render
