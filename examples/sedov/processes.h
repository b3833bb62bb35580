// The processes among which the cube's cells are dealt out. The solver asks for no more than this
// of them: the largest of a number each, exact sums, and messages to neighbours.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace sedov {

// What goes to a neighbour, and what comes back; the sizes are set beforehand.
struct Message {
  int process;
  std::vector<double> out, in;
};

// A program on its own: one process. MPI's are derived from it in mpi_processes.cpp.
class Processes {
public:
  Processes() = default;
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;
  virtual ~Processes() = default;

  virtual int rank() const { return 0; }
  virtual int size() const { return 1; }
  bool is_root() const { return rank() == 0; }

  // All processes call these three alike.
  virtual double largest(double of_mine) const { return of_mine; }
  virtual void add(std::span<std::int64_t>) const {} // each entry becomes its sum
  virtual void exchange(std::span<Message>) const {}

  // Ends all processes; for errors that one of them finds alone.
  [[noreturn]] virtual void abort() const { std::exit(EXIT_FAILURE); }

  // Address of the MPI_Comm; null if there is none.
  virtual const void* communicator() const { return nullptr; }

  // The sum of term(i), i < count, over all processes: the same to the bit however the terms are
  // dealt out.
  template <typename Term>
  double sum(std::size_t count, const Term& term) const;
};

#ifdef SEDOV_HAVE_MPI
// Those that a launcher such as mpirun has started; a process that no launcher started is alone,
// and MPI is left out of it. MPI is finalised at the end of the object's life.
std::unique_ptr<Processes> launched_processes(int& argc, char**& argv);
#endif

// ------------------------------------------------------------------------------------------------

// Each term becomes a whole multiple of a coarse unit and one of a fine unit for the rest, 2^30 at
// most both. Sums of fewer than 2^33 whole numbers are exact, so their order does not matter.
template <typename Term>
double Processes::sum(std::size_t count, const Term& term) const {
  double bound = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double size = std::fabs(term(i));
    bound = std::isfinite(size) ? std::max(bound, size) : std::numeric_limits<double>::infinity();
  }
  bound = largest(bound);
  if (bound == 0.0 || !std::isfinite(bound))
    return bound;
  const double coarse = std::ldexp(1.0, std::ilogb(bound) - 29), fine = std::ldexp(coarse, -31);
  std::int64_t sums[2] = {0, 0};
  for (std::size_t i = 0; i < count; ++i) {
    const double value = term(i), multiple = std::nearbyint(value / coarse);
    sums[0] += static_cast<std::int64_t>(multiple);
    sums[1] += static_cast<std::int64_t>(std::nearbyint((value - multiple * coarse) / fine));
  }
  add(sums);
  return static_cast<double>(sums[0]) * coarse + static_cast<double>(sums[1]) * fine;
}

} // namespace sedov
