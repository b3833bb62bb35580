// The part of the cube's grid that one process has: a box of cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sedov {

using Triple = std::array<int, 3>; // (i, j, k) in the grid of the whole cube

// Cells from begin to before end along each axis, and their vertices, which neighbours have too.
struct Box {
  Triple begin, end;

  // Of process `rank` of `size`: the cube is halved across its longest side, with processes in
  // proportion on both sides, until each has its own box. A box may have no cells.
  static Box of_process(const Triple& cells, int rank, int size);

  int length(int axis) const { return end[axis] - begin[axis]; }
  std::size_t cell_count() const;
  std::size_t vertex_count() const; // 0 without cells
  bool has(const Triple& cell) const;

  // Numbers in this box, of cells and vertices of the cube that are in it: i first, k last.
  std::int32_t cell(const Triple& at) const;
  std::int32_t vertex(const Triple& at) const;
};

// Calls visit(Triple) for i, j, k from begin to before end, i first.
template <typename Visit>
void for_each(const Triple& begin, const Triple& end, const Visit& visit) {
  for (int k = begin[2]; k < end[2]; ++k)
    for (int j = begin[1]; j < end[1]; ++j)
      for (int i = begin[0]; i < end[0]; ++i)
        visit(Triple{i, j, k});
}

// A corner of a cell, in VTK's order.
struct CellCorner {
  Triple cell;
  int corner;

  Triple vertex() const;
};

// The corners of a box's cells that lie at vertices of another box, in the order of the cells.
std::vector<CellCorner> corners_at(const Box& of_cells, const Box& of_vertices);

} // namespace sedov
