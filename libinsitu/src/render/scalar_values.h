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
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::int32_t p = mesh_.piece_count == 1 ? 0 : mesh_.piece_of(cells[i]);
      const std::int64_t cell = cells[i] - mesh_.first_cell[p];
      if (is_per_cell()) {
        block.vertex[0][i] = field_.load(p, cell);
        continue;
      }
      std::int64_t ids[8];
      const int n = mesh_.pieces[p].vertex_ids(cell, ids);
      for (int v = 0; v < n; ++v)
        block.vertex[v][i] = field_.load(p, ids[v]);
    }
  }
  double at(const query::Location& at) const override { return field_.at(mesh_, at); }

private:
  const ScalarField& field_;
  const mesh::MeshView& mesh_;
};

} // namespace insitu::render
