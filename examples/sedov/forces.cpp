// The forces at the corners of the cells, and with them the stable timestep.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "hexahedron.h"
#include "solver.h"
#include "threads.h"

namespace sedov {

namespace {

double squared_norm(const Corners& x, const Corners& y, const Corners& z) {
  double sum = 0.0;
  for (int b = 0; b < 8; ++b)
    sum += x[b] * x[b] + y[b] * y[b] + z[b] * z[b];
  return sum;
}

// Rate of the strongest compression and its direction; 0, and no direction, where the gas is
// compressed along none: where the strain rate (xx, yy, zz, yz, xz, xy) is positive semidefinite,
// which its principal minors tell without eigenvalues.
double compression(const std::array<double, 6>& strain, std::array<double, 3>& direction) {
  const auto [xx, yy, zz, yz, xz, xy] = strain;
  const double minor_x = yy * zz - yz * yz, minor_y = xx * zz - xz * xz,
               minor_z = xx * yy - xy * xy;
  const double determinant = xx * minor_x - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  if (xx >= 0.0 && yy >= 0.0 && zz >= 0.0 && minor_x >= 0.0 && minor_y >= 0.0 && minor_z >= 0.0 &&
      determinant >= 0.0)
    return 0.0;
  return std::max(0.0, -lowest_eigenvalue(strain, direction));
}

// Extent of the cell along the unit vector n, 1 / |J^-1 n|, from the modes of its coordinates: J is
// the Jacobian at the centre, and its columns, the cell's mean edges, are the linear modes over 4.
double extent_along(const std::array<double, 3>& n, const Corners& px, const Corners& py,
                    const Corners& pz) {
  const auto edge = [&](int mode) {
    return std::array<double, 3>{0.25 * px[mode], 0.25 * py[mode], 0.25 * pz[mode]};
  };
  const auto triple = [](const auto& l, const auto& m, const auto& r) {
    return l[0] * (m[1] * r[2] - m[2] * r[1]) + l[1] * (m[2] * r[0] - m[0] * r[2]) +
           l[2] * (m[0] * r[1] - m[1] * r[0]);
  };
  const auto a = edge(1), b = edge(2), c = edge(4);
  const double na = triple(n, b, c), nb = triple(n, c, a), nc = triple(n, a, b);
  return std::fabs(triple(a, b, c)) / std::sqrt(na * na + nb * nb + nc * nc);
}

} // namespace

void Solver::evaluate(const State& state) {
  struct Part {
    double rate = 0.0, volume = 1.0;
    std::size_t tangled = 0;
  };
  std::vector<Part> parts(static_cast<std::size_t>(config_.threads));
  for_ranges(config_.threads, cell_count(),
             [&](std::size_t index, std::size_t begin, std::size_t end) {
               Part part;
               for (std::size_t cell = begin; cell < end && part.volume > 0.0; ++cell) {
                 const CellResult result = evaluate_cell(state, cell);
                 part.rate = std::max(part.rate, result.rate);
                 part.volume = result.volume;
                 part.tangled = cell;
               }
               parts[index] = part;
             });
  double rate = 0.0;
  for (const Part& part : parts) {
    if (!(part.volume > 0.0))
      throw std::runtime_error("sedov: the volume of cell " +
                               std::to_string(cell_ids[part.tangled]) + " became " +
                               std::to_string(part.volume) + " in cycle " + std::to_string(cycle_) +
                               "; a lower cfl may help");
    rate = std::max(rate, part.rate);
  }
  exchange_forces();
  rate = processes_.largest(rate);
  stable_timestep_ = rate > 0.0 ? 1.0 / rate : std::numeric_limits<double>::infinity();
}

Solver::CellResult Solver::evaluate_cell(const State& state, std::size_t cell) {
  const std::int32_t* const vertex = &connectivity[8 * cell];
  double *const force_x = &force_x_[8 * cell], *const force_y = &force_y_[8 * cell],
                *const force_z = &force_z_[8 * cell];
  Corners px, py, pz, pu, pv, pw;
  double motion = 0.0;
  for (int b = 0; b < 8; ++b) {
    const std::int32_t i = vertex[vtk_corner[b]];
    pu[b] = state.u[i];
    pv[b] = state.v[i];
    pw[b] = state.w[i];
    motion += std::fabs(pu[b]) + std::fabs(pv[b]) + std::fabs(pw[b]);
  }
  const double specific_energy = state.energy[cell];
  if (specific_energy == 0.0 && motion == 0.0) { // ahead of the shock: nothing acts or changed
    std::fill_n(force_x, 8, 0.0);
    std::fill_n(force_y, 8, 0.0);
    std::fill_n(force_z, 8, 0.0);
    pressure[cell] = viscosity[cell] = 0.0;
    return {0.0, 1.0};
  }
  const double ox = state.x[vertex[0]], oy = state.y[vertex[0]], oz = state.z[vertex[0]];
  for (int b = 0; b < 8; ++b) {
    const std::int32_t i = vertex[vtk_corner[b]];
    px[b] = state.x[i] - ox;
    py[b] = state.y[i] - oy;
    pz[b] = state.z[i] - oz;
  }

  Corners gx, gy, gz; // area vectors
  const double volume = volume_gradient(px, py, pz, gx, gy, gz);
  if (!(volume > 0.0))
    return {0.0, volume};
  const double mass = cell_mass_, rho = mass / volume;
  const double p = std::max(0.0, (config_.gamma - 1.0) * rho * specific_energy);
  const double sound_speed = std::sqrt(config_.gamma * p / rho);

  // Mean velocity gradient over the cell: sum of velocity (x) area / volume.
  double gradient[3][3] = {};
  for (int b = 0; b < 8; ++b) {
    const double area[3] = {gx[b], gy[b], gz[b]};
    for (int d = 0; d < 3; ++d) {
      gradient[0][d] += pu[b] * area[d];
      gradient[1][d] += pv[b] * area[d];
      gradient[2][d] += pw[b] * area[d];
    }
  }
  for (auto& row : gradient)
    for (double& entry : row)
      entry /= volume;
  const double xx = gradient[0][0], yy = gradient[1][1], zz = gradient[2][2];
  const double yz = 0.5 * (gradient[1][2] + gradient[2][1]);
  const double xz = 0.5 * (gradient[0][2] + gradient[2][0]);
  const double xy = 0.5 * (gradient[0][1] + gradient[1][0]);

  to_modes(px), to_modes(py), to_modes(pz);
  to_modes(pu), to_modes(pv), to_modes(pw);

  // Viscosity where the gas is compressed, by the cell's extent in that direction.
  double viscous = 0.0; // times the strain rate: the viscous stress
  double q = 0.0;
  std::array<double, 3> n;
  const double rate = compression({xx, yy, zz, yz, xz, xy}, n);
  if (rate > 0.0) {
    const double extent = extent_along(n, px, py, pz);
    viscous =
        rho * extent *
        (config_.quadratic_viscosity * extent * rate + config_.linear_viscosity * sound_speed);
    q = viscous * rate;
  }

  // Hourglass damping: the part of the velocity that is neither constant nor linear, mode by
  // mode. The linear part of each mode enters through the area vectors, with the stress.
  // Its coefficient is an acoustic impedance times an area, that of a face for a cube.
  const double areas = squared_norm(gx, gy, gz);
  const double speed = sound_speed + std::sqrt(q / rho);
  const double damping = config_.hourglass * rho * speed * std::sqrt(areas / 1.5);
  double stress[3][3] = {{p - viscous * xx, -viscous * xy, -viscous * xz},
                         {-viscous * xy, p - viscous * yy, -viscous * yz},
                         {-viscous * xz, -viscous * yz, p - viscous * zz}};
  Corners hu{}, hv{}, hw{};
  for (int mode : {3, 5, 6, 7}) {
    const double shape[3] = {px[mode], py[mode], pz[mode]};
    double amplitude[3] = {pu[mode], pv[mode], pw[mode]};
    for (int d = 0; d < 3; ++d)
      for (int e = 0; e < 3; ++e)
        amplitude[d] -= gradient[d][e] * shape[e];
    for (int d = 0; d < 3; ++d)
      for (int e = 0; e < 3; ++e)
        stress[d][e] += damping / volume * amplitude[d] * shape[e];
    hu[mode] = -damping * amplitude[0];
    hv[mode] = -damping * amplitude[1];
    hw[mode] = -damping * amplitude[2];
  }
  from_modes(hu), from_modes(hv), from_modes(hw);
  for (int b = 0; b < 8; ++b) {
    const int corner = vtk_corner[b];
    force_x[corner] = stress[0][0] * gx[b] + stress[0][1] * gy[b] + stress[0][2] * gz[b] + hu[b];
    force_y[corner] = stress[1][0] * gx[b] + stress[1][1] * gy[b] + stress[1][2] * gz[b] + hv[b];
    force_z[corner] = stress[2][0] * gx[b] + stress[2][1] * gy[b] + stress[2][2] * gz[b] + hw[b];
  }
  density[cell] = rho;
  pressure[cell] = p;
  viscosity[cell] = q;

  // Stability: the mesh has no faster mode than its cells taken alone, each with an eighth of its
  // mass per corner. With g = sum |area|^2 / volume^2 these are, at most, the squared frequency
  // 8 c^2 g and the damping rate 8 viscous g / rho, which add up; and the rate 64 damping / mass of
  // the hourglass modes, which the others do not touch. Stable is 2 over the frequency or rate.
  const double g = areas / (volume * volume);
  return {
      std::max(sound_speed * std::sqrt(2.0 * g) + 4.0 * viscous * g / rho, 32.0 * damping / mass),
      volume};
}

} // namespace sedov
