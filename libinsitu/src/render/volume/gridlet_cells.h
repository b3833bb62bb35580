#pragma once

#include <cstdint>

#include "render/structures/vertex_numbers.h"

namespace insitu::render {

/// What PossibleValues finds for every cell of a gridlet, the cells all at once: minima and maxima
/// along one axis after the other, of numbers that lie side by side. Kept by a thread, for its
/// size.
class GridletCells {
public:
  /// False, with nothing found, if a number at a leaf is NaN or infinite.
  bool find(const mesh::GridletsView& all, std::int64_t gridlet, const VertexNumbers& at);

  const mesh::Gridlet& gridlet() const { return *gridlet_; }
  // Of cell (i, j, k); lower > upper where it is not full.
  double lower(int i, int j, int k) const { return lower_[place(i, j, k)]; }
  double upper(int i, int j, int k) const { return upper_[place(i, j, k)]; }

private:
  static constexpr int most_vertices = 9 * 9 * 9;
  int place(int i, int j, int k) const { return i + row_ * j + layer_ * k; }

  const mesh::Gridlet* gridlet_ = nullptr;
  int row_ = 0, layer_ = 0; ///< vertices
  double lower_[most_vertices], upper_[most_vertices];
};

} // namespace insitu::render
