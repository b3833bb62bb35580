// A hexahedron by its corners, for the tests of the blast wave miniapp.
#pragma once

#include "hexahedron.h"

struct Cell {
  sedov::Corners x, y, z; // numbered by bits
};

inline double volume_of(const Cell& cell) {
  sedov::Corners gx, gy, gz;
  return sedov::volume_gradient(cell.x, cell.y, cell.z, gx, gy, gz);
}
