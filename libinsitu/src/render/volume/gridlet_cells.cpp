#include "render/volume/gridlet_cells.h"

#include "render/volume/possible_values.h"

namespace insitu::render {

namespace {

double lower_of(double a, double b) {
  return a < b ? a : b;
}
double upper_of(double a, double b) {
  return a > b ? a : b;
}

} // namespace

bool GridletCells::find(const mesh::GridletsView& all, std::int64_t gridlet,
                        const VertexNumbers& at) {
  const mesh::Gridlet& g = all.gridlets[gridlet];
  gridlet_ = &g;
  row_ = g.size[0] + 1;
  layer_ = row_ * (g.size[1] + 1);
  int n = int(g.vertex_count());
  double not_finite = 0.0; // 0, or NaN
  for (int v = 0; v < n; ++v) {
    const std::int64_t vertex = std::int64_t(g.first) + v;
    // Vertices of no leaf belong to no full cell.
    const double x = all.leaves[vertex] == mesh::GridletsView::no_leaf ? 0.0 : at(vertex);
    not_finite += x - x;
    lower_[v] = upper_[v] = x + 0.0; // one zero, as PossibleValues::add
  }
  if (not_finite != 0.0)
    return false;
  for (const int step : {1, row_, layer_}) {
    n -= step; // what is across the end of a row or layer belongs to no cell
    for (int v = 0; v < n; ++v) {
      lower_[v] = lower_of(lower_[v], lower_[v + step]);
      upper_[v] = upper_of(upper_[v], upper_[v + step]);
    }
  }
  for (int v = 0; v < n; ++v)
    PossibleValues::widen(lower_[v], upper_[v]);
  const std::int64_t first = gridlet << mesh::Gridlet::cell_bits;
  for (int k = 0; k < g.size[2]; ++k) {
    if (all.full[(first >> 6) + k] == ~std::uint64_t(0))
      continue;
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        if (!all.is_full(first + i + 8 * (j + 8 * k))) {
          lower_[place(i, j, k)] = PossibleValues::infinity;
          upper_[place(i, j, k)] = -PossibleValues::infinity;
        }
  }
  return true;
}

} // namespace insitu::render
