#include "workload/lattice.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace insitu::workload {

namespace {

/// Corners from 0 on, whose steps grow by a constant factor from `first` to `last`.
std::vector<double> geometric(int n, double first, double last) {
  std::vector<double> at(std::size_t(n) + 1, 0.0);
  const double factor = n > 1 ? std::pow(last / first, 1.0 / (n - 1)) : 1.0;
  for (int i = 0; i < n; ++i)
    at[std::size_t(i) + 1] = at[std::size_t(i)] + first * std::pow(factor, i);
  return at;
}

constexpr int islands = 24;
constexpr double island_radius = 0.0825;

} // namespace

Lattice::Lattice(Spacing spacing, int n, double jitter) : spacing_(spacing), n_(n) {
  for (int a = 0; a < 3; ++a) {
    Axis& axis = axes_[a];
    const auto last = std::size_t(n);
    if (spacing == Spacing::graded) {
      axis.at = geometric(n, 1.0, 1e4);
      const double length = axis.at[last];
      for (double& x : axis.at)
        x /= length;
    } else if (spacing == Spacing::layers && a == 2) {
      axis.at = geometric(n, 1e-6 / n, 1e-4 / n);
    } else {
      for (int i = 0; i <= n; ++i)
        axis.at.push_back(double(i) / n);
      axis.reach.assign(last + 1, jitter / n);
      continue;
    }
    axis.reach.assign(last + 1, 0.0);
    for (std::size_t i = 1; i < last; ++i)
      axis.reach[i] = jitter * std::min(axis.at[i] - axis.at[i - 1], axis.at[i + 1] - axis.at[i]);
  }
}

double Lattice::smallest_step() const {
  double step = 1.0;
  for (const Axis& axis : axes_)
    for (std::size_t i = 1; i < axis.at.size(); ++i)
      step = std::min(step, axis.at[i] - axis.at[i - 1]);
  return step;
}

math::Vec3d Lattice::corner(int i, int j, int k) const {
  const int ijk[3] = {i, j, k};
  const bool interior = std::all_of(ijk, ijk + 3, [&](int x) { return x > 0 && x < n_; });
  const std::int64_t m = n_ + 1, v = i + m * (j + m * k);
  math::Vec3d x;
  for (int c = 0; c < 3; ++c) {
    const auto at = std::size_t(ijk[c]);
    x[c] = axes_[c].at[at];
    if (interior)
      x[c] += axes_[c].reach[at] *
              (2.0 * core::random_unit(1, std::uint64_t(v), std::uint64_t(c)) - 1.0);
  }
  return x;
}

void Lattice::fill_plane(int k, std::vector<std::uint8_t>& filled) const {
  const bool there = k >= 0 && k < n_, all = spacing_ != Spacing::sparse;
  filled.assign(std::size_t(n_) * std::size_t(n_), there && all);
  if (!there || all)
    return;
  for (int island = 0; island < islands; ++island) {
    double centre[3];
    for (std::uint64_t c = 0; c < 3; ++c)
      centre[c] = core::random_unit(8, std::uint64_t(island), c);
    for (int j = 0; j < n_; ++j) {
      const double y = (j + 0.5) / n_ - centre[1], z = (k + 0.5) / n_ - centre[2];
      const double chord = island_radius * island_radius - y * y - z * z;
      if (chord <= 0.0)
        continue;
      const double half = std::sqrt(chord);
      const int first = std::max(0, int(std::ceil((centre[0] - half) * n_ - 0.5)));
      const int last = std::min(n_ - 1, int(std::floor((centre[0] + half) * n_ - 0.5)));
      for (int i = first; i <= last; ++i)
        filled[std::size_t(i) + std::size_t(n_) * std::size_t(j)] = 1;
    }
  }
}

double filled_share(Spacing spacing) {
  if (spacing != Spacing::sparse)
    return 1.0;
  constexpr int n = 128;
  const Lattice lattice(spacing, n, 0.0);
  std::vector<std::uint8_t> filled;
  std::int64_t count = 0;
  for (int k = 0; k < n; ++k) {
    lattice.fill_plane(k, filled);
    count += std::count(filled.begin(), filled.end(), 1);
  }
  return double(count) / (double(n) * n * n);
}

} // namespace insitu::workload
