#pragma once

#include "query/lattice/gridlet_query.h"
#include "query/lattice/gridlet_strides.h"
#include "query/ray_bundle/ray_bundle.h"
#include "render/structures/scalar_field.h"

namespace insitu::render {

/// A scalar as the locator of bundles reads it.
class ScalarValues final : public query::CellValues {
public:
  ScalarValues(const ScalarField& field, const mesh::MeshView& mesh) : field_(field), mesh_(mesh) {}
  bool is_per_cell() const override { return field_.field.association == INSITU_CELL; }
  void load(std::span<const std::int64_t> cells, query::ValueBlock& block) const override {
    if (is_per_cell()) {
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::int32_t p = piece_of(cells[i]);
        block.vertex[0][i] = field_.load(p, cells[i] - mesh_.first_cell[p]);
      }
      return;
    }
    // All are asked for before the first is waited for.
    std::int64_t ids[cells::CellBlock::size][8];
    int count[cells::CellBlock::size];
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::int32_t p = piece_of(cells[i]);
      count[i] = mesh_.pieces[p].vertex_ids(cells[i] - mesh_.first_cell[p], ids[i]);
      for (int v = 0; v < count[i]; ++v)
        field_.prefetch(p, ids[i][v]);
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::int32_t p = piece_of(cells[i]);
      for (int v = 0; v < count[i]; ++v)
        block.vertex[v][i] = field_.load(p, ids[i][v]);
    }
  }
  void at(std::span<const query::Location> at, double* values) const override {
    const mesh::GridletsView* const gridlets = query::gridlets_of(mesh_);
    if (!gridlets || is_per_cell() || (field_.component < 0 && field_.field.components > 1))
      return at_any(at, values);
    if (field_.field.pieces[0].is_float32)
      at_gridlets<float>(*gridlets, at, values);
    else
      at_gridlets<double>(*gridlets, at, values);
  }

  AtVertices at_vertices(std::int32_t piece) const override {
    const mesh::FieldPieceView& numbers = field_.field.pieces[piece];
    if (is_per_cell() || numbers.behind || (field_.component < 0 && field_.field.components > 1))
      return {};
    return {numbers.component[field_.component > 0 ? field_.component : 0], numbers.layout,
            numbers.is_float32};
  }

private:
  void at_any(std::span<const query::Location> at, double* values) const {
    for (std::size_t i = 0; i < at.size(); ++i)
      values[i] = at[i] ? field_.at(mesh_, at[i]) : 0.0;
  }
  /// The same, to the bit, where most locations lie in gridlets.
  template <class T>
  void at_gridlets(const mesh::GridletsView& gridlets, std::span<const query::Location> at,
                   double* values) const {
    const mesh::FieldPieceView& numbers = field_.field.pieces[0];
    const std::byte* const base = numbers.component[field_.component > 0 ? field_.component : 0];
    query::GridletStrides strides(gridlets.gridlets, numbers.layout.stride[0]);
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (std::uint64_t(at[i].cell) >= std::uint64_t(mesh_.first_cell[1])) {
        at_any(at.subspan(i, 1), values + i);
        continue;
      }
      const std::byte* v = base + strides.lower(at[i].cell);
      double weight[8], number[8];
      cells::shape_functions(mesh::Shape::voxel, at[i].parametric, weight);
      for (int c = 0; c < 8; ++c)
        number[c] =
            double(mesh::load_as<T>(v + (c & 1 ? strides.stride() : 0) +
                                    (c & 2 ? strides.row() : 0) + (c & 4 ? strides.layer() : 0)));
      values[i] = cells::weighted_mean(8, weight, number);
    }
  }
  std::int32_t piece_of(std::int64_t cell) const { return mesh_.piece_of(cell); }

  const ScalarField& field_;
  const mesh::MeshView& mesh_;
};

} // namespace insitu::render
