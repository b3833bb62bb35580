#include "box.h"

#include <algorithm>

#include "hexahedron.h"

namespace sedov {

Box Box::of_process(const Triple& cells, int rank, int size) {
  Box box{{0, 0, 0}, cells};
  while (size > 1) {
    int axis = 2;
    for (int a : {1, 0})
      if (box.length(a) > box.length(axis))
        axis = a;
    const int below = size / 2, cut = box.begin[axis] + box.length(axis) * below / size;
    if (rank < below) {
      box.end[axis] = cut;
      size = below;
    } else {
      box.begin[axis] = cut;
      rank -= below;
      size -= below;
    }
  }
  return box;
}

std::size_t Box::cell_count() const {
  return static_cast<std::size_t>(length(0)) * length(1) * length(2);
}

std::size_t Box::vertex_count() const {
  return cell_count() == 0
             ? 0
             : static_cast<std::size_t>(length(0) + 1) * (length(1) + 1) * (length(2) + 1);
}

bool Box::has(const Triple& cell) const {
  for (int a = 0; a < 3; ++a)
    if (cell[a] < begin[a] || cell[a] >= end[a])
      return false;
  return true;
}

std::int32_t Box::cell(const Triple& at) const {
  return at[0] - begin[0] + length(0) * (at[1] - begin[1] + length(1) * (at[2] - begin[2]));
}

std::int32_t Box::vertex(const Triple& at) const {
  return at[0] - begin[0] +
         (length(0) + 1) * (at[1] - begin[1] + (length(1) + 1) * (at[2] - begin[2]));
}

Triple CellCorner::vertex() const {
  const int bits = vtk_corner[corner];
  return {cell[0] + (bits & 1), cell[1] + (bits >> 1 & 1), cell[2] + (bits >> 2)};
}

std::vector<CellCorner> corners_at(const Box& of_cells, const Box& of_vertices) {
  std::vector<CellCorner> corners;
  if (of_cells.cell_count() == 0 || of_vertices.cell_count() == 0)
    return corners;
  Triple begin, end; // of the cells that touch the other box
  for (int a = 0; a < 3; ++a) {
    begin[a] = std::max(of_cells.begin[a], of_vertices.begin[a] - 1);
    end[a] = std::min(of_cells.end[a], of_vertices.end[a] + 1);
  }
  for_each(begin, end, [&](const Triple& cell) {
    for (int corner = 0; corner < 8; ++corner) {
      const CellCorner c{cell, corner};
      const Triple v = c.vertex();
      bool is_inside = true;
      for (int a = 0; a < 3; ++a)
        is_inside = is_inside && of_vertices.begin[a] <= v[a] && v[a] <= of_vertices.end[a];
      if (is_inside)
        corners.push_back(c);
    }
  });
  return corners;
}

} // namespace sedov
