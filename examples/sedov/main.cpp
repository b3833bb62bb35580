// The blast wave miniapp, coupled: runs the solver, hands its arrays to libinsitu every cycle, and
// prints at the end where the time went and how far the shock got against the similarity solution.
// On a terminal a line of progress is shown meanwhile; --table prints a line for each cycle. On
// several processes (mpirun -n 4 sedov ...) the first one alone prints, without the progress.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <insitu/insitu.hpp>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <unistd.h>

#include "material.h"
#include "sedov_taylor.h"
#include "solver.h"

namespace {

struct Options {
  sedov::Config config;
  double end = 0.0; // time; 0: when the shock is at 5/6 of the cube's edge
  int cycles = 1'000'000;
  std::string scene, output;
  std::string restart; // a checkpoint of libinsitu
  int from = 0;        // its cycle
  bool block = false;  // couple as an implicit block, not as hexahedra
  int library_threads = 0;
  int material = 0; // points carried by the material, located again every cycle
  bool quiet = false;
  bool table = false;
};

constexpr const char* usage =
    "usage: sedov [options], or mpirun -n PROCESSES sedov [options]\n"
    "  --cells N            cells along each edge of the cube (45)\n"
    "  --end TIME           stop at this time (when the shock is at 5/6 of the cube's edge)\n"
    "  --cycles N           stop after this many cycles\n"
    "  --threads N          threads of the solver (1); the results do not depend on it\n"
    "  --scene FILE         what libinsitu does with the run (nothing)\n"
    "  --output DIR         where it writes, instead of the scene's folder\n"
    "  --restart FILE       libinsitu goes on from a checkpoint that the scene asked for\n"
    "  --from N             which was written in this cycle; the solver, which keeps no state,\n"
    "                       goes through the cycles before once more\n"
    "  --mesh KIND          couple as 'hexahedra' (default) or as an implicit 'block'\n"
    "  --library-threads N  threads of libinsitu (all)\n"
    "  --material N         locate N points that the material carries, every cycle, and say how "
    "far\n"
    "                       the answers are off what is known of them (0)\n"
    "  --table              a line for each cycle: the shock, and where the time goes\n"
    "  --quiet              no line of progress on a terminal either\n";

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
    if (option == "--quiet" || option == "--table") {
      (option == "--quiet" ? options.quiet : options.table) = true;
      --i;
      continue;
    }
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
    else if (option == "--library-threads")
      options.library_threads = whole_number(option, value);
    else if (option == "--material")
      options.material = whole_number(option, value);
    else if (option == "--scene")
      options.scene = value;
    else if (option == "--output")
      options.output = value;
    else if (option == "--restart")
      options.restart = value;
    else if (option == "--from")
      options.from = whole_number(option, value);
    else if (option == "--mesh" &&
             (std::string(value) == "block" || std::string(value) == "hexahedra"))
      options.block = std::string(value) == "block";
    else
      throw std::invalid_argument(option + ": no such option");
  }
  if (options.restart.empty() != (options.from == 0))
    throw std::invalid_argument("--restart and --from: both expected, or none");
  return options;
}

// The coupling: the solver's own arrays of this process's box, once; they keep their place.
insitu::Mesh couple(insitu::Session& session, sedov::Solver& solver, bool block) {
  insitu::Mesh mesh = session.mesh("hydro");
  const sedov::Box& box = solver.box();
  if (solver.cell_count() == 0) // more processes than cells
    return mesh;
  mesh.points(solver.x, solver.y, solver.z);
  if (block)
    mesh.block(box.length(0) + 1, box.length(1) + 1, box.length(2) + 1);
  else
    mesh.hexahedra(solver.connectivity);
  mesh.cell_field("density", solver.density);
  mesh.cell_field("pressure", solver.pressure);
  mesh.cell_field("energy", solver.energy);
  mesh.vertex_field("velocity", {solver.u, solver.v, solver.w});
  mesh.global_ids(insitu::Association::cell, solver.cell_ids);
  mesh.global_ids(insitu::Association::vertex, solver.vertex_ids);
  return mesh;
}

// Where the library says that the material's points are, against where they must be.
class MaterialCheck {
public:
  MaterialCheck(int count, const sedov::Solver& solver)
      : count_(count), points_(static_cast<std::size_t>(count), solver, 1) {}

  void locate(const insitu::Mesh& mesh, const sedov::Solver& solver) {
    points_.move(solver);
    const insitu::Locations found = mesh.locate(points_.positions);
    worst_.join(
        over_all(points_.compare(solver, found.cells, found.parametric), solver.processes()));
    ++times_;
  }
  void print() const {
    std::printf("material: %d points located %d times: %lld lost, %lld in another cell at worst; "
                "(r, s, t) off by at most %.1e, %.1f roundings of a coordinate\n",
                count_, times_, static_cast<long long>(worst_.lost),
                static_cast<long long>(worst_.changed), worst_.largest, worst_.roundings);
  }

private:
  static sedov::Drift over_all(sedov::Drift drift, const sedov::Processes& processes) {
    std::int64_t counts[] = {drift.lost, drift.changed};
    processes.add(counts);
    return {counts[0], counts[1], processes.largest(drift.largest),
            processes.largest(drift.roundings)};
  }

  int count_; // of all processes
  sedov::MaterialPoints points_;
  sedov::Drift worst_;
  int times_ = 0;
};

// What the library spent, in milliseconds.
struct Spent {
  double commit, query, advect, render, output;
  explicit Spent(const insitu::Report& r)
      : commit(1e3 * r.commit_s), query(1e3 * r.query_s), advect(1e3 * r.advect_s),
        render(1e3 * r.render_s), output(1e3 * r.output_s) {}
  double sum() const { return commit + query + advect + render + output; }
};

void print_summary(const insitu::Report& r, double solver_seconds) {
  const Spent spent(r);
  std::printf(
      "library %.2f s of %.2f s (%.1f %%): commit %.2f, query %.2f, advect %.2f, render %.2f, "
      "output %.2f s\n",
      1e-3 * spent.sum(), 1e-3 * spent.sum() + solver_seconds,
      100.0 * spent.sum() / (spent.sum() + 1e3 * solver_seconds), r.commit_s, r.query_s, r.advect_s,
      r.render_s, r.output_s);
  std::printf("bytes: %.1f MB of the solver's read in place, %.1f MB held (%.1f MB at the peak)\n",
              1e-6 * double(r.bytes_borrowed), 1e-6 * double(r.bytes_held),
              1e-6 * double(r.bytes_peak));
  std::printf("commits: %lld kept, %lld refitted, %lld rebuilt\n", static_cast<long long>(r.keeps),
              static_cast<long long>(r.refits), static_cast<long long>(r.rebuilds));
  const auto located = [&](insitu_reason reason) {
    return static_cast<long long>(r.located_by_reason[reason]);
  };
  std::printf(
      "located: %lld certified inside, %lld inside by exact arithmetic, %lld on faces, %lld on "
      "edges, %lld on vertices, %lld outside\n",
      located(INSITU_REASON_CERTIFIED), located(INSITU_REASON_EXACT),
      located(INSITU_REASON_ON_FACE), located(INSITU_REASON_ON_EDGE),
      located(INSITU_REASON_ON_VERTEX), located(INSITU_REASON_OUTSIDE));
  if (r.particles_seeded > 0)
    std::printf(
        "particles: %lld seeded = %lld alive + %lld left + %lld stagnated + %lld expired + "
        "%lld at the step limit + %lld seeded outside + %lld not finite + %lld killed + %lld "
        "stopped + %lld removed + %lld whose step was too small + %lld before a hole, a hidden, a "
        "ghost or a blank cell\n",
        static_cast<long long>(r.particles_seeded),
        static_cast<long long>(r.particles[INSITU_END_ALIVE]),
        static_cast<long long>(r.particles[INSITU_END_LEFT]),
        static_cast<long long>(r.particles[INSITU_END_STAGNATED]),
        static_cast<long long>(r.particles[INSITU_END_EXPIRED]),
        static_cast<long long>(r.particles[INSITU_END_STEP_LIMIT]),
        static_cast<long long>(r.particles[INSITU_END_SEED_OUTSIDE]),
        static_cast<long long>(r.particles[INSITU_END_NOT_FINITE]),
        static_cast<long long>(r.particles[INSITU_END_KILLED]),
        static_cast<long long>(r.particles[INSITU_END_STOPPED]),
        static_cast<long long>(r.particles[INSITU_END_REMOVED]),
        static_cast<long long>(r.particles[INSITU_END_STEP_TOO_SMALL]),
        static_cast<long long>(r.particles[INSITU_END_HOLE] + r.particles[INSITU_END_HIDDEN] +
                               r.particles[INSITU_END_PARTITION] + r.particles[INSITU_END_BLANK]));
  std::printf("%lld frames, %lld probe rows, %lld files, %lld failures\n",
              static_cast<long long>(r.frames), static_cast<long long>(r.probe_rows),
              static_cast<long long>(r.files), static_cast<long long>(r.failures));
}

void run(const Options& options, const sedov::Processes& processes) {
  using Clock = std::chrono::steady_clock;
  const sedov::Config& config = options.config;
  const sedov::SedovTaylor exact(config.gamma, config.energy, config.density);
  const double end = options.end > 0.0 ? options.end : exact.shock_time(config.length * 5.0 / 6.0);

  sedov::Solver solver(config, processes);
  insitu::Options session_options;
  session_options.scene = options.scene;
  session_options.output = options.output;
  session_options.threads = options.library_threads;
  session_options.communicator = processes.communicator();
  insitu::Session session(session_options);
  insitu::Mesh mesh = couple(session, solver, options.block);
  const double energy = solver.total_energy();
  std::chrono::duration<double> elapsed{};
  if (options.restart.empty()) {
    session.execute(0, 0.0);
  } else {
    while (solver.cycle() < options.from)
      solver.advance(end - solver.time());
    session.restart(options.restart);
  }
  std::optional<MaterialCheck> material;
  if (options.material > 0) {
    material.emplace(options.material, solver);
    material->locate(mesh, solver);
  }
  Spent before(session.report());
  const bool is_root = processes.is_root();
  // On several processes it is mpirun that has the terminal, or none, and does not tell.
  const bool progress =
      processes.size() == 1 && !options.quiet && !options.table && isatty(STDOUT_FILENO) == 1;
  if (options.table && is_root)
    std::printf("%6s %11s %8s %9s %10s | %8s %8s %8s %8s\n", "cycle", "time", "shock", "drift",
                "solver ms", "commit", "query", "advect", "render");
  while (solver.time() < end && solver.cycle() < options.cycles) {
    const Clock::time_point begin = Clock::now();
    solver.advance(end - solver.time());
    const std::chrono::duration<double> step = Clock::now() - begin;
    elapsed += step;
    mesh.changed(insitu::geometry | insitu::fields);
    session.execute(solver.cycle(), solver.time());
    if (material)
      material->locate(mesh, solver);
    if (progress) {
      std::printf("\rcycle %d, time %.4e of %.4e ", solver.cycle(), solver.time(), end);
      std::fflush(stdout);
    }
    if (!options.table)
      continue;
    const Spent now(session.report());
    const double shock = solver.shock_radius(), drift = solver.total_energy() / energy - 1.0;
    if (is_root)
      std::printf("%6d %11.5e %8.5f %9.1e %10.2f | %8.2f %8.2f %8.2f %8.2f\n", solver.cycle(),
                  solver.time(), shock, drift, 1e3 * step.count(), now.commit - before.commit,
                  now.query - before.query, now.advect - before.advect, now.render - before.render);
    before = now;
  }
  if (progress)
    std::printf("\r%50s\r", "");
  const double shock = solver.shock_radius(), drift = solver.total_energy() / energy - 1.0;
  if (is_root) {
    std::printf("%d cycles, %.2f s in the solver, %.2f ms a cycle; energy drift %.1e\n",
                solver.cycle(), elapsed.count(), 1e3 * elapsed.count() / solver.cycle(), drift);
    std::printf("shock radius %.5f, similarity solution %.5f\n", shock,
                exact.shock_radius(solver.time()));
    print_summary(session.report(), elapsed.count());
    if (material)
      material->print();
  }
  if (!options.output.empty())
    session.write_summary(options.output + "/summary.json", elapsed.count());
}

} // namespace

int main(int argc, char** argv) {
#ifdef SEDOV_HAVE_MPI
  const auto processes = sedov::launched_processes(argc, argv);
#else
  const auto processes = std::make_unique<sedov::Processes>();
#endif
  for (int i = 1; i < argc; ++i)
    if (std::string(argv[i]) == "--help") {
      if (processes->is_root())
        std::fputs(usage, stdout);
      return EXIT_SUCCESS;
    }
  try {
    run(parse(argc, argv), *processes);
  } catch (const std::invalid_argument& error) { // all processes throw it
    if (processes->is_root())
      std::fprintf(stderr, "sedov: %s\n%s", error.what(), usage);
    return EXIT_FAILURE;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sedov: %s\n", error.what());
    processes->abort(); // others may wait for this one
  }
  return EXIT_SUCCESS;
}
