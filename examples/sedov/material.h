// Points carried by the material: each keeps its cell and its parametric coordinates (r, s, t)
// there for ever, since the mesh moves with the material. Whoever locates them must find both
// again, in every cycle, whatever became of the mesh: an oracle that costs nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "solver.h"

namespace sedov {

// How far answers were off; of several comparisons, the worst of each.
struct Drift {
  std::int64_t lost = 0;    // said to be outside
  std::int64_t changed = 0; // said to be in another cell
  double largest = 0.0;     // of |r|, |s|, |t| among the others
  // The same in units of what one rounding of the cell's largest coordinate makes of (r, s, t):
  // that times the inverse of the map's derivative. A few, however flat the cell.
  double roundings = 0.0;

  void join(const Drift& other);
};

class MaterialPoints {
public:
  // Random cells of the whole cube and parametric coordinates inside them, the same for the same
  // seed; of these, the ones whose cells this process has.
  MaterialPoints(std::size_t count, const Solver& solver, std::uint64_t seed);

  // Moves the points to where their cells' vertices are now.
  void move(const Solver& solver);

  // cells: [count], -1 outside; parametric: [count][3].
  Drift compare(const Solver& solver, const std::vector<std::int64_t>& cells,
                const std::vector<double>& parametric) const;

  std::vector<std::int64_t> cells; // their numbers in this process's box
  std::vector<double> parametric;  // [count][3], VTK's, from 0 to 1
  std::vector<double> positions;   // [count][3]
};

} // namespace sedov
