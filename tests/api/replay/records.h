// Runs that are recorded, for tests of their records.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>

#include "insitu/insitu.hpp"

#include "arrays.h"
#include "fixtures/hexahedra.h"
#include "held.h"

namespace records {

/// A lattice of n^3 cubes of side 1/n, shifted along x.
struct Lattice {
  explicit Lattice(int cells, double shift = 0.0, double bend = 0.0)
      : n(cells), ids(insitu::fixtures::lattice_hexahedra(cells)) {
    for (int k = 0; k <= n; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
          const double x = double(i) / n + shift, y = double(j) / n, z = double(k) / n;
          points.insert(points.end(), {x + bend * y * z, y + bend * x * z, z});
        }
  }
  std::vector<double> field(double time) const {
    std::vector<double> out;
    for (std::size_t i = 0; i < points.size(); i += 3)
      out.push_back(std::sin(3 * points[i] + time) + points[i + 1] * points[i + 2]);
    return out;
  }
  std::vector<double> velocity(double time) const {
    std::vector<double> out;
    for (std::size_t i = 0; i < points.size(); i += 3)
      out.insert(out.end(), {0.3 - points[i + 1], points[i] - 0.4, 0.1 * std::cos(time)});
    return out;
  }
  std::vector<double> of_cells(double time) const {
    std::vector<double> out;
    for (int c = 0; c < n * n * n; ++c)
      out.push_back(std::cos(0.1 * c + time));
    return out;
  }
  int n;
  std::vector<double> points;
  std::vector<std::int64_t> ids;
};

struct Records : Replay {
  static constexpr int steps = 4;
  const std::string scene = R"(insitu: 1
record: {every: 1}
probes:
  - {name: gauges, points: points.csv, fields: [p, c], output: [csv, netcdf]}
tracers:
  - {name: paths, velocity: u, seeds: {box: {min: [0.2, 0.2, 0.2], max: [0.8, 0.8, 0.8], counts: [3, 3, 2]}},
     fields: [p], output: [csv, vtp]}
  - {name: lines, kind: streamline, velocity: u, seeds: [[0.5, 0.5, 0.5]], until: {duration: 0.5}}
frames:
  - {name: seen, size: [40, 30], isosurfaces: [{field: p, values: [0.6]}], volume: {field: c}}
)";

  /// Runs a solver that gives its mesh at each step, and its records again; and its steps, held.
  void same_again(const std::function<void(insitu_session, int step, Arrays&)>& give,
                  std::string of_scene = {}) {
    put("points.csv", "x,y,z\n0.4,0.3,0.2\n0.5,0.5,0.5\n9,9,9\n0.25,0.75,0.5\n");
    put("run.yaml", of_scene.empty() ? scene : of_scene);
    const std::string file = path("run.yaml"), live = path("live");
    insitu_session_options options = insitu_session_options_default();
    options.scene = file.c_str();
    options.output = live.c_str();
    insitu_session session = nullptr;
    check(insitu_session_open(&options, &session));
    Arrays arrays;
    for (int step = 0; step < steps; ++step) {
      give(session, step, arrays);
      check(insitu_session_execute(session, 10 * step, 0.1 * step));
    }
    insitu_report report = insitu_report_default();
    check(insitu_session_report(session, &report));
    check(insitu_session_close(&session));
    // By time, then by name, whatever the order here.
    const Outcome o = run("--out again live/record_000020.hdf live/record_000000.hdf "
                          "live/record_000030.hdf live/record_000010.hdf");
    ASSERT_EQ(o.code, 0) << o.err;
    const Files first = files_of(folder / "live"), second = files_of(folder / "again");
    EXPECT_GT(first.size(), 8u);
    EXPECT_EQ(first.size(), second.size());
    for (const auto& [name, bytes] : first) // records among them: they hold nothing of the run
      EXPECT_TRUE(second.count(name) && second.at(name) == bytes) << name;
    fs::remove_all(folder / "held");
    HeldRun(*this, of_scene.empty() ? scene : of_scene).run(give, report.rebuilds);
  }

  static insitu_mesh mesh_of(insitu_session session, const char* name = "mesh") {
    insitu_mesh mesh = nullptr;
    check(insitu_session_mesh(session, name, &mesh));
    return mesh;
  }
  static void give_field(insitu_mesh mesh, const char* name, insitu_association on,
                         const insitu_array& array, int piece = 0) {
    check(insitu_mesh_field(mesh, piece, name, on, &array, 1));
  }
  static void give_fields(insitu_mesh mesh, const Lattice& lattice, double time, Arrays& arrays,
                          int piece = 0) {
    give_field(mesh, "p", INSITU_VERTEX, arrays.keep(lattice.field(time)), piece);
    give_field(mesh, "u", INSITU_VERTEX, arrays.keep(lattice.velocity(time), 3), piece);
    give_field(mesh, "c", INSITU_CELL, arrays.keep(lattice.of_cells(time)), piece);
  }
};

} // namespace records
