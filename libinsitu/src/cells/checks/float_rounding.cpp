#include "cells/checks/float_rounding.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "mesh/box.h"

namespace insitu::cells {

std::string float_rounding(const std::string& mesh_name, const mesh::MeshView& view) {
  constexpr std::int64_t most = 1024;
  constexpr double allowed = 1e-3;
  double worst = allowed, far = 0.0, extent = 0.0;
  char axis = 0;
  for (std::int32_t p = 0; p < view.piece_count; ++p) {
    const std::int64_t cells = view.first_cell[p + 1] - view.first_cell[p];
    if (!view.pieces[p].points.is_float32 || cells == 0)
      continue;
    const std::int64_t picked = std::min(cells, most);
    std::vector<double> extents[3];
    double largest[3] = {0.0, 0.0, 0.0};
    mesh::CellVertices cell;
    for (std::int64_t i = 0; i < picked; ++i) {
      const std::int64_t of_piece = i * cells / picked;
      if (!view.pieces[p].exists(of_piece)) // may hold garbage
        continue;
      mesh::gather(view, view.first_cell[p] + of_piece, cell);
      const mesh::Box box = mesh::box_of(cell);
      for (int a = 0; a < 3; ++a) {
        extents[a].push_back(box.size()[a]);
        largest[a] = std::max({largest[a], -box.low[a], box.high[a]});
      }
    }
    for (int a = 0; a < 3; ++a) {
      if (extents[a].empty())
        continue;
      const auto middle = extents[a].begin() + std::ptrdiff_t(extents[a].size() / 2);
      std::nth_element(extents[a].begin(), middle, extents[a].end());
      const double part = largest[a] * 0x1p-24 / *middle; // a flat axis: none, or infinite
      if (!(part > worst) || !std::isfinite(part))
        continue;
      worst = part;
      far = largest[a];
      extent = *middle;
      axis = char('x' + a);
    }
  }
  if (!axis)
    return {};
  char text[240];
  std::snprintf(
      text, sizeof text,
      "': %c reaches %.4g in 32 bits, so that vertices are rounded by up to %.2g, %.2g %% "
      "of a cell's %.3g there; 64 bits expected, or coordinates near 0",
      axis, far, far * 0x1p-24, 100 * worst, extent);
  return "mesh '" + mesh_name + text;
}

} // namespace insitu::cells
