#include "solver.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "hexahedron.h"
#include "threads.h"

namespace sedov {

namespace {

void check(const Config& config) {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds)
      throw std::invalid_argument(what);
  };
  for (int n : config.cells)
    require(n >= 1 && n <= 600, "1 to 600 cells along an axis expected, " + std::to_string(n) +
                                    " given"); // 8 * 600^3 corners still fit an int32
  require(config.length > 0.0, "the length must be positive");
  require(config.gamma > 1.0, "gamma must exceed 1");
  require(config.density > 0.0, "the density must be positive");
  require(config.energy >= 0.0, "the energy must not be negative");
  require(config.deposit > 0.0, "the width of the deposit must be positive");
  require(config.cfl > 0.0 && config.cfl < 1.0, "cfl must lie between 0 and 1");
  require(config.linear_viscosity >= 0.0 && config.quadratic_viscosity >= 0.0 &&
              config.hourglass >= 0.0,
          "the viscosity and hourglass coefficients must not be negative");
  require(config.threads >= 1, "at least one thread expected");
}

} // namespace

Solver::Solver(const Config& config) : config_(config) {
  check(config);
  build_mesh();
  const std::size_t corners = 8 * cell_count();
  for (auto* array : {&force_x_, &force_y_, &force_z_})
    array->assign(corners, 0.0);
  for (auto* array : {&half_x_, &half_y_, &half_z_, &half_u_, &half_v_, &half_w_})
    array->assign(vertex_count(), 0.0);
  half_energy_.assign(cell_count(), 0.0);
  deposit_energy();
  update();
}

// In a single cell the energy would throw the nearest vertex of each axis past the next one (it
// has a quarter of an inner vertex's mass); spread over a cell's width it does not, and the shock,
// once a few cells out, does not remember.
void Solver::deposit_energy() {
  const auto [nx, ny, nz] = config_.cells;
  const double dx = config_.length / nx, dy = config_.length / ny, dz = config_.length / nz;
  const double width = config_.deposit * std::max({dx, dy, dz});
  double sum = 0.0;
  std::size_t cell = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i, ++cell) {
        const auto squared_distance = [=](double a, double b, double c) {
          return dx * dx * a * a + dy * dy * b * b + dz * dz * c * c;
        };
        const double r2 = squared_distance(i + 0.5, j + 0.5, k + 0.5);
        if (r2 < 9.0 * width * width || cell == 0)
          energy[cell] = std::exp((squared_distance(0.5, 0.5, 0.5) - r2) / (width * width));
        sum += energy[cell] * cell_mass_[cell];
      }
  for (double& e : energy)
    e *= config_.energy / 8.0 / sum;
}

void Solver::build_mesh() {
  const auto [nx, ny, nz] = config_.cells;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) {
        x.push_back(config_.length * i / nx);
        y.push_back(config_.length * j / ny);
        z.push_back(config_.length * k / nz);
        const bool wall = config_.outer == Boundary::wall;
        fixed_.push_back(static_cast<std::uint8_t>((i == 0 || (wall && i == nx)) |
                                                   (j == 0 || (wall && j == ny)) << 1 |
                                                   (k == 0 || (wall && k == nz)) << 2));
      }
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (int corner : vtk_corner) { // its own inverse
          const int di = corner & 1, dj = corner >> 1 & 1, dk = corner >> 2;
          connectivity.push_back(i + di + (nx + 1) * (j + dj + (ny + 1) * (k + dk)));
        }
  const std::size_t cells = connectivity.size() / 8, vertices = x.size();
  const double cell_volume = (config_.length / nx) * (config_.length / ny) * (config_.length / nz);
  cell_mass_.assign(cells, config_.density * cell_volume);
  for (auto* array : {&u, &v, &w, &vertex_mass_})
    array->assign(vertices, 0.0);
  for (auto* array : {&energy, &pressure, &viscosity})
    array->assign(cells, 0.0);
  density.assign(cells, config_.density);

  corner_begin_.assign(vertices + 1, 0);
  for (std::int32_t vertex : connectivity)
    ++corner_begin_[vertex + 1];
  for (std::size_t i = 0; i < vertices; ++i)
    corner_begin_[i + 1] += corner_begin_[i];
  corners_.resize(connectivity.size());
  std::vector<std::int32_t> next(corner_begin_.begin(), corner_begin_.end() - 1);
  for (std::size_t i = 0; i < connectivity.size(); ++i) {
    corners_[next[connectivity[i]]++] = static_cast<std::int32_t>(i);
    vertex_mass_[connectivity[i]] += cell_mass_[i / 8] / 8.0;
  }
}

void Solver::update() {
  evaluate({x, y, z, u, v, w, energy});
}

double Solver::advance(double limit) {
  double dt = config_.cfl * stable_timestep_;
  if (cycle_ > 0)
    dt = std::min(dt, 1.1 * timestep_); // a slow start after a sudden change costs little
  timestep_ = dt;
  dt = std::min(dt, limit);
  if (!(dt > 0.0) || !std::isfinite(dt))
    throw std::runtime_error("sedov: no finite timestep in cycle " + std::to_string(cycle_) +
                             " (gas cold and at rest, and no limit given?)");

  // Predictor: to the half step with the forces of its begin.
  const double half = 0.5 * dt;
  accelerate(half, half_u_, half_v_, half_w_);
  heat(half, half_u_, half_v_, half_w_, half_energy_);
  for_ranges(config_.threads, vertex_count(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      half_x_[i] = x[i] + half * half_u_[i];
      half_y_[i] = y[i] + half * half_v_[i];
      half_z_[i] = z[i] + half * half_w_[i];
    }
  });
  evaluate({half_x_, half_y_, half_z_, half_u_, half_v_, half_w_, half_energy_});

  // Corrector: the whole step with the forces at the half step. Work is done at the mean of old and
  // new velocity, by the same corner forces that accelerate: what the cells lose is what the
  // vertices gain.
  accelerate(dt, half_u_, half_v_, half_w_); // the new velocities, for a moment
  for_ranges(config_.threads, vertex_count(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double u_old = u[i], v_old = v[i], w_old = w[i];
      u[i] = half_u_[i];
      v[i] = half_v_[i];
      w[i] = half_w_[i];
      half_u_[i] = 0.5 * (u_old + u[i]);
      half_v_[i] = 0.5 * (v_old + v[i]);
      half_w_[i] = 0.5 * (w_old + w[i]);
      x[i] += dt * half_u_[i];
      y[i] += dt * half_v_[i];
      z[i] += dt * half_w_[i];
    }
  });
  heat(dt, half_u_, half_v_, half_w_, energy);
  update();
  time_ += dt;
  ++cycle_;
  return dt;
}

void Solver::accelerate(double dt, std::vector<double>& u_to, std::vector<double>& v_to,
                        std::vector<double>& w_to) const {
  for_ranges(config_.threads, vertex_count(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double fx = 0.0, fy = 0.0, fz = 0.0;
      for (std::int32_t c = corner_begin_[i]; c < corner_begin_[i + 1]; ++c) {
        const std::size_t corner = static_cast<std::size_t>(corners_[c]);
        fx += force_x_[corner];
        fy += force_y_[corner];
        fz += force_z_[corner];
      }
      const double scale = dt / vertex_mass_[i];
      const int fixed = fixed_[i];
      u_to[i] = fixed & 1 ? 0.0 : u[i] + scale * fx;
      v_to[i] = fixed & 2 ? 0.0 : v[i] + scale * fy;
      w_to[i] = fixed & 4 ? 0.0 : w[i] + scale * fz;
    }
  });
}

void Solver::heat(double dt, const std::vector<double>& u_mean, const std::vector<double>& v_mean,
                  const std::vector<double>& w_mean, std::vector<double>& energy_to) const {
  for_ranges(config_.threads, cell_count(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t cell = begin; cell < end; ++cell) {
      double power = 0.0;
      for (std::size_t corner = 8 * cell; corner < 8 * cell + 8; ++corner) {
        const std::int32_t i = connectivity[corner];
        power += force_x_[corner] * u_mean[i] + force_y_[corner] * v_mean[i] +
                 force_z_[corner] * w_mean[i];
      }
      energy_to[cell] = energy[cell] - dt * power / cell_mass_[cell];
    }
  });
}

double Solver::internal_energy() const {
  double sum = 0.0;
  for (std::size_t cell = 0; cell < cell_count(); ++cell)
    sum += cell_mass_[cell] * energy[cell];
  return sum;
}

double Solver::kinetic_energy() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < vertex_count(); ++i)
    sum += vertex_mass_[i] * (u[i] * u[i] + v[i] * v[i] + w[i] * w[i]);
  return 0.5 * sum;
}

double Solver::shock_radius() const {
  double weights = 0.0, sum = 0.0;
  for (std::size_t cell = 0; cell < cell_count(); ++cell) {
    if (!(viscosity[cell] > 0.0))
      continue;
    double cx = 0.0, cy = 0.0, cz = 0.0;
    for (std::size_t corner = 8 * cell; corner < 8 * cell + 8; ++corner) {
      cx += x[connectivity[corner]] / 8.0;
      cy += y[connectivity[corner]] / 8.0;
      cz += z[connectivity[corner]] / 8.0;
    }
    const double weight = viscosity[cell] * cell_mass_[cell] / density[cell];
    weights += weight;
    sum += weight * std::sqrt(cx * cx + cy * cy + cz * cz);
  }
  return weights > 0.0 ? sum / weights : 0.0;
}

} // namespace sedov
