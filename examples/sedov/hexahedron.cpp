#include "hexahedron.h"

#include <cmath>

namespace sedov {

double lowest_eigenvalue(std::array<double, 6> matrix, std::array<double, 3>& direction) {
  double a[3][3] = {{matrix[0], matrix[5], matrix[4]},
                    {matrix[5], matrix[1], matrix[3]},
                    {matrix[4], matrix[3], matrix[2]}};
  double vectors[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}; // columns
  constexpr int pairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  constexpr double tolerance = 1e-24; // of squares: twelve digits, plenty for a viscosity
  for (int sweep = 0; sweep < 8; ++sweep) {
    const double off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
    const double diagonal = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
    if (off <= tolerance * diagonal)
      break;
    for (const auto& [p, q] : pairs) {
      if (a[p][q] == 0.0)
        continue;
      const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
      const double t =
          (theta >= 0.0 ? 1.0 : -1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
      const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
      const int r = 3 - p - q;
      const double shift = t * a[p][q], rp = a[r][p], rq = a[r][q];
      a[p][p] -= shift;
      a[q][q] += shift;
      a[p][q] = a[q][p] = 0.0;
      a[r][p] = a[p][r] = c * rp - s * rq;
      a[r][q] = a[q][r] = s * rp + c * rq;
      for (auto& row : vectors) {
        const double vp = row[p], vq = row[q];
        row[p] = c * vp - s * vq;
        row[q] = s * vp + c * vq;
      }
    }
  }
  int lowest = 0;
  for (int i = 1; i < 3; ++i)
    if (a[i][i] < a[lowest][lowest])
      lowest = i;
  direction = {vectors[0][lowest], vectors[1][lowest], vectors[2][lowest]};
  return a[lowest][lowest];
}

} // namespace sedov
