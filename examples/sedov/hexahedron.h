// One hexahedral cell: what the solver needs of its geometry, in closed form.
//
// Corners are numbered by bits: corner b lies at (b & 1, b >> 1 & 1, b >> 2 & 1) of the unit
// cube. vtk_corner[b] is the same corner in VTK's order (the table is its own inverse).
#pragma once

#include <array>

namespace sedov {

inline constexpr std::array<int, 8> vtk_corner{0, 1, 3, 2, 4, 5, 7, 6};

using Corners = std::array<double, 8>; // one number per corner

// Gradient of the cell's volume with respect to its corners (an area per corner, pointing
// outwards), and the volume itself. The volume is that of the trilinear map, whose faces are
// bilinear patches: exact, and the same from both sides of a face.
//
// A patch p0 p1 p2 p3 (cyclic, seen from outside) and the origin span the mean of the volumes of
// the two ways to split it into triangles, sum over the four triples of det / 12; with
// e_i = p_i + p_(i+1), the derivative with respect to p_i is e_(i+1) x e_(i+2) / 12.
// Give coordinates relative to a point of the cell, or digits are lost far from the origin.
inline double volume_gradient(const Corners& x, const Corners& y, const Corners& z, Corners& gx,
                              Corners& gy, Corners& gz);

// Walsh-Hadamard transform of the values at the corners. In reference coordinates of -1 and +1,
// mode m is the product of the coordinates of the bits in m: 0 the constant, 1, 2 and 4 the linear
// ones, 3, 5, 6 and 7 the hourglass modes. Entry m becomes the sum over the corners of value times
// mode.
inline void to_modes(Corners& values);

// The transpose: from the modes' amplitudes to the sum of the modes at the corners.
inline void from_modes(Corners& modes);

// Lowest eigenvalue of the symmetric matrix (xx, yy, zz, yz, xz, xy) and its unit eigenvector.
// Cyclic Jacobi: only sums, products, quotients and square roots, so that the result is the
// same wherever arithmetic is IEEE 754.
double lowest_eigenvalue(std::array<double, 6> matrix, std::array<double, 3>& direction);

// ------------------------------------------------------------------------------------------------

inline double volume_gradient(const Corners& x, const Corners& y, const Corners& z, Corners& gx,
                              Corners& gy, Corners& gz) {
  constexpr int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                               {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  gx = gy = gz = Corners{};
  for (const auto& face : faces) {
    double ex[4], ey[4], ez[4];
    for (int i = 0; i < 4; ++i) {
      const int a = face[i], b = face[(i + 1) & 3];
      ex[i] = x[a] + x[b];
      ey[i] = y[a] + y[b];
      ez[i] = z[a] + z[b];
    }
    for (int i = 0; i < 4; ++i) {
      const int j = (i + 1) & 3, k = (i + 2) & 3;
      gx[face[i]] += ey[j] * ez[k] - ez[j] * ey[k];
      gy[face[i]] += ez[j] * ex[k] - ex[j] * ez[k];
      gz[face[i]] += ex[j] * ey[k] - ey[j] * ex[k];
    }
  }
  double sum = 0.0;
  for (int b = 0; b < 8; ++b) {
    gx[b] *= 1.0 / 12.0;
    gy[b] *= 1.0 / 12.0;
    gz[b] *= 1.0 / 12.0;
    sum += x[b] * gx[b] + y[b] * gy[b] + z[b] * gz[b];
  }
  return sum / 3.0; // the volume is homogeneous of degree 3 in the coordinates
}

inline void to_modes(Corners& values) {
  for (int bit = 1; bit < 8; bit *= 2)
    for (int b = 0; b < 8; ++b)
      if (!(b & bit)) {
        const double low = values[b], high = values[b | bit];
        values[b] = high + low;
        values[b | bit] = high - low;
      }
}

inline void from_modes(Corners& modes) {
  for (int bit = 1; bit < 8; bit *= 2)
    for (int b = 0; b < 8; ++b)
      if (!(b & bit)) {
        const double even = modes[b], odd = modes[b | bit];
        modes[b] = even - odd;
        modes[b | bit] = even + odd;
      }
}

} // namespace sedov
