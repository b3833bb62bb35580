// Every effect of path-, streak- and streamlines on every kind of mesh: a uniform flow in the unit
// cube, in which each has a closed form whatever the cells.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <numeric>

#include "coupled.h"
#include "cubes.h"

namespace {

using runs::Cells;
using runs::Point;
using runs::speed;
using runs::Table;

constexpr double dt = 0.5;
constexpr int cycles = 10;
const Point seeds[2] = {{0.31, 0.47, 0.53}, {0.72, 0.28, 0.61}};

struct Expected {
  Point x;
  bool ended = false;
};
struct Effect {
  const char* name;
  const char* effects;
  const char* ending; ///< of those that the closed form says have ended
  std::function<Expected(const Point& seed, double age)> place;
  bool of_lines;         ///< streamlines have it, too
  const char* keys = ""; ///< of the tracer
};

Expected carried(const Point& from, const Point& by, double age) {
  const double at_side = (1 - from[0]) / by[0], a = std::min(age, at_side);
  return {{from[0] + a * by[0], from[1] + a * by[1], from[2] + a * by[2]}, age >= at_side};
}

const std::vector<Effect>& all_effects() {
  static const std::vector<Effect> effects{
      {"settles", "{settling: {speed: 0.05}}", "left",
       [](const Point& p, double a) {
         return carried(p, {speed, 0, -0.05}, a);
       },
       true},
      {"sinks", "{settling: {speed: sinking, down: [0, -1, 0]}}", "left",
       [](const Point& p, double a) {
         return carried(p, {speed, -0.03, 0}, a);
       },
       true},
      {"blown", "{windage: {field: wind, factor: 0.5}}", "left",
       [](const Point& p, double a) {
         return carried(p, {speed, 0.05, 0}, a);
       },
       true},
      {"stops", "{boundary: stop}", "stopped",
       [](const Point& p, double a) {
         return carried(p, {speed, 0, 0}, a);
       },
       true},
      {"slides", "{boundary: slide}, {settling: {speed: 0.4}}", "stagnated",
       [](const Point& p, double a) {
         return Expected{{std::min(1.0, p[0] + speed * a), p[1], std::max(0.0, p[2] - 0.4 * a)}};
       },
       true},
      {"round", "{boundary: {periodic: [x]}}", "expired",
       [](const Point& p, double a) {
         return Expected{{std::fmod(p[0] + speed * a, 1.0), p[1], p[2]}};
       },
       true},
      {"drags", "{inertia: {response_time: 0.5, velocity: [0, 0, 0]}}, {boundary: slide}",
       "expired",
       [](const Point& p, double a) {
         const double way = speed * (a - 0.5 * (1 - std::exp(-2 * a)));
         return Expected{{std::min(1.0, p[0] + way), p[1], p[2]}};
       },
       true},
      {"turns", "{inertia: {velocity: [0.1, 0, 0]}}, {coriolis: {rotation: [0, 0, 1]}}", "expired",
       [](const Point& p, double a) {
         return Expected{
             {p[0] + 0.05 * std::sin(2 * a), p[1] - 0.05 * (1 - std::cos(2 * a)), p[2]}};
       },
       true},
      {"bounces", "{inertia: {velocity: [0.4, 0, 0]}}, {boundary: reflect}", "expired",
       [](const Point& p, double a) {
         const double way = std::fmod(p[0] + 0.4 * a, 2.0);
         return Expected{{way > 1 ? 2 - way : way, p[1], p[2]}};
       },
       true},
      {"undone", "{boundary: put_back}", "",
       [](const Point& p, double a) { // moves by 0.1 a cycle, as long as there is room
         const double moves = std::floor((1 - p[0]) / (speed * dt));
         return Expected{{p[0] + speed * dt * std::min(moves, std::round(a / dt)), p[1], p[2]}};
       },
       false},
      {"ages", "{age_limit: 0.75}", "expired",
       [](const Point& p, double a) {
         return Expected{{p[0] + speed * std::min(a, 0.75), p[1], p[2]}, a >= 0.75};
       },
       true},
  };
  return effects;
}

/// The tracers of the effects as one kind of line; streamlines end at the age of the run.
std::string tracers(const std::string& kind) {
  std::string text;
  const bool lines = kind == "streamline";
  for (const Effect& e : all_effects())
    if (!lines || e.of_lines)
      text += "  - {name: " + kind + "_" + e.name + ", kind: " + kind +
              ", velocity: velocity, seeds: [[0.31, 0.47, 0.53], [0.72, 0.28, 0.61]], effects: [" +
              e.effects + "]" + (lines ? ", every: 10, until: {duration: 5}" : "") + "}\n";
  return text;
}

const std::string& scene() {
  static const std::string text = "insitu: 1\npage: false\nevery: 1\ntracers:\n" +
                                  tracers("pathline") + tracers("streakline") +
                                  tracers("streamline") + R"(
  - &gone {name: gone, velocity: velocity, seeds: [[0.31, 0.47, 0.53], [0.72, 0.28, 0.61]], effects: [{remove: {when: salt > 0.85}}]}
  - {name: gone_streaks, kind: streakline, velocity: velocity, seeds: [[0.31, 0.47, 0.53]], effects: [{remove: {when: salt > 0.85}}]}
  - {name: gone_lines, kind: streamline, every: 10, velocity: velocity, seeds: [[0.31, 0.47, 0.53]], effects: [{remove: {when: salt > 0.85}}]}
  - {name: walks, velocity: rest, seeds: {box: {min: [0.3, 0.3, 0.3], max: [0.7, 0.7, 0.7], counts: [8, 8, 8]}},
     effects: [{diffusion: {horizontal: 0.0005, vertical: spread}}]}
)";
  return text;
}

runs::Files run(const Cells& cells, int threads) {
  const test::Folder folder;
  insitu::Options options;
  options.scene_text = scene();
  options.output = folder.path();
  options.threads = threads;
  options.log_level = insitu::LogLevel::error; // cells inside out are among them
  {
    insitu::Session session(options);
    insitu::Mesh mesh = session.mesh("cube");
    for (int cycle = 0; cycle <= cycles; ++cycle) {
      cells.give(mesh, cycle);
      EXPECT_TRUE(session.execute(cycle, dt * cycle)) << insitu_last_message();
      const insitu::Report r = session.report();
      EXPECT_EQ(std::accumulate(std::begin(r.particles), std::end(r.particles), std::int64_t(0)),
                r.particles_seeded);
      EXPECT_EQ(r.particles[INSITU_END_NOT_FINITE] + r.particles[INSITU_END_STEP_LIMIT] +
                    r.particles[INSITU_END_SEED_OUTSIDE],
                0);
    }
  }
  return runs::files_of(folder.path());
}

/// A row's place and ending against the closed form.
void expect_place(const Table& t, std::size_t row, const Effect& e, const Point& seed, double age) {
  const Expected want = e.place(seed, age);
  const char* const axes[3] = {"x", "y", "z"};
  for (std::size_t a = 0; a < 3; ++a) {
    double off = t.number(row, axes[a]) - want.x[a];
    if (std::string(e.name) == "round" && a == 0)
      off = std::remainder(off, 1.0);
    // dopri5 at 1e-6 a unit of time; the flight over five.
    EXPECT_NEAR(off, 0.0, 1e-5) << e.name << ", row " << row << ", age " << age << ", " << axes[a];
  }
}

/// All tables of the effects that have one.
void expect_closed_forms(const runs::Files& files, bool moves) {
  for (const Effect& e : all_effects()) {
    if (moves && e.name == std::string("undone"))
      continue; // what is put back goes with the material there: PutBack tests
    for (const char* kind : {"pathline", "streakline"}) {
      const Table t = runs::parse_table(files.at(std::string(kind) + "_" + e.name + ".csv"));
      const int released = kind == std::string("pathline") ? 1 : cycles + 1;
      std::map<int, std::string> last;
      for (std::size_t i = 0; i < t.rows.size(); ++i) {
        const int particle = int(t.number(i, "particle"));
        const std::string& ending = last[particle] = t.text(i, "ending");
        const double age = t.number(i, "time") - dt * (particle / 2);
        expect_place(t, i, e, seeds[particle % 2], age);
        if (ending != "killed" && ending != "alive") {
          EXPECT_EQ(ending, e.ending) << kind << e.name;
        }
        const bool ends = e.place(seeds[particle % 2], age + 1e-6).ended;
        EXPECT_EQ(ending == e.ending, ends) << kind << e.name << age;
      }
      EXPECT_EQ(last.size(), std::size_t(2 * released)) << kind << e.name;
    }
    if (!e.of_lines)
      continue;
    const Table t =
        runs::parse_table(files.at("streamline_" + std::string(e.name) + "_000010.csv"));
    ASSERT_GE(t.rows.size(), 4u);
    for (std::size_t i = 0; i < t.rows.size(); ++i) {
      expect_place(t, i, e, seeds[int(t.number(i, "line"))], t.number(i, "s"));
      EXPECT_EQ(t.text(i, "ending"), e.ending) << e.name;
    }
  }
}

void expect_removed_and_walked(const runs::Files& files, bool by_cells) {
  const Table gone = runs::parse_table(files.at("gone.csv")),
              streaks = runs::parse_table(files.at("gone_streaks.csv")),
              lines = runs::parse_table(files.at("gone_lines_000010.csv"));
  std::map<int, std::size_t> last, last_of_streaks;
  for (std::size_t i = 0; i < gone.rows.size(); ++i)
    last[int(gone.number(i, "particle"))] = i;
  for (std::size_t i = 0; i < streaks.rows.size(); ++i)
    last_of_streaks[int(streaks.number(i, "particle"))] = i;
  for (const auto& [particle, row] : last) {
    EXPECT_EQ(gone.text(row, "ending"), "removed");
    if (!by_cells) {
      EXPECT_NEAR(gone.number(row, "x"), particle ? 0.92 : 0.91, 1e-9);
    }
  }
  int removed = 0;
  for (const auto& [particle, row] : last_of_streaks)
    removed += streaks.text(row, "ending") == "removed";
  EXPECT_GE(removed, 5);
  EXPECT_EQ(lines.text(0, "ending"), "removed");
  if (!by_cells) {
    EXPECT_NEAR(lines.number(lines.rows.size() - 1, "x"), 0.85, 1e-6);
  }

  const Table walks = runs::parse_table(files.at("walks.csv"));
  std::map<int, std::size_t> first;
  double squares[3] = {}, particles = 0;
  for (std::size_t i = 0; i < walks.rows.size(); ++i) {
    const auto from = first.try_emplace(int(walks.number(i, "particle")), i).first->second;
    if (walks.text(i, "ending") != "killed")
      continue;
    ++particles;
    const char* const axes[3] = {"x", "y", "z"};
    for (int a = 0; a < 3; ++a)
      squares[a] += std::pow(walks.number(i, axes[a]) - walks.number(from, axes[a]), 2);
  }
  EXPECT_EQ(particles, 512) << "none is lost at reflecting walls";
  // 2 K t; of 512 squares the mean scatters by sqrt(2 / 512) of it.
  for (const double sum : squares)
    EXPECT_NEAR(sum / particles, 2 * 0.0005 * 5, 0.25 * 2 * 0.0005 * 5);
}

TEST(EffectsOnMeshes, AreTheClosedFormsForEveryKindOfLineAndCell) {
  for (const Cells& cells : runs::all_cells(cycles)) {
    SCOPED_TRACE(cells.name);
    const runs::Files files = run(cells, 1);
    expect_closed_forms(files, cells.moves);
    expect_removed_and_walked(files, cells.by_cells);
  }
}

TEST(EffectsOnMeshes, AreTheSameForAnyThreads) {
  for (const std::size_t which : {0, 5, 8, 9, 10}) {
    std::vector<Cells> one = runs::all_cells(cycles), three = runs::all_cells(cycles);
    SCOPED_TRACE(one[which].name);
    EXPECT_EQ(runs::differences(run(one[which], 1), run(three[which], 3)),
              std::vector<std::string>{});
  }
}

} // namespace
