#pragma once

#include "query/ray_bundle.h"
#include "render/scalar_field.h"

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
  double at(const query::Location& at) const override { return field_.at(mesh_, at); }

private:
  std::int32_t piece_of(std::int64_t cell) const {
    return mesh_.piece_count == 1 ? 0 : mesh_.piece_of(cell);
  }

  const ScalarField& field_;
  const mesh::MeshView& mesh_;
};

} // namespace insitu::render
