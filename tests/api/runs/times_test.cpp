// Tracks at times of their own: every particle at each of them, in every format, wherever the
// solver's steps are, and on the ways that it takes in any case.
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <vector>

#include "coupled.h"
#include "unit/output/netcdf_file.h"

namespace {

/// A flow that turns about z once in 2 pi, in a cube of one cell, whose interpolation is exact for
/// that; the field s is the time, and the field q its square.
class Turning {
public:
  Turning(const std::string& scene, const std::string& output)
      : session({.scene_text = scene, .output = output}), mesh(session.mesh("cube")) {
    mesh.points(x, y, z, 8);
    mesh.hexahedra(cell, 1);
    mesh.vertex_field("velocity", insitu::Array(velocity, 8).components(3));
    mesh.vertex_field("s", insitu::Array(s, 8));
    mesh.vertex_field("q", insitu::Array(q, 8));
    for (int v = 0; v < 8; ++v) {
      velocity[3 * v] = -y[v];
      velocity[3 * v + 1] = x[v];
    }
  }
  /// Steps of 0.1 and 0.25 in turns.
  static double time_of(int cycle) { return 0.35 * (cycle / 2) + 0.1 * (cycle % 2); }
  void step(int cycle) {
    for (int v = 0; v < 8; ++v) {
      s[v] = time_of(cycle);
      q[v] = s[v] * s[v];
    }
    mesh.changed(insitu::fields);
    EXPECT_TRUE(session.execute(cycle, time_of(cycle))) << insitu_last_message();
  }
  void run(int cycles) {
    for (int cycle = 0; cycle <= cycles; ++cycle)
      step(cycle);
    session.close();
  }

  double x[8] = {-1, 1, 1, -1, -1, 1, 1, -1}, y[8] = {-1, -1, 1, 1, -1, -1, 1, 1},
         z[8] = {-1, -1, -1, -1, 1, 1, 1, 1};
  std::int64_t cell[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  double velocity[24] = {}, s[8], q[8];
  insitu::Session session;
  insitu::Mesh mesh;
};

std::string tracer(const std::string& name, const std::string& keys) {
  return "  - {name: " + name + ", velocity: velocity, seeds: [[0.5, 0, 0], [0, -0.3, 0.25]], " +
         "integrator: {tolerance: 1e-9}" + keys + "}\n";
}
const std::string head = "insitu: 1\npage: false\ntracers:\n";

/// The place of one of those seeds after a turn by `time`.
void expect_turned(int particle, double time, double px, double py, double pz) {
  const double c = std::cos(time), sn = std::sin(time);
  const double x = particle == 0 ? 0.5 : 0.0, y = particle == 0 ? 0.0 : -0.3;
  EXPECT_NEAR(px, c * x - sn * y, 1e-7) << time; // 1e-9 a unit of time, and dense output
  EXPECT_NEAR(py, sn * x + c * y, 1e-7) << time;
  EXPECT_NEAR(pz, particle == 0 ? 0.0 : 0.25, 1e-12);
}

// The end, at 3.5, is the 11th step of both lengths; 0.12 times k reaches 3.48.
TEST(Times, RigidRotationAtEachTimeInEveryFormat) {
  const test::Folder folder;
  const std::string fields = ", fields: [s, q], output: [csv, vtp, netcdf]";
  Turning(head + tracer("even", fields + ", times: {interval: 0.12}") +
              tracer("curved", fields + ", times: {interval: 0.12, from: -1, until: 3}" +
                                   ", time_interpolation: quadratic") +
              tracer("listed", fields + ", times: [-3, 0.01, 0.02, 0.35, 1.7, 99]") +
              "  - {name: body, attached: body, seeds: [[0.5, 0, 0], [0, 0, 0]], times: {interval: "
              "0.5}}\n",
          folder.path())
      .run(20);
  const auto check = [&](const std::string& name, const std::vector<double>& times,
                         const std::vector<int>& numbers, bool curved) {
    const runs::Table table = runs::parse_table(test::content(folder / (name + ".csv")));
    ASSERT_EQ(table.rows.size(), 2 * times.size() + 2) << name;
    const test::NetcdfFile file(folder / (name + ".nc"));
    ASSERT_EQ(file.records(), table.rows.size());
    for (std::size_t r = 0; r < 2 * times.size(); ++r) {
      const double t = times[r / 2];
      const int particle = int(r % 2);
      EXPECT_EQ(table.number(r, "time"), t) << name;
      EXPECT_EQ(table.number(r, "particle"), particle);
      EXPECT_EQ(table.text(r, "ending"), "alive");
      EXPECT_EQ(table.number(r, "cell"), 0);
      expect_turned(particle, t, table.number(r, "x"), table.number(r, "y"), table.number(r, "z"));
      EXPECT_NEAR(table.number(r, "s"), t, 1e-12);
      // A straight line misses a parabola by a quarter of the interval's square at most.
      EXPECT_NEAR(table.number(r, "q"), t * t,
                  curved && t > 0.1 ? 1e-12 : 0.25 * 0.25 * 0.25 + 1e-12);
      for (const char* column : {"time", "x", "y", "z", "s", "q"})
        EXPECT_EQ(file[column].doubles[r], table.number(r, column)) << name << " " << column;
      // In the cycle that reaches it.
      const int cycle = int(table.number(r, "cycle"));
      EXPECT_LE(t, Turning::time_of(cycle));
      EXPECT_TRUE(cycle == 0 || t > Turning::time_of(cycle - 1));
    }
    EXPECT_EQ(table.text(table.rows.size() - 1, "ending"), "killed");
    const std::string index = test::content(folder / (name + ".pvd"));
    for (const int number : numbers) {
      char file_name[64];
      std::snprintf(file_name, sizeof file_name, "%s_t%06d.vtp", name.c_str(), number);
      EXPECT_NE(index.find(file_name), std::string::npos) << file_name;
      EXPECT_GT(test::content(folder / file_name).size(), 500u);
    }
    EXPECT_EQ(runs::names_of(runs::files_of(folder.path()), ".vtp").size(), 30u + 25 + 4 + 3);
    const std::string tracks = test::content(folder / (name + "_tracks.vtp"));
    EXPECT_NE(tracks.find("NumberOfPoints=\"" + std::to_string(2 * times.size() + 2) + "\""),
              std::string::npos);
  };
  std::vector<double> even, curved;
  std::vector<int> even_numbers, curved_numbers;
  for (int k = 0; k <= 29; ++k) {
    even.push_back(k * 0.12);
    even_numbers.push_back(k);
  }
  for (int k = 9; - 1 + k * 0.12 <= 3; ++k) {
    curved.push_back(-1 + k * 0.12);
    curved_numbers.push_back(k);
  }
  check("even", even, even_numbers, false);
  check("curved", curved, curved_numbers, true);
  check("listed", {0.01, 0.02, 0.35, 1.7}, {1, 2, 3, 4}, false);
  EXPECT_EQ(runs::parse_table(test::content(folder / "body.csv")).rows.size(), 2u * 8 + 2);
}

// Asking for more times moves no particle: where all are at the end is the same to the bit.
TEST(Times, ThatAreAskedForChangeNoTrack) {
  for (const std::string effect :
       {"", ", effects: [{diffusion: {coefficient: 0.001}}]",
        ", effects: [{inertia: {response_time: 0.1}}, {boundary: reflect}]"}) {
    const test::Folder folder;
    Turning(head + tracer("a", effect + ", every: 3") +
                tracer("b", effect + ", times: {interval: 0.001}") +
                tracer("c", effect + ", every: 3"),
            folder.path())
        .run(9);
    // The walk goes by the tracer's name, so of two names there are two walks.
    const auto ends = [&](const std::string& name) {
      const runs::Table t = runs::parse_table(test::content(folder / (name + ".csv")));
      std::vector<std::string> found;
      for (std::size_t r = t.rows.size() - 2; r < t.rows.size(); ++r)
        for (const char* column : {"time", "particle", "x", "y", "z", "ending"})
          found.push_back(t.text(r, column));
      return found;
    };
    if (effect.find("diffusion") == std::string::npos) {
      EXPECT_EQ(ends("a"), ends("b")) << effect;
    } else {
      const test::Folder other;
      Turning(head + tracer("b", effect + ", every: 3"), other.path()).run(9);
      const auto with = ends("b");
      const runs::Table t = runs::parse_table(test::content(other / "b.csv"));
      EXPECT_EQ(with[2], t.text(t.rows.size() - 2, "x"));
      EXPECT_EQ(with[8], t.text(t.rows.size() - 1, "x"));
    }
  }
}

TEST(Times, TooManyAreRefusedAndTheSolverGoesOn) {
  const test::Folder folder;
  Turning run(head + tracer("a", ", times: {interval: 1e-9}"), folder.path());
  run.step(0);
  EXPECT_FALSE(run.session.execute(1, 0.1));
  EXPECT_NE(std::string(insitu_last_message()).find("at most 1000000"), std::string::npos)
      << insitu_last_message();
}

} // namespace
