// The blast on several processes (mpirun -n 3 sedov_processes_test): every number that a process
// has is the one of a run on one process, to the bit. Each process makes that run too, and
// compares.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>

#include "solver.h"

namespace {

using sedov::Config;
using sedov::Processes;
using sedov::Solver;

std::int64_t wrong = 0;

void expect(bool holds, const Processes& processes, const std::string& what) {
  if (holds)
    return;
  ++wrong;
  std::fprintf(stderr, "process %d of %d: %s\n", processes.rank(), processes.size(), what.c_str());
}

// here: of the process's box; there: of the whole cube, at the ids.
template <typename T>
void expect_same(const std::vector<T>& here, const std::vector<T>& there,
                 const std::vector<std::int64_t>& ids, const Processes& processes,
                 const std::string& what) {
  expect(here.size() == ids.size(), processes, what + " has another size");
  for (std::size_t i = 0; i < here.size(); ++i)
    if (std::memcmp(&here[i], &there[static_cast<std::size_t>(ids[i])], sizeof(T)) != 0) {
      expect(false, processes, what + " differs at id " + std::to_string(ids[i]));
      return;
    }
}

void compare(const Solver& part, const Solver& whole, const std::string& name) {
  const Processes& processes = part.processes();
  const auto of_vertices = [&](std::vector<double> Solver::*array, const char* what) {
    expect_same(part.*array, whole.*array, part.vertex_ids, processes, name + what);
  };
  const auto of_cells = [&](std::vector<double> Solver::*array, const char* what) {
    expect_same(part.*array, whole.*array, part.cell_ids, processes, name + what);
  };
  of_vertices(&Solver::x, "x");
  of_vertices(&Solver::y, "y");
  of_vertices(&Solver::z, "z");
  of_vertices(&Solver::u, "u");
  of_vertices(&Solver::v, "v");
  of_vertices(&Solver::w, "w");
  of_cells(&Solver::energy, "energy");
  of_cells(&Solver::density, "density");
  of_cells(&Solver::pressure, "pressure");
  of_cells(&Solver::viscosity, "viscosity");
  for (std::size_t i = 0; i < part.connectivity.size(); ++i) {
    const auto here = static_cast<std::size_t>(part.connectivity[i]);
    const std::size_t there = 8 * static_cast<std::size_t>(part.cell_ids[i / 8]) + i % 8;
    expect(part.vertex_ids[here] == whole.connectivity[there], processes, name + "connectivity");
  }
  expect(part.internal_energy() == whole.internal_energy(), processes, name + "internal energy");
  expect(part.kinetic_energy() == whole.kinetic_energy(), processes, name + "kinetic energy");
  expect(part.shock_radius() == whole.shock_radius(), processes, name + "shock radius");
}

void run(const Processes& processes, const Config& config, int cycles, const std::string& name) {
  Solver part(config, processes), whole(config);
  compare(part, whole, name + " at the start: ");
  for (int i = 0; i < cycles; ++i)
    expect(part.advance() == whole.advance(), processes, name + ": a timestep");
  compare(part, whole, name + " at the end: ");
  std::int64_t cells[] = {static_cast<std::int64_t>(part.cell_count())};
  processes.add(cells);
  expect(cells[0] == static_cast<std::int64_t>(whole.cell_count()), processes,
         name + ": cells are lost or twice there");
}

// Numbers of very different sizes, whose sums in doubles depend on the order.
void sum_exactly(const Processes& processes) {
  const std::size_t count = 1001;
  const auto term = [](std::size_t i) {
    return std::ldexp(i % 2 ? 1.0 : -1.0, static_cast<int>(i % 40)) / static_cast<double>(i + 3);
  };
  const std::size_t rank = static_cast<std::size_t>(processes.rank()),
                    size = static_cast<std::size_t>(processes.size());
  const std::size_t mine = (count - rank + size - 1) / size;
  const double dealt = processes.sum(mine, [&](std::size_t i) { return term(rank + i * size); });
  const double whole = Processes().sum(count, term);
  long double exact = 0.0L;
  for (std::size_t i = 0; i < count; ++i)
    exact += term(i);
  expect(dealt == whole, processes, "a sum depends on how its terms are dealt out");
  expect(std::fabs(whole - static_cast<double>(exact)) <= 1e-15 * std::fabs(whole), processes,
         "a sum is off by more than a few roundings");
}

} // namespace

int main(int argc, char** argv) {
  const auto processes = sedov::launched_processes(argc, argv);
  sum_exactly(*processes);
  Config cube; // boxes that meet at edges and corners, the shock across all of them
  cube.cells = {7, 6, 9};
  run(*processes, cube, 60, "cube");
  Config few; // fewer than processes, of which some have none
  few.cells = {1, 2, 1};
  few.outer = sedov::Boundary::wall;
  run(*processes, few, 30, "few cells");
  processes->add({&wrong, 1});
  return wrong == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
