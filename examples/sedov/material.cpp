#include "material.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "hexahedron.h"

namespace sedov {

namespace {

// The cell's eight corners, numbered by bits.
struct Cell {
  double x[8][3];

  Cell(const Solver& solver, std::int64_t cell) {
    const std::int32_t* ids = &solver.connectivity[8 * static_cast<std::size_t>(cell)];
    for (std::size_t v = 0; v < 8; ++v) {
      const auto id = static_cast<std::size_t>(ids[vtk_corner[v]]);
      x[v][0] = solver.x[id];
      x[v][1] = solver.y[id];
      x[v][2] = solver.z[id];
    }
  }

  // Of corner v along axis a: the linear function that is 1 there and 0 at the other end.
  static double linear(int v, int a, double r) { return v >> a & 1 ? r : 1.0 - r; }

  // The trilinear map; relative to corner 0, which keeps digits.
  void map(const double* r, double* out) const {
    for (int a = 0; a < 3; ++a) {
      double sum = 0.0;
      for (int v = 1; v < 8; ++v) {
        double weight = 1.0;
        for (int b = 0; b < 3; ++b)
          weight *= linear(v, b, r[b]);
        sum += weight * (x[v][a] - x[0][a]);
      }
      out[a] = x[0][a] + sum;
    }
  }

  // What a change of one in every coordinate can make of (r, s, t), to first order: the sums over
  // the rows of the absolute inverse of the map's derivative at r.
  void sensitivity(const double* r, double* out) const {
    double d[3][3] = {}; // d[b]: derivative along parametric axis b
    for (int v = 0; v < 8; ++v)
      for (int b = 0; b < 3; ++b) {
        double weight = v >> b & 1 ? 1.0 : -1.0;
        for (int o = 0; o < 3; ++o)
          if (o != b)
            weight *= linear(v, o, r[o]);
        for (int a = 0; a < 3; ++a)
          d[b][a] += weight * (x[v][a] - x[0][a]);
      }
    for (int b = 0; b < 3; ++b) {
      const double *p = d[(b + 1) % 3], *q = d[(b + 2) % 3];
      const double n[3] = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
                           p[0] * q[1] - p[1] * q[0]};
      const double volume = d[b][0] * n[0] + d[b][1] * n[1] + d[b][2] * n[2];
      out[b] = (std::fabs(n[0]) + std::fabs(n[1]) + std::fabs(n[2])) / std::fabs(volume);
    }
  }

  double largest_coordinate() const {
    double largest = 0.0;
    for (const auto& corner_at : x)
      for (const double value : corner_at)
        largest = std::max(largest, std::fabs(value));
    return largest;
  }
};

} // namespace

void Drift::join(const Drift& other) {
  lost = std::max(lost, other.lost);
  changed = std::max(changed, other.changed);
  largest = std::max(largest, other.largest);
  roundings = std::max(roundings, other.roundings);
}

MaterialPoints::MaterialPoints(std::size_t count, const Solver& solver, std::uint64_t seed) {
  std::mt19937_64 random(seed); // its bits are the standard's, distributions' are not
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto [nx, ny, nz] = solver.config().cells;
  const std::size_t cell_count = static_cast<std::size_t>(nx) * ny * nz;
  for (std::size_t i = 0; i < count; ++i) {
    const int id = static_cast<int>(random() % cell_count);
    double at[3];
    for (double& r : at)
      r = 1e-6 + (1.0 - 2e-6) * unit(); // no rounding puts it on a face
    const Triple cell{id % nx, id / nx % ny, id / (nx * ny)};
    if (!solver.box().has(cell))
      continue;
    cells.push_back(solver.box().cell(cell));
    parametric.insert(parametric.end(), at, at + 3);
  }
  positions.resize(parametric.size());
}

void MaterialPoints::move(const Solver& solver) {
  for (std::size_t i = 0; i < cells.size(); ++i)
    Cell(solver, cells[i]).map(&parametric[3 * i], &positions[3 * i]);
}

Drift MaterialPoints::compare(const Solver& solver, const std::vector<std::int64_t>& found,
                              const std::vector<double>& at) const {
  Drift drift;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (found[i] != cells[i]) {
      ++(found[i] < 0 ? drift.lost : drift.changed);
      continue;
    }
    const Cell cell(solver, cells[i]);
    const double rounding =
        std::numeric_limits<double>::epsilon() / 2.0 * cell.largest_coordinate();
    double of_one[3];
    cell.sensitivity(&parametric[3 * i], of_one);
    for (std::size_t a = 0; a < 3; ++a) {
      const double off = std::fabs(at[3 * i + a] - parametric[3 * i + a]);
      drift.largest = std::max(drift.largest, off);
      drift.roundings = std::max(drift.roundings, off / (of_one[a] * rounding));
    }
  }
  return drift;
}

} // namespace sedov
