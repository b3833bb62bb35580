/// Flat meshes over processes: mpiexec -n 1, 2, 4. Cells dealt by turns, the last process without
/// any; owners as a search over the whole mesh finds them.
#include <cstdint>
#include <insitu/insitu.hpp>
#include <memory>
#include <vector>

#include "api/mpi/main.h"
#include "unit/flat/flat_meshes.h"

using namespace flat_meshes;

namespace {

constexpr int n = 5;
const MPI_Comm world = MPI_COMM_WORLD;

/// The part of a process, with vertices of the whole and the field there.
struct Part {
  Part(const Flat& whole, double plane) {
    const int parts = std::max(1, size() - 1);
    for (std::size_t v = 0; v < whole.vertices(); ++v)
      xyz.insert(xyz.end(), {whole.x[v], whole.y[v], plane});
    f = values_of(whole);
    for (std::size_t c = 0; c < whole.cells.size(); ++c) {
      if (int(c) % parts != rank())
        continue;
      numbers.push_back(std::int64_t(c));
      for (std::size_t v = 0; v < 4; ++v)
        ids.push_back(v < whole.cells[c].size() ? whole.cells[c][v] : -1);
    }
  }
  void give(insitu::Mesh& mesh) {
    if (numbers.empty())
      return;
    mesh.points(insitu::Array(xyz.data(), f.size()));
    mesh.padded_flat_cells(insitu::Array(ids.data(), numbers.size()));
    mesh.vertex_field("f", insitu::Array(f));
    mesh.global_ids(insitu::Association::cell, insitu::Array(numbers));
  }
  std::vector<double> xyz, f;
  std::vector<std::int64_t> numbers;
  std::vector<int> ids;
};

insitu::Options options() {
  insitu::Options o;
  o.output = "flat";
  o.communicator = &world;
  return o;
}

} // namespace

TEST(FlatOverMpi, OwnersAreTheLowestCellsOfAllProcesses) {
  const Flat whole = flat_mesh(n, Kind::mixed, true);
  Part part(whole, 3.0);
  insitu::Session session(options());
  insitu::Mesh mesh = session.mesh("m");
  part.give(mesh);
  mesh.commit();
  std::vector<double> xyz;
  if (!part.numbers.empty()) // without the field no values can be asked for
    xyz = points_of(whole, n);
  for (const insitu::Accuracy accuracy : {insitu::Accuracy::standard, insitu::Accuracy::exact}) {
    insitu::LocateOptions everywhere;
    everywhere.everywhere = true;
    everywhere.accuracy = accuracy;
    const insitu::Samples s = mesh.sample("f", xyz, everywhere);
    for (std::size_t i = 0; i < xyz.size() / 3; ++i) {
      const double x = xyz[3 * i], y = xyz[3 * i + 1];
      ASSERT_EQ(s.global_cells[i], owner(whole, x, y)) << x << " " << y;
      if (s.found[i]) {
        ASSERT_NEAR(s.values[i], linear(x, y), 2e-14); // a few roundings of numbers up to 40
      }
    }
  }
}

TEST(FlatOverMpi, OnePlaneAndOneKindForAll) {
  if (size() < 2)
    GTEST_SKIP() << "of one process";
  const Flat whole = flat_mesh(n, Kind::quads, false);
  insitu::Session session(options());
  const auto message = [&](insitu::Mesh& mesh) -> std::string {
    insitu::LocateOptions everywhere;
    everywhere.everywhere = true;
    try {
      mesh.locate(std::vector<double>{1.5, 1.5, 0}, everywhere);
    } catch (const insitu::Error& e) {
      return e.what();
    }
    return "";
  };
  if (size() > 2) { // of which two have cells
    Part part(whole, rank() == 0 ? 0.0 : 1.0);
    insitu::Mesh planes = session.mesh("planes");
    part.give(planes);
    planes.commit();
    EXPECT_NE(message(planes).find("planes are 1.000000 apart"), std::string::npos)
        << message(planes);
  }
  insitu::Mesh kinds = session.mesh("kinds");
  if (rank() == 0)
    kinds.flat_uniform_block({3, 3}, {0, 0}, {1, 1});
  else if (rank() == 1)
    kinds.uniform_block({3, 3, 3}, {2, 0, 0}, {1, 1, 1});
  kinds.commit();
  EXPECT_NE(message(kinds).find("volume cells on some processes"), std::string::npos)
      << message(kinds);
}

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}
