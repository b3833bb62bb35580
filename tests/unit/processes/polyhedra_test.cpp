// Meshes whose cells are given by faces, over processes: the files of one process, to the byte.
#include <cmath>
#include <map>

#include "fixtures/polyhedra.h"
#include "part_session.h"

using namespace insitu;
using namespace insitu::test;
using fixtures::FaceMesh;

namespace {

/// The cells of a mesh that a process has, in their order, with vertices in another order.
struct FacePart {
  std::vector<int> vertices; ///< of the whole, by local id
  std::vector<std::int64_t> cells, global_vertices;
  FaceMesh mesh;
  std::vector<double> points, p, u, c;
  fixtures::FaceArrays<> arrays;

  static FaceMesh cut(const FaceMesh& whole, const std::vector<int>& process, int rank,
                      std::vector<int>& vertices, std::vector<std::int64_t>& cells) {
    FaceMesh out;
    for (std::size_t cell = 0; cell < whole.cells.size(); ++cell)
      if (process[cell] == rank)
        cells.push_back(std::int64_t(cell));
    std::map<int, int> local;
    for (auto cell = cells.rbegin(); cell != cells.rend(); ++cell) // numbers as they come
      for (const int f : whole.cells[std::size_t(*cell)])
        for (const int v : whole.faces[std::size_t(f)])
          if (local.emplace(v, int(vertices.size())).second)
            vertices.push_back(v);
    for (const int v : vertices)
      out.vertices.push_back(whole.vertices[std::size_t(v)]);
    for (const std::int64_t cell : cells) {
      std::vector<FaceMesh::Ring> rings;
      for (const int f : whole.cells[std::size_t(cell)]) {
        FaceMesh::Ring ring;
        for (const int v : whole.faces[std::size_t(f)])
          ring.push_back(local.at(v));
        std::ranges::rotate(ring, ring.begin() + rank % int(ring.size()));
        rings.insert(rank % 2 ? rings.begin() : rings.end(), ring);
      }
      out.add_cell(rings);
    }
    return out;
  }

  FacePart(const FaceMesh& whole, const std::vector<int>& process, int rank)
      : mesh(cut(whole, process, rank, vertices, cells)), arrays(mesh) {
    global_vertices.assign(vertices.begin(), vertices.end());
  }
  void give(mesh::Mesh& to) {
    const insitu_array points_array = arrays.point_array();
    const insitu_faces faces = arrays.by_owner();
    to.set_points(0, &points_array, 1);
    to.set_faces(0, &faces);
    insitu_array ids = insitu_array_of(cells.data(), INSITU_INT64, std::int64_t(cells.size()), 1);
    to.set_global_ids(0, INSITU_CELL, &ids);
    ids = insitu_array_of(global_vertices.data(), INSITU_INT64,
                          std::int64_t(global_vertices.size()), 1);
    to.set_global_ids(0, INSITU_VERTEX, &ids);
  }
  void give_fields(mesh::Mesh& to, double t) {
    p.clear(), u.clear(), c.clear();
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const Vec3d x{arrays.points[3 * v], arrays.points[3 * v + 1], arrays.points[3 * v + 2]};
      p.push_back(std::sin(3 * x.x + t) + x.y * x.z);
      u.insert(u.end(), {-x.y, x.x, 0.1 * std::cos(t)});
    }
    for (const std::int64_t cell : cells)
      c.push_back(std::cos(0.1 * double(cell) + t));
    const auto give = [&](const char* name, insitu_association of, std::vector<double>& values,
                          int components) {
      const insitu_array array = insitu_array_of(
          values.data(), INSITU_FLOAT64, std::int64_t(values.size()) / components, components);
      to.set_field(0, name, of, &array, 1);
    };
    give("p", INSITU_VERTEX, p, 1);
    give("u", INSITU_VERTEX, u, 3);
    give("c", INSITU_CELL, c, 1);
  }
};

const char* const scene = R"(insitu: 1
page: false
probes:
  - {name: probes, points: {box: {min: [0, 0, -0.5], max: [3, 3, 3], counts: [4, 5, 4]}}, fields: [p, u, c], outside: nearest}
tracers:
  - {name: paths, velocity: u, kind: pathline, seeds: {box: {min: [0.5, 0.5, 0.5], max: [2.5, 2.5, 2.5], counts: [4, 4, 3]}}, fields: [p, c], output: [csv, vtp]}
  - {name: kept, velocity: u, seeds: {box: {min: [1, 1, 1], max: [2, 2, 2], counts: [3, 2, 2]}}, effects: [{boundary: slide}], output: [csv]}
  - {name: lines, velocity: u, kind: streamline, seeds: [[1, 1, 1], [1.1, 1.2, 1.7]], output: [vtp]}
frames:
  - {name: smoke, size: [40, 36], images: [color, depth, cell], volume: {field: p, opacity: [[0, 0], [1, 0.1], [5, 0.8]]}}
  - {name: lit, size: [36, 40], volume: {field: c, smooth: true, shading: true, opacity: [[-1, 0], [1, 0.5]]}}
  - {name: surfaces, size: [40, 40], images: [color, depth, cell], isosurfaces: [{field: p, values: [1, 3], opacity: 0.6, normals: smooth, color: {field: c}}, {field: c, values: [0.2], normals: smooth}], boundary: {color: {field: u, component: 0}, opacity: 0.2}}
)";

/// moves: the vertices, at each step.
std::map<std::string, std::string> run(const FaceMesh& whole, const std::vector<int>& process,
                                       int processes, bool moves) {
  const OwnFolder folder;
  const std::string out = folder / "out";
  run_processes(processes, [&](parallel::World& world) {
    FacePart part(whole, process, world.rank());
    with_session(world, scene, out, [&](api::Session& session) {
      commit::CommittedMesh& mesh = session.mesh("m").mesh;
      if (!part.cells.empty())
        part.give(mesh.mesh());
      for (int cycle = 0; cycle < 3; ++cycle) {
        if (cycle > 0 && moves) {
          for (double& x : part.arrays.points)
            x += 0.02 * std::sin(x);
          mesh.mesh().set_changed(INSITU_CHANGED_GEOMETRY);
        }
        if (!part.cells.empty())
          part.give_fields(mesh.mesh(), 0.37 * cycle);
        EXPECT_EQ(session.execute(cycle, 0.25 * cycle), "");
      }
    });
  });
  return files_of(out);
}

/// In slabs along x, or by turns.
std::vector<int> deal(const FaceMesh& mesh, int processes, bool slabs) {
  std::vector<int> process;
  double low = 1e300, high = -1e300;
  for (const Vec3d& x : mesh.vertices) {
    low = std::min(low, x.x);
    high = std::max(high, x.x);
  }
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    const Vec3d& x = mesh.vertices[std::size_t(mesh.faces[std::size_t(mesh.cells[cell][0])][0])];
    process.push_back(slabs ? std::min(processes - 1, int(processes * (x.x - low) / (high - low)))
                            : int(cell % std::size_t(processes)));
  }
  return process;
}

void expect_files_of_one(const FaceMesh& whole, bool moves) {
  const auto expected = run(whole, deal(whole, 1, true), 1, moves);
  EXPECT_GE(expected.size(), 15u);
  for (const int processes : {2, 4})
    expect_same(expected, run(whole, deal(whole, processes, processes == 2), processes, moves),
                std::to_string(processes));
}

} // namespace

TEST(ProcessPolyhedra, FilesAreThoseOfOneProcessToTheByte) {
  expect_files_of_one(fixtures::cut_hexahedra(3, 3), false);
}

TEST(ProcessPolyhedra, FilesAreThoseOfOneProcessWhereVerticesMove) {
  expect_files_of_one(fixtures::octahedra(2, 0.1), true);
}
