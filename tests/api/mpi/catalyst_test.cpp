/// A solver on MPI that speaks Catalyst's interface alone, its box cut into slabs: the tables are
/// those of one process, to the byte, and a process whose channel is wrong does not leave the
/// others waiting.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "insitu/insitu.h"

#include "api/catalyst/nodes.h"
#include "api/mpi/main.h"

namespace {

namespace fs = std::filesystem;

const char* const scene = R"(insitu: 1
page: false
probes:
  - {name: gauges, mesh: grid, points: {box: {min: [1, 2, 3], max: [8.9, 4.9, 3.9], counts: [9, 4, 3]}}, fields: [f, number]}
  - {name: bolts, mesh: grid, attached: body, points: [[1.5, 2.2, 3.1], [8.7, 4.7, 3.6], [5.1, 4.1, 3.3]], fields: [f]}
tracers:
  - {name: drifters, mesh: grid, velocity: v, seeds: {line: {from: [1.2, 2.2, 3.1], to: [8.5, 4.3, 3.4], count: 9}}}
)";

/// The cells of a box of 8 x 6 x 4 whose first index is from `first` to `last` - 1.
struct Slab {
  Slab(int first, int last) : box({last - first, 6, 4}) {
    for (std::size_t v = 0; v < box.x.size(); ++v) {
      box.x[v] += first;
      box.f[v] = box.x[v] + 2 * box.y[v] + 3 * box.z[v];
      u.push_back(1.0 - 0.0625 * box.y[v]);
      w.push_back(0.0);
    }
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 6; ++j)
        for (int i = first; i < last; ++i) {
          ids.push_back(i + 8 * (j + 6 * k));
          box.number[ids.size() - 1] = double(ids.back());
        }
  }
  Box box;
  std::vector<double> u, w;
  std::vector<std::int64_t> ids;
};

TestNode step_of(Slab& s, int cycle) {
  TestNode node;
  const std::string d = "catalyst/channels/grid/data/", fields = d + "fields/";
  node.set("catalyst/state/timestep", cycle).set("catalyst/state/time", 0.25 * cycle);
  node.set("catalyst/channels/grid/type", "mesh");
  if (s.ids.empty())
    return node; // a process without cells
  node.set(d + "coordsets/c/type", "explicit").set(d + "coordsets/c/values/x", s.box.x);
  node.set(d + "coordsets/c/values/y", s.box.y).set(d + "coordsets/c/values/z", s.box.z);
  node.set(d + "topologies/t/type", "unstructured").set(d + "topologies/t/coordset", "c");
  node.set(d + "topologies/t/elements/shape", "hex");
  node.set(d + "topologies/t/elements/connectivity", s.box.hexahedra);
  node.set(fields + "f/association", "vertex").set(fields + "f/values", s.box.f);
  node.set(fields + "number/association", "element").set(fields + "number/values", s.box.number);
  node.set(fields + "v/association", "vertex").set(fields + "v/values/u", s.u);
  node.set(fields + "v/values/v", s.w).set(fields + "v/values/w", s.w);
  node.set(fields + "gid/association", "element").set(fields + "gid/values", s.ids);
  node.set(d + "state/metadata/vtk_fields/gid/attribute_type", "GlobalIds");
  return node;
}

fs::path folder() {
  return fs::temp_directory_path() / ("insitu_catalyst_mpi_" + std::to_string(::size()));
}

/// What catalyst_results tells of the probes, as one row.
std::vector<double> answers() {
  TestNode node;
  if (catalyst_results(node.get()) != catalyst_status_ok)
    return {};
  std::vector<double> all;
  for (const char* probe : {"gauges", "bolts"})
    for (const char* path : {"time", "points/x", "points/y", "points/z", "fields/f"}) {
      const std::vector<double> some =
          node.doubles(std::string("catalyst/insitu/probes/") + probe + "/" + path);
      all.insert(all.end(), some.begin(), some.end());
    }
  for (const std::uint8_t inside : node.bytes("catalyst/insitu/probes/gauges/inside"))
    all.push_back(inside);
  return all;
}

/// Of one process if communicator is negative. told: gets the answers of the probes at each cycle
/// from 2 on, in one of them on one process alone.
int run(const std::string& name, std::int64_t communicator, Slab& slab, int wrong_at = -1,
        std::vector<double>* told = nullptr) {
  TestNode start;
  start.set("catalyst/scripts/scene", (folder() / "scene.yaml").string());
  start.set("catalyst/insitu/output", (folder() / name).string());
  start.set("catalyst/insitu/threads", 1);
  if (communicator >= 0)
    start.set("catalyst/mpi_comm", communicator);
  int failures = catalyst_initialize(start.get()) != catalyst_status_ok;
  for (int cycle = 0; cycle < 6; ++cycle) {
    TestNode node = step_of(slab, cycle);
    if (cycle == wrong_at)
      node.remove("catalyst/channels/grid/data/topologies/t/coordset");
    failures += catalyst_execute(node.get()) != catalyst_status_ok;
    if (told && cycle >= 2 && (cycle != 3 || communicator < 0 || ::rank() == ::size() - 1)) {
      const std::vector<double> now = answers();
      told->insert(told->end(), now.begin(), now.end());
    }
    for (double& x : slab.box.x)
      x += told ? 1.0 / 64 : 0.0;
  }
  return failures + (catalyst_finalize(start.get()) != catalyst_status_ok);
}

std::string text_of(const fs::path& file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return out.str();
}

class Catalyst : public testing::Test {
protected:
  Catalyst() {
    setenv("CATALYST_IMPLEMENTATION_NAME", "insitu", 1);
    setenv("CATALYST_IMPLEMENTATION_PATHS", INSITU_CATALYST_FOLDER, 1);
    if (::rank() == 0) {
      fs::remove_all(folder());
      fs::create_directories(folder());
      std::ofstream(folder() / "scene.yaml") << scene;
    }
    MPI_Barrier(MPI_COMM_WORLD);
  }
  /// Some processes have none.
  static Slab own_slab() {
    const int n = ::size(), r = ::rank();
    return n > 2 ? Slab(8 * std::max(r - 1, 0) / (n - 1), 8 * r / (n - 1))
                 : Slab(8 * r / n, 8 * (r + 1) / n);
  }
};

TEST_F(Catalyst, TablesAreThoseOfOneProcess) {
  Slab slab = own_slab();
  EXPECT_EQ(run("all", MPI_Comm_c2f(MPI_COMM_WORLD), slab), 0);
  if (::rank() == 0) {
    Slab whole(0, 8);
    EXPECT_EQ(run("one", -1, whole), 0);
    for (const char* file : {"gauges.csv", "drifters.csv"}) {
      EXPECT_EQ(text_of(folder() / "one" / file), text_of(folder() / "all" / file)) << file;
      EXPECT_GT(text_of(folder() / "one" / file).size(), 2000u) << file;
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

/// Values to steer by are the same on all processes, and those of one process, to the bit; a
/// process that asks alone waits for nobody. The mesh moves, and some points with it.
TEST_F(Catalyst, AllProcessesGetTheValuesOfProbes) {
  Slab slab = own_slab();
  std::vector<double> told, one;
  EXPECT_EQ(run("told", MPI_Comm_c2f(MPI_COMM_WORLD), slab, -1, &told), 0);
  if (::rank() == 0) {
    Slab whole(0, 8);
    EXPECT_EQ(run("told_one", -1, whole, -1, &one), 0);
  }
  const std::size_t row = 2 + 3 * 108 + 3 * 3 + 108 + 3 + 108;
  one.resize(4 * row);
  MPI_Bcast(one.data(), int(one.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
  if (::rank() != ::size() - 1) // which alone asked in the second of four cycles
    one.erase(one.begin() + row, one.begin() + 2 * row);
  ASSERT_EQ(told.size(), one.size());
  EXPECT_EQ(std::memcmp(told.data(), one.data(), one.size() * sizeof(double)), 0);
  EXPECT_TRUE(std::count_if(one.begin(), one.end(), [](double x) { return std::isnan(x); }) > 0);
  EXPECT_EQ(one[1 + 108], 2.0) << "the first gauge's y";
  // The place in a cell is found by Newton's method, to roundings of numbers below 16.
  EXPECT_NEAR(one[2 + 4 * 108], 1.5 + 2.0 / 64, 1e-13) << "the first bolt's x, after two moves";
}

/// Processes that do not want the same wait for nobody.
TEST_F(Catalyst, AllProcessesWantAnswersOrNone) {
  TestNode start;
  start.set("catalyst/scripts/scene", (folder() / "scene.yaml").string());
  start.set("catalyst/insitu/output", (folder() / "some").string());
  start.set("catalyst/mpi_comm", std::int64_t(MPI_Comm_c2f(MPI_COMM_WORLD)));
  start.set("catalyst/insitu/answers", ::rank() == ::size() - 1 ? 0 : 1);
  EXPECT_EQ(int(catalyst_initialize(start.get())),
            ::size() == 1 ? 0 : 1000 + INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(catalyst_finalize(start.get()), catalyst_status_ok);
}

/// Level 0 on the first process and level 1 on the last one, whose domain cannot tell the spacing
/// of level 0 but for its nestsets: a quarter. Their lower corners are one.
TEST_F(Catalyst, NestsetsTellTheRatioOfALevelOfAnotherProcess) {
  std::vector<double> coarse, fine;
  TestNode node;
  const std::string data = "catalyst/channels/grid/data/";
  const auto put = [&](const std::string& name, int level, int cells, double spacing,
                       std::vector<double>& values) {
    const std::string d = data + name + "/";
    for (int a = 0; a < 3; ++a) {
      node.set(d + "coordsets/c/dims/" + "ijk"[a], cells + 1);
      node.set(d + "coordsets/c/spacing/d" + "xyz"[a], spacing);
    }
    node.set(d + "coordsets/c/type", "uniform").set(d + "topologies/t/type", "uniform");
    node.set(d + "topologies/t/coordset", "c").set(d + "state/level", level);
    for (int i = 0; i < cells * cells * cells; ++i)
      values.push_back(100 * level + i);
    node.set(d + "fields/v/association", "element").set(d + "fields/v/values", values);
  };
  node.set("catalyst/channels/grid/type", "amrmesh");
  if (::rank() == 0)
    put("coarse", 0, 3, 4.0, coarse);
  if (::rank() == ::size() - 1) {
    put("fine", 1, 4, 1.0, fine);
    const std::string window = data + "fine/nestsets/nest/windows/w/";
    node.set(window + "domain_id", 0).set(window + "domain_type", "parent");
    for (const char* axis : {"i", "j", "k"})
      node.set(window + "ratio/" + axis, 4);
  }
  const std::string path = (folder() / "amr.yaml").string();
  if (::rank() == 0)
    std::ofstream(path) << "insitu: 1\npage: false\nprobes:\n"
                           "  - {name: p, points: [[2, 2, 2], [6, 2, 2], [0.5, 0.5, 0.5]], "
                           "fields: [v]}\n";
  MPI_Barrier(MPI_COMM_WORLD);
  TestNode start, results;
  start.set("catalyst/scripts/scene", path).set("catalyst/insitu/threads", 1);
  start.set("catalyst/insitu/output", (folder() / "amr").string());
  start.set("catalyst/mpi_comm", std::int64_t(MPI_Comm_c2f(MPI_COMM_WORLD)));
  ASSERT_EQ(catalyst_initialize(start.get()), catalyst_status_ok);
  EXPECT_EQ(catalyst_execute(node.get()), catalyst_status_ok);
  ASSERT_EQ(catalyst_results(results.get()), catalyst_status_ok);
  EXPECT_EQ(catalyst_finalize(start.get()), catalyst_status_ok);
  ASSERT_TRUE(results.has("catalyst/insitu/probes/p/fields/v"));
  const std::vector<double> v = results.doubles("catalyst/insitu/probes/p/fields/v");
  // The mean of the eight cells around a corner, and the centres of a coarse and of a fine cell:
  // sums of eight numbers below 200, rounded.
  EXPECT_NEAR(v[0], 100 + (21.0 + 42.0) / 2, 1e-11);
  EXPECT_NEAR(v[1], 1, 1e-11);
  EXPECT_NEAR(v[2], 100, 1e-11);
}

/// Hexagons beside squares on each process, which meet along x = 2 r, and a further topology that
/// the last process has alone: a mesh of its own, for all.
TEST_F(Catalyst, PolygonsAndFurtherTopologies) {
  const int n = ::size();
  std::vector<double> x, y, f, square_x{90, 91, 91, 90}, square_y{0, 0, 1, 1}, heat{7.0};
  std::vector<std::int32_t> ids, sizes, square{0, 1, 2, 3};
  for (int v = 0; v < 9; ++v) {
    x.push_back(2 * ::rank() + v % 3 + (v == 4 ? 0.125 : 0.0));
    y.push_back(v / 3);
    f.push_back(x.back() - 2 * y.back());
  }
  ids = {0, 1, 2, 5, 4, 3, 3, 4, 7, 6, 4, 5, 8, 7};
  sizes = {6, 4, 4};
  TestNode node;
  const std::string d = "catalyst/channels/grid/data/", e = d + "topologies/p/elements/";
  node.set("catalyst/channels/grid/type", "mesh");
  node.set(d + "coordsets/c/type", "explicit").set(d + "coordsets/c/values/x", x);
  node.set(d + "coordsets/c/values/y", y).set(d + "topologies/p/coordset", "c");
  node.set(d + "topologies/p/type", "unstructured").set(e + "shape", "polygonal");
  node.set(e + "connectivity", ids).set(e + "sizes", sizes);
  node.set(d + "fields/f/association", "vertex").set(d + "fields/f/topology", "p");
  node.set(d + "fields/f/values", f);
  if (::rank() == n - 1) {
    const std::string q = d + "topologies/q/";
    node.set(d + "coordsets/s/type", "explicit").set(d + "coordsets/s/values/x", square_x);
    node.set(d + "coordsets/s/values/y", square_y).set(q + "coordset", "s");
    node.set(q + "type", "unstructured").set(q + "elements/shape", "quad");
    node.set(q + "elements/connectivity", square);
    node.set(d + "fields/heat/association", "element").set(d + "fields/heat/topology", "q");
    node.set(d + "fields/heat/values", heat);
  }
  const std::string path = (folder() / "polygons.yaml").string();
  if (::rank() == 0)
    std::ofstream(path)
        << "insitu: 1\npage: false\nprobes:\n"
           "  - {name: p, mesh: grid, points: {line: {from: [0, 0.75, 0], to: ["
        << 2 * n << ", 0.75, 0], count: " << 8 * n + 1
        << "}}, fields: [f]}\n"
           "  - {name: q, mesh: grid/q, points: [[90.5, 0.5, 0]], fields: [heat]}\n";
  MPI_Barrier(MPI_COMM_WORLD);
  TestNode start, results;
  start.set("catalyst/scripts/scene", path).set("catalyst/insitu/threads", 1);
  start.set("catalyst/insitu/output", (folder() / "polygons").string());
  start.set("catalyst/mpi_comm", std::int64_t(MPI_Comm_c2f(MPI_COMM_WORLD)));
  ASSERT_EQ(catalyst_initialize(start.get()), catalyst_status_ok);
  EXPECT_EQ(catalyst_execute(node.get()), catalyst_status_ok);
  ASSERT_EQ(catalyst_results(results.get()), catalyst_status_ok);
  EXPECT_EQ(catalyst_finalize(start.get()), catalyst_status_ok);
  const std::string probes = "catalyst/insitu/probes/";
  ASSERT_TRUE(results.has(probes + "p/fields/f") && results.has(probes + "q/fields/heat"));
  const std::vector<double> values = results.doubles(probes + "p/fields/f");
  ASSERT_EQ(values.size(), std::size_t(8 * n + 1));
  for (std::size_t i = 0; i < values.size(); ++i) // every quarter, on the seams too
    EXPECT_NEAR(values[i], 0.25 * double(i) - 1.5, 1e-13) << i;
  EXPECT_EQ(results.doubles(probes + "q/fields/heat"), std::vector<double>{7.0});
}

/// Nothing is executed in that step, on any process, and the run goes on.
TEST_F(Catalyst, AWrongChannelIsToldToAll) {
  Slab slab = own_slab();
  const bool wrong = ::rank() == ::size() - 1;
  EXPECT_EQ(run("wrong", MPI_Comm_c2f(MPI_COMM_WORLD), slab, wrong ? 2 : -1), 1);
  MPI_Barrier(MPI_COMM_WORLD);
  std::istringstream rows(text_of(folder() / "wrong" / "gauges.csv"));
  int of_wrong_step = 0, all = -1;
  for (std::string row; std::getline(rows, row); ++all)
    of_wrong_step += row.compare(0, 2, "2,") == 0;
  EXPECT_EQ(of_wrong_step, 0);
  EXPECT_EQ(all, 5 * 108);
}

} // namespace

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}
