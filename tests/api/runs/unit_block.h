#pragma once

#include <vector>

#include "insitu/insitu.hpp"

namespace runs {

/// A block of n^3 cells of the unit cube.
struct UnitBlock {
  explicit UnitBlock(int cells) : side(cells + 1) {
    for (int k = 0; k < side; ++k)
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
          x.push_back(double(i) / cells);
          y.push_back(double(j) / cells);
          z.push_back(double(k) / cells);
        }
  }
  /// Its arrays must outlive the mesh.
  void hand_over(insitu::Mesh& mesh) const {
    mesh.points(x, y, z);
    mesh.block(side, side, side);
  }

  int side; ///< vertices along an axis
  std::vector<double> x, y, z;
};

} // namespace runs
