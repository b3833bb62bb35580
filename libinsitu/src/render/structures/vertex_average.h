#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "render/structures/scalar_field.h"
#include "render/structures/vertex_cells.h"

namespace insitu::render {

/// A cell field made continuous: at each vertex the plain average of the cells around it
/// (VertexCells; NaN where there is none; a cell of several parts counts once). An isosurface needs
/// it, since a field that is constant in each cell has none. Values are the same for any number of threads. At the border of two
/// pieces both have the same where vertices coincide (VertexCells) or duplicates of the other's
/// cells lend their values; otherwise an isosurface may show a step there. 8 bytes a vertex.
class VertexAverage {
public:
  VertexAverage(const mesh::MeshView& mesh, const ScalarField& cell_field,
                const VertexCells& around, const core::Threads& threads, core::Memory& memory);
  VertexAverage(const VertexAverage&) = delete;
  VertexAverage& operator=(const VertexAverage&) = delete;

  /// Other values of the same cells, in place.
  void refresh(const mesh::MeshView& mesh, const ScalarField& cell_field, const VertexCells& around,
               const core::Threads& threads);

  /// A vertex field of one component; valid as long as this object.
  ScalarField field() const;
  /// By flat vertex, for those of other processes' cells, which are not right of themselves.
  std::span<double> values() { return values_.span(); }

private:
  std::string name_;
  core::Buffer<double> values_;
  std::vector<const std::byte*> bases_;
  std::vector<mesh::FieldPieceView> views_;
};

} // namespace insitu::render
