// The blast wave miniapp: runs the solver, prints a line per cycle and, at the end, how far the
// shock got against the similarity solution.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>

#include "sedov_taylor.h"
#include "solver.h"

namespace {

struct Options {
  sedov::Config config;
  double end = 0.0; // time; 0: when the shock is at 5/6 of the cube's edge
  int cycles = 1'000'000;
};

constexpr const char* usage =
    "usage: sedov [--cells N] [--end TIME] [--cycles N] [--threads N]\n"
    "  --cells N    cells along each edge of the cube (45)\n"
    "  --end TIME   stop at this time (when the shock is at 5/6 of the cube's edge)\n"
    "  --cycles N   stop after this many cycles\n"
    "  --threads N  threads of the solver (1); the results do not depend on it\n";

double number(const std::string& option, const char* text) {
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  if (end == text || *end != '\0')
    throw std::invalid_argument(option + ": a number expected, '" + text + "' given");
  return value;
}

int whole_number(const std::string& option, const char* text) {
  const double value = number(option, text);
  if (!(value >= 1.0 && value <= 1e9) || value != static_cast<int>(value))
    throw std::invalid_argument(option + ": a whole number of at least 1 expected, '" + text +
                                "' given");
  return static_cast<int>(value);
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string option = argv[i];
    if (i + 1 == argc)
      throw std::invalid_argument(option + ": no such option, or its value is missing");
    const char* const value = argv[i + 1];
    if (option == "--cells")
      options.config.cells.fill(whole_number(option, value));
    else if (option == "--end")
      options.end = number(option, value);
    else if (option == "--cycles")
      options.cycles = whole_number(option, value);
    else if (option == "--threads")
      options.config.threads = whole_number(option, value);
    else
      throw std::invalid_argument(option + ": no such option");
  }
  return options;
}

void run(const Options& options) {
  using Clock = std::chrono::steady_clock;
  const sedov::Config& config = options.config;
  const sedov::SedovTaylor exact(config.gamma, config.energy, config.density);
  const double end = options.end > 0.0 ? options.end : exact.shock_time(config.length * 5.0 / 6.0);

  sedov::Solver solver(config);
  const double energy = solver.total_energy();
  std::chrono::duration<double> elapsed{};
  std::printf("%6s %12s %12s %8s %12s %12s %10s\n", "cycle", "time", "timestep", "shock",
              "internal", "kinetic", "drift");
  while (solver.time() < end && solver.cycle() < options.cycles) {
    const Clock::time_point begin = Clock::now();
    const double dt = solver.advance(end - solver.time());
    elapsed += Clock::now() - begin;
    std::printf("%6d %12.6e %12.6e %8.5f %12.6e %12.6e %10.2e\n", solver.cycle(), solver.time(), dt,
                solver.shock_radius(), solver.internal_energy(), solver.kinetic_energy(),
                solver.total_energy() / energy - 1.0);
  }
  std::printf("%d cycles, %.2f s in the solver, %.2f ms a cycle\n", solver.cycle(), elapsed.count(),
              1e3 * elapsed.count() / solver.cycle());
  std::printf("shock radius %.5f, similarity solution %.5f\n", solver.shock_radius(),
              exact.shock_radius(solver.time()));
}

} // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (std::string(argv[i]) == "--help") {
      std::fputs(usage, stdout);
      return EXIT_SUCCESS;
    }
  try {
    run(parse(argc, argv));
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "sedov: %s\n%s", error.what(), usage);
    return EXIT_FAILURE;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
