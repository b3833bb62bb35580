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

const Processes& Solver::alone() {
  static const Processes one;
  return one;
}

Solver::Solver(const Config& config, const Processes& processes)
    : config_(config), processes_(processes) {
  check(config);
  box_ = Box::of_process(config.cells, processes.rank(), processes.size());
  build_mesh();
  find_corners();
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
  const auto squared_distance = [=](double i, double j, double k) {
    return dx * dx * i * i + dy * dy * j * j + dz * dz * k * k;
  };
  // Every process goes through all cells that get some, so that all have the same sum.
  const auto reached = [&](int cells, double d) {
    return static_cast<int>(std::min<double>(cells, 3.0 * width / d + 1.0));
  };
  const Triple end{reached(nx, dx), reached(ny, dy), reached(nz, dz)};
  double sum = 0.0;
  for_each({0, 0, 0}, end, [&](const Triple& cell) {
    const auto [i, j, k] = cell;
    const double r2 = squared_distance(i + 0.5, j + 0.5, k + 0.5);
    if (!(r2 < 9.0 * width * width || cell == Triple{0, 0, 0}))
      return;
    const double e = std::exp((squared_distance(0.5, 0.5, 0.5) - r2) / (width * width));
    sum += e * cell_mass_;
    if (box_.has(cell))
      energy[static_cast<std::size_t>(box_.cell(cell))] = e;
  });
  for (double& e : energy)
    e *= config_.energy / 8.0 / sum;
}

void Solver::build_mesh() {
  const auto [nx, ny, nz] = config_.cells;
  const Box all{{0, 0, 0}, config_.cells};
  const bool wall = config_.outer == Boundary::wall;
  const std::size_t cells = box_.cell_count(), vertices = box_.vertex_count();
  if (cells > 0) {
    const Triple behind{box_.end[0] + 1, box_.end[1] + 1, box_.end[2] + 1};
    for_each(box_.begin, behind, [&](const Triple& vertex) {
      const auto [i, j, k] = vertex;
      x.push_back(config_.length * i / nx);
      y.push_back(config_.length * j / ny);
      z.push_back(config_.length * k / nz);
      fixed_.push_back(static_cast<std::uint8_t>((i == 0 || (wall && i == nx)) |
                                                 (j == 0 || (wall && j == ny)) << 1 |
                                                 (k == 0 || (wall && k == nz)) << 2));
      vertex_ids.push_back(all.vertex(vertex));
    });
  }
  for_each(box_.begin, box_.end, [&](const Triple& cell) {
    for (int corner = 0; corner < 8; ++corner)
      connectivity.push_back(box_.vertex(CellCorner{cell, corner}.vertex()));
    cell_ids.push_back(all.cell(cell));
  });
  cell_mass_ =
      config_.density * ((config_.length / nx) * (config_.length / ny) * (config_.length / nz));
  for (auto* array : {&u, &v, &w, &vertex_mass_})
    array->assign(vertices, 0.0);
  for (auto* array : {&half_x_, &half_y_, &half_z_, &half_u_, &half_v_, &half_w_})
    array->assign(vertices, 0.0);
  for (auto* array : {&energy, &pressure, &viscosity, &half_energy_})
    array->assign(cells, 0.0);
  density.assign(cells, config_.density);
}

void Solver::find_corners() {
  const Box all{{0, 0, 0}, config_.cells};
  const std::size_t own = connectivity.size();
  std::vector<std::int32_t> vertex_of(connectivity); // of each entry of the forces
  std::vector<std::int64_t> received_cells;          // their ids
  for (int process = 0; process < processes_.size(); ++process) {
    const Box theirs = Box::of_process(config_.cells, process, processes_.size());
    Neighbour neighbour{{}, vertex_of.size(), 0};
    if (process == processes_.rank())
      continue;
    for (const CellCorner& c : corners_at(box_, theirs))
      neighbour.sent.push_back(static_cast<std::size_t>(8 * box_.cell(c.cell) + c.corner));
    for (const CellCorner& c : corners_at(theirs, box_)) {
      vertex_of.push_back(box_.vertex(c.vertex()));
      received_cells.push_back(all.cell(c.cell));
    }
    neighbour.received = vertex_of.size() - neighbour.first_received;
    if (neighbour.received == 0)
      continue;
    messages_.push_back({process, std::vector<double>(3 * neighbour.sent.size()),
                         std::vector<double>(3 * neighbour.received)});
    neighbours_.push_back(std::move(neighbour));
  }
  for (auto* array : {&force_x_, &force_y_, &force_z_})
    array->assign(vertex_of.size(), 0.0);

  corner_begin_.assign(vertex_count() + 1, 0);
  for (std::int32_t vertex : vertex_of)
    ++corner_begin_[vertex + 1];
  for (std::size_t i = 0; i < vertex_count(); ++i)
    corner_begin_[i + 1] += corner_begin_[i];
  corners_.resize(vertex_of.size());
  std::vector<std::int32_t> next(corner_begin_.begin(), corner_begin_.end() - 1);
  for (std::size_t i = 0; i < vertex_of.size(); ++i) {
    corners_[next[vertex_of[i]]++] = static_cast<std::int32_t>(i);
    vertex_mass_[vertex_of[i]] += cell_mass_ / 8.0;
  }
  const auto id_of = [&](std::int32_t entry) {
    const std::size_t i = static_cast<std::size_t>(entry);
    return i < own ? cell_ids[i / 8] : received_cells[i - own];
  };
  for (std::size_t i = own; i < vertex_of.size(); ++i) // at vertices with no others they ascend
    std::sort(corners_.begin() + corner_begin_[vertex_of[i]],
              corners_.begin() + corner_begin_[vertex_of[i] + 1],
              [&](std::int32_t a, std::int32_t b) { return id_of(a) < id_of(b); });
}

void Solver::exchange_forces() {
  for (std::size_t n = 0; n < neighbours_.size(); ++n) {
    double* out = messages_[n].out.data();
    for (const std::size_t i : neighbours_[n].sent)
      for (const double force : {force_x_[i], force_y_[i], force_z_[i]})
        *out++ = force;
  }
  processes_.exchange(messages_);
  for (std::size_t n = 0; n < neighbours_.size(); ++n) {
    const double* in = messages_[n].in.data();
    const std::size_t first = neighbours_[n].first_received;
    for (std::size_t i = first; i < first + neighbours_[n].received; ++i)
      for (auto* force : {&force_x_, &force_y_, &force_z_})
        (*force)[i] = *in++;
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
      energy_to[cell] = energy[cell] - dt * power / cell_mass_;
    }
  });
}

double Solver::internal_energy() const {
  return processes_.sum(cell_count(), [&](std::size_t cell) { return cell_mass_ * energy[cell]; });
}

double Solver::kinetic_energy() const {
  const auto of_vertex = [&](std::size_t i) {
    // Counted where the first of all cells at the vertex is.
    const bool is_counted =
        corners_[corner_begin_[i]] < static_cast<std::int32_t>(8 * cell_count());
    return is_counted ? vertex_mass_[i] * (u[i] * u[i] + v[i] * v[i] + w[i] * w[i]) : 0.0;
  };
  return 0.5 * processes_.sum(vertex_count(), of_vertex);
}

double Solver::shock_radius() const {
  const auto weight = [&](std::size_t cell) {
    return viscosity[cell] > 0.0 ? viscosity[cell] * cell_mass_ / density[cell] : 0.0;
  };
  const auto radius = [&](std::size_t cell) {
    double cx = 0.0, cy = 0.0, cz = 0.0;
    for (std::size_t corner = 8 * cell; corner < 8 * cell + 8; ++corner) {
      cx += x[connectivity[corner]] / 8.0;
      cy += y[connectivity[corner]] / 8.0;
      cz += z[connectivity[corner]] / 8.0;
    }
    return std::sqrt(cx * cx + cy * cy + cz * cz);
  };
  const double weights = processes_.sum(cell_count(), weight);
  const double sum =
      processes_.sum(cell_count(), [&](std::size_t cell) { return weight(cell) * radius(cell); });
  return weights > 0.0 ? sum / weights : 0.0;
}

} // namespace sedov
