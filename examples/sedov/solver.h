// A point blast in an ideal gas, by three-dimensional Lagrangian hydrodynamics: the mesh moves with
// the material. Positions and velocities live at the vertices, density, energy and pressure in
// the cells.
//
// Discretisation: compatible corner forces (E. J. Caramana, D. E. Burton, M. J. Shashkov and
// P. P. Whalen, J. Comput. Phys. 146, 227-262, 1998), which conserve momentum and total energy to
// rounding; pressure forces from the exact gradient of each hexahedron's volume; a tensor
// artificial viscosity on the symmetric mean velocity gradient (after V. A. Dobrev,
// Tz. V. Kolev and R. N. Rieben, SIAM J. Sci. Comput. 34, B606-B641, 2012); viscous hourglass
// control (D. P. Flanagan and T. Belytschko, Int. J. Numer. Methods Eng. 17, 679-706, 1981); a
// predictor to the half step and a corrector from it.
//
// On several processes each has a box of the cells and all vertices of these. What the corners of
// neighbours' cells do at shared vertices is sent as such, and every process adds the forces at a
// vertex in the order of all cells' ids: so all results are the same to the bit on any number of
// processes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "box.h"
#include "processes.h"

namespace sedov {

enum class Boundary {
  free, // nothing outside: the surface moves as the material pushes it
  wall, // rigid and smooth
};

struct Config {
  Triple cells{45, 45, 45};
  double length = 1.2;             // edge of the cube; the blast is at its corner in the origin
  double gamma = 1.4;              // ratio of specific heats
  double density = 1.0;            // at rest, uniform
  double energy = 1.0;             // of the blast in all of space; this octant gets an eighth
  double deposit = 1.5;            // its width at time zero: exp(-(r / width)^2), in cells
  Boundary outer = Boundary::free; // x, y, z = length; x, y, z = 0 are always symmetry planes
  double cfl = 0.45;               // of the stability limit of the cell, 0 < cfl < 1
  double linear_viscosity = 0.25;
  double quadratic_viscosity = 1.0;
  double hourglass = 0.1;
  int threads = 1; // the results do not depend on it
};

class Solver {
public:
  // Throws std::invalid_argument for a size, count or material constant out of range. The processes
  // must live as long as the solver; all of them make it, and call the functions that are said to
  // be of all.
  explicit Solver(const Config& config, const Processes& processes = alone());

  // Of all processes. One cycle, by the stable timestep or limit if that is less; returns the
  // timestep. Throws std::runtime_error when a cell's volume is no longer positive, on the process
  // that has the cell; the run cannot go on then.
  double advance(double limit = std::numeric_limits<double>::infinity());

  // Of all processes. Brings density, pressure, viscosity, forces and stable timestep up to the
  // positions, velocities and energies. To be called after changing those by hand (advance does it
  // itself); cells cold and at rest are left as they are.
  void update();

  const Config& config() const { return config_; }
  const Processes& processes() const { return processes_; }
  const Box& box() const { return box_; } // of this process
  std::size_t vertex_count() const { return x.size(); }
  std::size_t cell_count() const { return energy.size(); }
  double time() const { return time_; }
  int cycle() const { return cycle_; }

  // Of all processes, over the whole cube.
  double internal_energy() const;
  double kinetic_energy() const;
  double total_energy() const { return internal_energy() + kinetic_energy(); }

  // Of all processes. Distance of the shock from the origin: of the cell centres, weighted by what
  // the viscosity (which is the shock's own) holds of pressure times volume. Zero while there is
  // none.
  double shock_radius() const;

  // The state in this process's box. The arrays keep their place for the solver's whole life. In a
  // box of nx, ny, nz cells its vertex (i, j, k) has the number i + (nx + 1) * (j + (ny + 1) * k),
  // its cell (i, j, k) the number i + nx * (j + ny * k).
  std::vector<double> x, y, z;            // positions of the vertices
  std::vector<double> u, v, w;            // velocities of the vertices
  std::vector<double> energy;             // per mass, of the cells
  std::vector<double> density, pressure;  // of the cells
  std::vector<double> viscosity;          // of the cells: viscous pressure along the compression
  std::vector<std::int32_t> connectivity; // eight vertices a cell, in VTK's order
  // The numbers that vertices and cells have in the box of all cells.
  std::vector<std::int64_t> vertex_ids, cell_ids;

private:
  struct State { // what a force evaluation reads
    const std::vector<double>&x, &y, &z, &u, &v, &w, &energy;
  };
  struct CellResult {
    double rate; // reciprocal of the stable timestep
    double volume;
  };

  // A process with cells at this one's vertices. It gets the forces of those corners of cells here
  // that lie at its own vertices, and sends those of its own, which go behind this box's.
  struct Neighbour {
    std::vector<std::size_t> sent; // entries of the forces
    std::size_t first_received, received;
  };

  static const Processes& alone();
  void build_mesh();
  void find_corners();
  void deposit_energy();
  void evaluate(const State& state); // corner forces, cell arrays, stable_timestep_
  CellResult evaluate_cell(const State& state, std::size_t cell);
  void exchange_forces();
  void accelerate(double dt, std::vector<double>& u_to, std::vector<double>& v_to,
                  std::vector<double>& w_to) const;
  void heat(double dt, const std::vector<double>& u_mean, const std::vector<double>& v_mean,
            const std::vector<double>& w_mean, std::vector<double>& energy_to) const;

  Config config_;
  const Processes& processes_;
  Box box_;
  double time_ = 0.0, timestep_ = 0.0, stable_timestep_ = 0.0;
  int cycle_ = 0;
  double cell_mass_ = 0.0; // of each
  std::vector<double> vertex_mass_;
  std::vector<std::uint8_t> fixed_; // bit d: no motion along axis d
  // Of each vertex: entries of the forces, in the order of all cells' ids.
  std::vector<std::int32_t> corner_begin_, corners_;
  // One per corner of a cell, at 8 * cell + corner; then those of neighbours.
  std::vector<double> force_x_, force_y_, force_z_;
  std::vector<Neighbour> neighbours_;
  std::vector<Message> messages_; // one per neighbour
  std::vector<double> half_x_, half_y_, half_z_, half_u_, half_v_, half_w_, half_energy_;
};

} // namespace sedov
