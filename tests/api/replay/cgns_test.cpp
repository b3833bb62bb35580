// insitu-replay on CGNS files of unstructured zones, written by the CGNS library that VTK brings.
#include <array>
#include <vtk_cgns.h>
#include VTK_CGNS(cgnslib.h)

#include "replay.h"

namespace {

/// Two zones of 2 x 2 x 2 unit cubes beside each other along x.
struct Cgns : Replay {
  static double f(const double* x, double time) {
    return 1 + x[0] - 2 * x[1] + 3 * x[2] + 10 * time;
  }

  /// A zone with its hexahedra and the quads of its floor.
  static int write_zone(int file, int base, double from) {
    std::vector<double> coordinates[3];
    for (int v = 0; v < 27; ++v) {
      coordinates[0].push_back(from + v % 3);
      coordinates[1].push_back(v / 3 % 3);
      coordinates[2].push_back(v / 9);
    }
    std::vector<cgsize_t> hexahedra, floor;
    for (int c = 0; c < 8; ++c) {
      const cgsize_t v = 1 + c % 2 + 3 * (c / 2 % 2) + 9 * (c / 4);
      for (const cgsize_t layer : {v, v + 9})
        hexahedra.insert(hexahedra.end(), {layer, layer + 1, layer + 4, layer + 3});
      if (c < 4)
        floor.insert(floor.end(), {v, v + 3, v + 4, v + 1});
    }
    int zone = 0, id = 0;
    const cgsize_t size[3] = {27, 8, 0};
    EXPECT_EQ(cg_zone_write(file, base, from == 0 ? "left" : "right", size,
                            CGNS_ENUMV(Unstructured), &zone),
              CG_OK);
    for (std::size_t a = 0; a < 3; ++a)
      cg_coord_write(file, base, zone, CGNS_ENUMV(RealDouble),
                     std::array{"CoordinateX", "CoordinateY", "CoordinateZ"}[a],
                     coordinates[a].data(), &id);
    cg_section_write(file, base, zone, "cubes", CGNS_ENUMV(HEXA_8), 1, 8, 0, hexahedra.data(), &id);
    cg_section_write(file, base, zone, "floor", CGNS_ENUMV(QUAD_4), 9, 12, 0, floor.data(), &id);
    return zone;
  }
  static void write_solution(int file, int base, int zone, const std::string& name, bool on_cells,
                             double from, double time) {
    std::vector<double> values;
    for (int i = 0; i < (on_cells ? 8 : 27); ++i) {
      const double x[] = {from + i % 3, double(i / 3 % 3), double(i / 9)};
      values.push_back(on_cells ? 10 * from + i : f(x, time));
    }
    int solution = 0, id = 0;
    cg_sol_write(file, base, zone, name.c_str(),
                 on_cells ? CGNS_ENUMV(CellCenter) : CGNS_ENUMV(Vertex), &solution);
    EXPECT_EQ(cg_field_write(file, base, zone, solution, CGNS_ENUMV(RealDouble),
                             on_cells ? "c" : "f", values.data(), &id),
              CG_OK);
  }
  void write_file(const std::string& name, const std::vector<double>& times, bool cells) const {
    int file = 0, base = 0;
    ASSERT_EQ(cg_open(path(name).c_str(), CG_MODE_WRITE, &file), CG_OK) << cg_get_error();
    cg_base_write(file, "Base", 3, 3, &base);
    for (const double from : {0.0, 2.0}) {
      const int zone = write_zone(file, base, from);
      std::string pointers;
      for (std::size_t t = 0; t < std::max<std::size_t>(times.size(), 1); ++t) {
        const std::string solution = "FlowSolution" + std::to_string(t);
        write_solution(file, base, zone, solution, false, from, times.empty() ? 0 : times[t]);
        if (cells)
          write_solution(file, base, zone, "OfCells", true, from, 0);
        pointers += solution + std::string(32 - solution.size(), ' ');
      }
      if (times.empty())
        continue;
      const cgsize_t size[2] = {32, cgsize_t(times.size())};
      cg_ziter_write(file, base, zone, "ZoneIterativeData");
      cg_goto(file, base, "Zone_t", zone, "ZoneIterativeData_t", 1, "end");
      cg_array_write("FlowSolutionPointers", CGNS_ENUMV(Character), 2, size, pointers.c_str());
    }
    if (!times.empty()) {
      const cgsize_t count = cgsize_t(times.size());
      cg_biter_write(file, base, "TimeIterValues", int(times.size()));
      cg_goto(file, base, "BaseIterativeData_t", 1, "end");
      cg_array_write("TimeValues", CGNS_ENUMV(RealDouble), 1, &count, times.data());
    }
    EXPECT_EQ(cg_close(file), CG_OK) << cg_get_error();
  }
};

TEST_F(Cgns, ZonesArePiecesWithFieldsOfNodesAndCells) {
  write_file("m.cgns", {}, true);
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[0.3, 0.4, 0.6], [3.5, 1.25, 1.5], "
                    "[2, 1, 1], [5, 0, 0]], fields: [f, c]}\n");
  const Outcome o = run("--scene scene.yaml --out out m.cgns");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> table = rows("out/g.csv");
  ASSERT_EQ(table.size(), 4u);
  const double points[][3] = {{0.3, 0.4, 0.6}, {3.5, 1.25, 1.5}, {2, 1, 1}};
  for (std::size_t p = 0; p < 3; ++p)
    EXPECT_NEAR(table[p].at("f"), f(points[p], 0), 1e-13);
  EXPECT_EQ(table[0].at("c"), 0.0);
  EXPECT_EQ(table[1].at("c"), 27.0);
  EXPECT_EQ(table[2].at("c"), 1.0); // between the zones the first one's lowest cell
  EXPECT_TRUE(std::isnan(table[3].at("f")));
  expect_checked("--scene scene.yaml m.cgns",
                 {"mesh 'mesh': 16 cells, 54 vertices\n", "  field 'f' on vertices, 1 component\n",
                  "  field 'c' on cells, 1 component\n", "1 step\n"});
}

TEST_F(Cgns, TimesAreSteps) {
  write_file("m.cgns", {0.5, 2.0, 2.25}, false);
  put("scene.yaml", "insitu: 1\nprobes:\n  - {name: g, points: [[3.5, 1.25, 1.5]], fields: [f]}\n");
  const Outcome o = run("--scene scene.yaml --out out m.cgns");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::vector<Row> table = rows("out/g.csv");
  ASSERT_EQ(table.size(), 3u);
  const double point[] = {3.5, 1.25, 1.5}, times[] = {0.5, 2.0, 2.25};
  for (std::size_t t = 0; t < 3; ++t) {
    EXPECT_EQ(table[t].at("time"), times[t]);
    EXPECT_NEAR(table[t].at("f"), f(point, times[t]), 1e-12);
  }
}

TEST_F(Cgns, WhatIsCutIsRefused) {
  write_file("m.cgns", {}, true);
  const std::string whole = contents(path("m.cgns"));
  for (const std::size_t size :
       {std::size_t(0), std::size_t(600), whole.size() / 2, whole.size() - 1}) {
    put("cut.cgns", whole.substr(0, size));
    const Outcome o = run("--probe points.csv --out out cut.cgns");
    EXPECT_EQ(o.code, 1) << size;
    EXPECT_NE(o.err.find("cut.cgns"), std::string::npos) << size << o.err;
  }
}

} // namespace
