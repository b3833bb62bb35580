#pragma once

#include <cstdint>
#include <vector>

#include "math/vec.h"
#include "workload/mesh.h"

namespace insitu::workload {

/// The blocks of a box, n along each axis, and their corners: what make_box cuts into cells.
class Lattice {
public:
  Lattice(Spacing spacing, int n, double jitter);

  int size() const { return n_; }
  /// The shortest distance between neighbouring corners before the jitter.
  double smallest_step() const;
  /// Corner (i, j, k), each 0 to n.
  math::Vec3d corner(int i, int j, int k) const;
  /// filled[i + n j]: whether block (i, j, k) is there; none is for k of -1 and n.
  void fill_plane(int k, std::vector<std::uint8_t>& filled) const;

private:
  /// Corners along an axis, and how far one moves at most.
  struct Axis {
    std::vector<double> at, reach;
  };
  Spacing spacing_;
  int n_;
  Axis axes_[3];
};

/// The share of a box's blocks that are there: 1 but for sparse.
double filled_share(Spacing spacing);

} // namespace insitu::workload
