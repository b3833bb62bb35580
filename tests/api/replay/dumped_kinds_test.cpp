// Runs of every kind of mesh, by Catalyst's calls, and their dumps replayed: every table is the
// same, byte for byte.
#include <array>

#include "../catalyst/glued.h"
#include "dumps.h"

namespace dumped {

namespace {

/// One of two domains, beside each other along x, with the arrays that its solver holds.
struct Part {
  explicit Part(int place) : process(place) {
    for (std::vector<double>* x : {&glued.box.x, &glued.box.axis[0]})
      for (double& value : *x)
        value += 4 * place;
    const Box& b = glued.box;
    for (std::size_t i = 0; i < b.x.size(); ++i) {
      u.push_back(0.3 + 0.01 * b.y[i]);
      v.push_back(0.02 * b.x[i]);
    }
    cells.resize(b.number.size());
    for (std::size_t c = 0; c < cells.size(); ++c)
      cells[c] = double(c % 7) + 100 * place;
  }
  /// Vertices of the meshes that have some move.
  void step(int cycle) {
    Box& b = glued.box;
    for (std::size_t i = 0; i < b.x.size(); ++i) {
      b.f[i] = b.x[i] + 2 * b.y[i] + 0.125 * cycle;
      b.z[i] += 1.0 / 1024;
    }
  }

  int process;
  Glued glued;
  std::vector<double> u, v, cells, w, more_cells;
  std::vector<std::int32_t> shapes, sizes, ids;
};

using Add = void (*)(TestNode& node, const std::string& d, Part& part);

struct Kind {
  const char *name, *type, *fields;
  Add add;
};

void add_points(TestNode& node, const std::string& d, Part& p, const char* topology) {
  Box& b = p.glued.box;
  node.set(d + "coordsets/c/type", "explicit").set(d + "coordsets/c/values/x", b.x);
  node.set(d + "coordsets/c/values/y", b.y).set(d + "coordsets/c/values/z", b.z);
  node.set(d + "topologies/topo/type", topology).set(d + "topologies/topo/coordset", "c");
}

/// f and the velocity of vertices, and numbers of cells.
void add_fields(TestNode& node, const std::string& d, Part& p, std::vector<double>& of_cells) {
  node.set(d + "fields/f/association", "vertex").set(d + "fields/f/values", p.glued.box.f);
  node.set(d + "fields/v/association", "vertex").set(d + "fields/v/values/u", p.u);
  node.set(d + "fields/v/values/v", p.v);
  p.w.assign(p.v.size(), -0.001);
  node.set(d + "fields/v/values/w", p.w);
  node.set(d + "fields/number/association", "element").set(d + "fields/number/values", of_cells);
}

void add_uniform(TestNode& node, const std::string& d, Part& p) {
  for (std::size_t a = 0; a < 3; ++a) {
    const std::vector<double>& axis = p.glued.box.axis[a];
    node.set(d + "coordsets/c/dims/" + "ijk"[a], int(axis.size()));
    node.set(d + "coordsets/c/origin/" + "xyz"[a], axis[0]);
    node.set(d + "coordsets/c/spacing/d" + "xyz"[a], axis[1] - axis[0]);
  }
  node.set(d + "coordsets/c/type", "uniform").set(d + "topologies/topo/type", "uniform");
  node.set(d + "topologies/topo/coordset", "c");
  add_fields(node, d, p, p.cells);
}

void add_rectilinear(TestNode& node, const std::string& d, Part& p) {
  for (std::size_t a = 0; a < 3; ++a)
    node.set(d + "coordsets/c/values/" + "xyz"[a], p.glued.box.axis[a]);
  node.set(d + "coordsets/c/type", "rectilinear").set(d + "topologies/topo/type", "rectilinear");
  node.set(d + "topologies/topo/coordset", "c");
  add_fields(node, d, p, p.cells);
}

void add_structured(TestNode& node, const std::string& d, Part& p) {
  add_points(node, d, p, "structured");
  for (std::size_t a = 0; a < 3; ++a)
    node.set(d + "topologies/topo/elements/dims/" + "ijk"[a], p.glued.box.n[a]);
  add_fields(node, d, p, p.cells);
}

/// The box's cells, every third as two wedges; with_polyhedron: the last two glued together.
void add_mixed_cells(TestNode& node, const std::string& d, Part& p, bool with_polyhedron) {
  const std::string e = d + "topologies/topo/elements/";
  add_points(node, d, p, "unstructured");
  p.shapes.clear(), p.sizes.clear(), p.ids.clear(), p.more_cells.clear();
  const auto add = [&](int shape, const std::vector<std::int64_t>& of_cell) {
    p.shapes.push_back(shape);
    p.sizes.push_back(int(of_cell.size()));
    p.ids.insert(p.ids.end(), of_cell.begin(), of_cell.end());
    p.more_cells.push_back(double(p.more_cells.size() % 7));
  };
  for (std::size_t c = 0; c < (with_polyhedron ? 22 : 24); ++c) {
    const std::int64_t* v = &p.glued.box.hexahedra[8 * c];
    if (c % 3 == 0 && c < 12) {
      add(13, {v[0], v[2], v[1], v[4], v[6], v[5]});
      add(13, {v[0], v[3], v[2], v[4], v[7], v[6]});
    } else {
      add(12, {v, v + 8});
    }
  }
  if (with_polyhedron) {
    add(42, {p.glued.cell_faces.end() - 10, p.glued.cell_faces.end()});
    const std::string s = d + "topologies/topo/subelements/";
    node.set(s + "shape", "polygonal").set(s + "connectivity", p.glued.vertices);
    node.set(s + "sizes", p.glued.sizes);
    node.set(e + "shape_map/polyhedral", 42);
  }
  node.set(e + "shape", "mixed").set(e + "shape_map/hex", 12).set(e + "shape_map/wedge", 13);
  node.set(e + "shapes", p.shapes).set(e + "sizes", p.sizes).set(e + "connectivity", p.ids);
  add_fields(node, d, p, p.more_cells);
}

void add_mixed(TestNode& node, const std::string& d, Part& p) {
  add_mixed_cells(node, d, p, false);
}

void add_polyhedra_among_others(TestNode& node, const std::string& d, Part& p) {
  add_mixed_cells(node, d, p, true);
}

void add_polyhedral(TestNode& node, const std::string& d, Part& p) {
  add_points(node, d, p, "unstructured");
  add_fields(node, d, p, p.glued.number);
  p.glued.add_to(node, d);
}

/// Hexagons of two of the box's lowest squares each, in a plane.
void add_polygonal(TestNode& node, const std::string& d, Part& p) {
  const std::string e = d + "topologies/topo/elements/";
  add_points(node, d, p, "unstructured");
  p.sizes.clear(), p.ids.clear(), p.more_cells.clear();
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; i += 2) {
      const int v = i + 5 * j, w = v + 5;
      p.ids.insert(p.ids.end(), {v, v + 1, v + 2, w + 2, w + 1, w});
      p.sizes.push_back(6);
      p.more_cells.push_back(double(p.process + j));
    }
  node.remove(d + "coordsets/c/values/z");
  node.set(e + "shape", "polygonal").set(e + "sizes", p.sizes).set(e + "connectivity", p.ids);
  add_fields(node, d, p, p.more_cells);
}

/// Of eight coarse cells, and of finer ones over one of them.
void add_level(TestNode& node, const std::string& d, Part& p) {
  const int n = 4;
  const double spacing = p.process == 0 ? 1.0 : 0.5;
  p.more_cells.resize(n * n * n);
  for (std::size_t c = 0; c < p.more_cells.size(); ++c)
    p.more_cells[c] = double(c) + 0.25 * p.glued.box.f[0];
  for (std::size_t a = 0; a < 3; ++a) {
    node.set(d + "coordsets/c/dims/" + "ijk"[a], n + 1);
    node.set(d + "coordsets/c/origin/" + "xyz"[a], double(a) + 1 + p.process);
    node.set(d + "coordsets/c/spacing/d" + "xyz"[a], spacing);
    p.w.assign(p.more_cells.size(), 0.1);
    node.set(d + "fields/v/values/" + "uvw"[a], p.w);
  }
  node.set(d + "coordsets/c/type", "uniform").set(d + "topologies/topo/type", "uniform");
  node.set(d + "topologies/topo/coordset", "c").set(d + "state/level", p.process);
  node.set(d + "fields/v/association", "element").set(d + "fields/number/association", "element");
  node.set(d + "fields/number/values", p.more_cells);
}

const Kind kinds[] = {
    {"uniform", "mesh", "f, number, v", add_uniform},
    {"rectilinear", "mesh", "f, number, v", add_rectilinear},
    {"structured", "mesh", "f, number, v", add_structured},
    {"mixed", "mesh", "f, number, v", add_mixed},
    {"polyhedral", "mesh", "f, number, v", add_polyhedral},
    {"polyhedra_among_others", "mesh", "f, number, v", add_polyhedra_among_others},
    {"polygonal", "mesh", "f, number, v", add_polygonal},
    {"amrmesh", "amrmesh", "number, v", add_level}};

void PrintTo(const Kind& kind, std::ostream* out) {
  *out << kind.name;
}

struct DumpedKinds : DumpReplay, testing::WithParamInterface<Kind> {
  static constexpr int cycles = 3;

  void SetUp() override {
    folder = fs::path(testing::TempDir()) /
             ("insitu_dumped_" + std::to_string(getpid()) + "_" + GetParam().name);
    DumpReplay::SetUp();
    for (const char* name : {"one", "two"})
      fs::create_directories(folder / name);
    put("dumped.yaml",
        "insitu: 1\nprobes:\n  - {name: g, mesh: grid, points: [[1.1, 2.1, 3.1], [2.5, 2.9, 3.3], "
        "[4.9, 3.4, 3.4], [5, 2.5, 3.25], [7.3, 3.1, 3.2], [9, 9, 9]], fields: [" +
            std::string(GetParam().fields) +
            "]}\ntracers:\n  - {name: t, mesh: grid, velocity: v, seeds: {line: {from: [2.2, 2.2, "
            "3.1], to: [2.2, 3.3, 3.4], count: 5}}}\n");
    ::setenv("CATALYST_IMPLEMENTATION_NAME", "insitu", 1);
    ::setenv("CATALYST_IMPLEMENTATION_PATHS", CATALYST_FOLDER, 1);
  }
  static void add_domain(TestNode& node, Part& part, const std::string& domain) {
    const std::string channel = "catalyst/channels/grid/", d = channel + "data/" + domain;
    node.set(channel + "type", GetParam().type);
    if (!domain.empty())
      node.set(d + "state/domain_id", part.process);
    GetParam().add(node, d, part);
  }
  static TestNode call(int cycle) {
    TestNode node;
    node.set("catalyst/state/timestep", cycle).set("catalyst/state/time", 0.5 * cycle);
    return node;
  }
  /// The solver's run, live, and its dumps as of one process and as of two.
  void run_solver() {
    TestNode start;
    start.set("catalyst/scripts/scene/filename", path("dumped.yaml"));
    start.set("catalyst/insitu/output", path("live"));
    DumpWriter(start, path("one/initialize_params.conduit_bin.1.0"));
    ASSERT_EQ(catalyst_initialize(start.get()), catalyst_status_ok);
    std::array<Part, 2> parts{Part(0), Part(1)};
    for (int cycle = 0; cycle < cycles; ++cycle) {
      TestNode all = call(cycle);
      for (Part& part : parts) {
        part.step(cycle);
        add_domain(all, part, part.process == 0 ? "a/" : "b/");
      }
      EXPECT_EQ(catalyst_execute(all.get()), catalyst_status_ok);
      DumpWriter(all, dump_of(cycle, 0, 1, "one/"));
      for (Part& part : parts) {
        TestNode alone = call(cycle);
        add_domain(alone, part, part.process == 1 ? "only/" : "");
        DumpWriter(alone, dump_of(cycle, part.process, 2, "two/"));
      }
    }
    EXPECT_EQ(catalyst_finalize(call(0).get()), catalyst_status_ok);
  }
};

TEST_P(DumpedKinds, GiveTheTablesOfTheLiveRun) {
  run_solver();
  Outcome o = run("--out again_one one"); // with the run's own scene
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(o.err, "");
  o = run("--scene dumped.yaml --out again_two two");
  EXPECT_EQ(o.code, 0) << o.err;
  for (const std::string table : {"/g.csv", "/t.csv"}) {
    const std::string live = contents(path("live" + table));
    EXPECT_GT(std::count(live.begin(), live.end(), '\n'), 15) << live;
    EXPECT_EQ(contents(path("again_one" + table)), live) << table;
    EXPECT_EQ(contents(path("again_two" + table)), live) << table;
  }
  const double f[] = {1.1 + 2 * 2.1, 2.5 + 2 * 2.9}; // at points that lie in every kind of mesh
  for (const Row& row : rows("live/g.csv"))
    if (row.at("point") < 2 && row.count("f")) {
      EXPECT_NEAR(row.at("f"), f[int(row.at("point"))] + 0.125 * row.at("cycle"), 1e-12);
    }
  const Outcome check = run("--check --out nothing one");
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_NE(check.out.find("  field 'number' on cells, 1 component\n"), std::string::npos)
      << check.out;
  EXPECT_FALSE(fs::exists(folder / "nothing"));
}

INSTANTIATE_TEST_SUITE_P(OfMeshes, DumpedKinds, testing::ValuesIn(kinds),
                         [](const auto& kind) { return std::string(kind.param.name); });

} // namespace

} // namespace dumped
