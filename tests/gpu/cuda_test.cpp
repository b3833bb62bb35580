// The CUDA backend answers as the CPU does: ids, the bits of coordinates and values, reasons.
#include <cstdlib>
#include <gtest/gtest.h>

#include "core/status.h"
#include "cuda_mesh.h"
#include "workload/mesh.h"
#include "workload/queries.h"

using namespace insitu;
using namespace insitu::test;

TEST_F(Cuda, AnswersAsTheCpuOnEveryShape) {
  for (const test::Case& c : test::cases) {
    const test::TestMesh from = test::make_mesh(c.options, 11);
    GpuMesh mesh(from);
    mesh.commit();
    std::vector<Vec3d> points = test::hard_points(from, 20000, 12);
    points.insert(points.end(), from.vertices.begin(), from.vertices.end());
    mesh.check(points, c.name);
    EXPECT_EQ(mesh.locator->report().primitives, std::int64_t(from.cells.size())) << c.name;
  }
}

TEST_F(Cuda, AnswersWhateverIsAsked) {
  const test::TestMesh from = one_shape(test::MeshKind::mixed, 5, 0.2, 3);
  GpuMesh mesh(from);
  mesh.commit();
  const std::vector<Vec3d> points = test::hard_points(from, 3000, 4);
  const std::vector<mesh::FieldView> fields = mesh.fields();
  const Answers all = on_gpu(*mesh.locator, points, INSITU_EXACT, fields);
  query::DeviceQuery query;
  query.points = &points[0].x;
  query.count = std::int64_t(points.size());
  query.accuracy = INSITU_EXACT;
  Answers some(points.size(), fields);
  query.cells = some.cells.data();
  mesh.locator->locate(query);
  EXPECT_EQ(some.cells, all.cells);
  query.cells = nullptr;
  query.reasons = some.reasons.data();
  mesh.locator->locate(query);
  EXPECT_EQ(some.reasons, all.reasons);
  query.reasons = nullptr;
  double* values[] = {some.values[1].data()};
  query.fields = std::span(fields).subspan(1); // the cells' alone
  query.values = values;
  mesh.locator->locate(query);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_TRUE(same_bits(some.values[1][i], all.values[1][i]));
  // More fields than a launch takes.
  std::vector<mesh::FieldView> many(70, fields[0]);
  const Answers repeated = on_gpu(*mesh.locator, points, INSITU_EXACT, many);
  for (const auto& v : repeated.values)
    for (std::size_t k = 0; k < v.size(); ++k)
      ASSERT_TRUE(same_bits(v[k], all.values[0][k]));
  // Nothing.
  query = {};
  EXPECT_EQ(mesh.locator->locate(query).by_tree, 0);
}

TEST_F(Cuda, FollowsMovedVertices) {
  for (const test::Case& c : test::cases) {
    const test::TestMesh from = test::make_mesh(c.options, 31);
    GpuMesh mesh(from);
    mesh.commit();
    for (int step = 0; step < 3; ++step) {
      test::TestMesh moved = from;
      test::Random random(32 + std::uint64_t(step));
      for (std::size_t v = 0; v < from.vertices.size(); ++v) {
        Vec3d& x = moved.vertices[v];
        x.x += 0.3 * step * c.options.scale.x * (x.y - from.low.y) / c.options.scale.y;
        for (int a = 0; a < 3; ++a) {
          x[a] += random.uniform(-0.03, 0.03) * c.options.scale[a];
          mesh.on_cpu.arrays.points[3 * v + std::size_t(a)] = x[a];
        }
      }
      for (double& v : mesh.vectors)
        v += 0.5;
      mesh.on_cpu.commit(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS);
      if (step == 2)
        mesh.on_cpu.mesh.look_for_folds(mesh.on_cpu.threads);
      mesh.commit(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS);
      mesh.check(test::hard_points(moved, 5000, 33), std::string(c.name) + ", moved");
    }
  }
}

TEST_F(Cuda, ReadsArraysAsSolversKeepThem) {
  const test::TestMesh from = one_shape(test::MeshKind::hexahedra, 6, 0.2, 41);
  std::vector<Vec3d> points = test::hard_points(from, 8000, 42);
  const auto n = std::int64_t(from.cells.size()), vertices = std::int64_t(from.vertices.size());
  // Records of a vertex: a flag, x, y, z as floats, a pressure; packed, so unaligned.
#pragma pack(push, 1)
  struct Record {
    char flag;
    float x[3];
    double pressure;
  };
#pragma pack(pop)
  std::vector<Record> records(std::size_t(vertices) + 1);
  test::TestMesh rounded = from;
  for (std::size_t v = 0; v < from.vertices.size(); ++v) {
    for (int a = 0; a < 3; ++a)
      records[v].x[a] = float(from.vertices[v][a]);
    records[v].pressure = double(v);
    rounded.vertices[v] = {records[v].x[0], records[v].x[1], records[v].x[2]};
    points.push_back(rounded.vertices[v]);
  }
  // Ids from 1, of 64 bits, padded, and the cells of two pieces; the second has ghosts.
  const std::int64_t first = n / 3;
  std::vector<std::int64_t> ids;
  for (const test::MeshCell& cell : from.cells)
    for (const int v : cell.vertices)
      ids.push_back(v + 1);
  std::vector<std::uint8_t> ghosts(std::size_t(n - first), 0);
  for (std::size_t g = 0; g < ghosts.size(); g += 5)
    ghosts[g] = 1;
  GpuMesh mesh(from); // for its fixtures; registered anew
  mesh::Mesh& m = mesh.on_cpu.mesh.mesh();
  m.remove_field("v");
  m.remove_field("s");
  for (int p = 0; p < 2; ++p) {
    insitu_array x = insitu_array_of(records[0].x, INSITU_FLOAT32, vertices, 3);
    x.stride[0] = sizeof(Record);
    x.component_stride = sizeof(float);
    m.set_points(p, &x, 1);
    insitu_cells cells = insitu_cells_default();
    cells.index_base = 1;
    cells.shape = INSITU_HEXAHEDRON;
    cells.layout = p == 0 ? INSITU_LAYOUT_UNIFORM : INSITU_LAYOUT_PADDED;
    cells.count = p == 0 ? first : n - first;
    cells.connectivity =
        insitu_array_of(ids.data() + (p == 0 ? 0 : 8 * first), INSITU_INT64, cells.count, 8);
    m.set_cells(p, &cells);
  }
  const insitu_array g = insitu_array_of(ghosts.data(), INSITU_UINT8, n - first, 1);
  m.set_ghosts(1, &g, INSITU_GHOSTS_VTK);
  mesh.on_cpu.commit();
  mesh.add_fields();
  for (int p = 0; p < 2; ++p) {
    insitu_array a = insitu_array_of(&records[0].pressure, INSITU_FLOAT64, vertices, 1);
    a.stride[0] = sizeof(Record);
    m.set_field(p, "p", INSITU_VERTEX, &a, 1);
  }
  mesh.on_cpu.commit();
  mesh.commit();
  mesh.check(points, "pieces of records");
  const mesh::FieldView pressure[] = {m.field("p")};
  expect_same(on_gpu(*mesh.locator, points, INSITU_EXACT, pressure),
              mesh.on_cpu_answers(points, INSITU_EXACT, pressure), points, "pressure");
}

TEST_F(Cuda, LocatesInBlocks) {
  std::vector<float> axes[3];
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 9 + a; ++i)
      axes[a].push_back(float(i) + 0.05f * float(i * i));
  for (const auto kind :
       {INSITU_BLOCK_UNIFORM, INSITU_BLOCK_RECTILINEAR, INSITU_BLOCK_CURVILINEAR}) {
    fixtures::Committed committed;
    insitu_block block = insitu_block_default();
    block.kind = kind;
    std::vector<double> curved;
    std::vector<Vec3d> points;
    test::Random random(51);
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = 9 + a;
      block.origin[a] = -1.0;
      block.spacing[a] = 0.7;
      block.coordinates[a] =
          insitu_array_of(axes[a].data(), INSITU_FLOAT32, std::int64_t(axes[a].size()), 1);
    }
    for (int k = 0; k < 11; ++k)
      for (int j = 0; j < 10; ++j)
        for (int i = 0; i < 9; ++i) {
          curved.insert(curved.end(), {i + 0.1 * random.uniform(-1, 1), j + 0.1 * k,
                                       k + 0.1 * random.uniform(-1, 1)});
          const std::size_t v = curved.size() - 3;
          points.push_back({curved[v], curved[v + 1], curved[v + 2]});
          points.push_back(
              {axes[0][std::size_t(i)], axes[1][std::size_t(j)], axes[2][std::size_t(k)]});
          points.push_back({-1.0 + i * 0.7, -1.0 + j * 0.7, -1.0 + k * 0.7});
        }
    for (int i = 0; i < 5000; ++i)
      points.push_back(random.uniform({-2, -2, -2}, {14, 14, 14}));
    committed.mesh.mesh().set_block(0, &block);
    if (kind == INSITU_BLOCK_CURVILINEAR) {
      const insitu_array x =
          insitu_array_of(curved.data(), INSITU_FLOAT64, std::int64_t(curved.size() / 3), 3);
      committed.mesh.mesh().set_points(0, &x, 1);
    }
    committed.commit();
    const auto locator = make_locator(committed.memory);
    locator->commit(committed.mesh.mesh(), test::view_of(committed.mesh.mesh()), INSITU_CHANGED_ALL,
                    nullptr, committed.threads);
    for (const auto accuracy : {INSITU_EXACT, INSITU_STANDARD})
      expect_same(on_gpu(*locator, points, accuracy, {}),
                  on_cpu(committed.sampler(), committed.threads, points, accuracy, {}), points,
                  "block of kind " + std::to_string(int(kind)));
  }
}

// Cells given twice, and many of them: the lowest id owns whatever is met first.
TEST_F(Cuda, LowestIdOwnsWhereCellsOverlap) {
  test::TestMesh from = one_shape(test::MeshKind::mixed, 4, 0.2, 61);
  const std::vector<test::MeshCell> once = from.cells;
  for (int copy = 0; copy < 40; ++copy)
    from.cells.insert(from.cells.begin() + copy, once.begin(), once.end());
  GpuMesh mesh(from);
  mesh.commit();
  mesh.check(test::hard_points(from, 4000, 62), "cells given 41 times", {INSITU_EXACT});
}

// More undecided pairs than the list holds: points are asked again until all have their owners.
TEST_F(Cuda, ManyPointsOnVertices) {
  const test::TestMesh from = one_shape(test::MeshKind::tetrahedra, 4, 0.2, 71);
  GpuMesh mesh(from);
  mesh.commit();
  std::vector<Vec3d> points;
  for (int i = 0; points.size() < 300000; ++i)
    points.push_back(from.vertices[std::size_t(i) % from.vertices.size()]);
  mesh.check(points, "vertices", {INSITU_EXACT});
}

TEST_F(Cuda, FastAnswersAlmostAlike) {
  for (const test::Case& c : test::cases) {
    if (std::string(c.name) == "folded" || c.options.collapse > 0)
      continue;
    const test::TestMesh from = test::make_mesh(c.options, 81);
    GpuMesh mesh(from);
    mesh.commit();
    test::Random random(82);
    std::vector<Vec3d> points;
    for (int i = 0; i < 20000; ++i)
      points.push_back(random.uniform(from.low, from.high));
    const std::vector<mesh::FieldView> fields = mesh.fields();
    const Answers fast = on_gpu(*mesh.locator, points, INSITU_FAST, fields);
    const Answers exact = mesh.on_cpu_answers(points, INSITU_EXACT, fields);
    int wrong = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      wrong += fast.cells[i] != exact.cells[i];
      if (fast.cells[i] == exact.cells[i] && exact.cells[i] >= 0 && c.options.jitter < 0.3) {
        ASSERT_NEAR(fast.values[0][3 * i], exact.values[0][3 * i], 1e-3) << c.name;
      }
    }
    EXPECT_LT(wrong, c.options.jitter > 0.3 ? 200 : 40) << c.name;
    EXPECT_EQ(fast.counts.settled_on_host, 0);
  }
}

TEST_F(Cuda, RefusesWhatNoFloatHolds) {
  test::TestMesh from = one_shape(test::MeshKind::hexahedra, 3, 0.0, 95);
  GpuMesh mesh(from);
  mesh.on_cpu.arrays.points[5] = HUGE_VAL;
  try {
    mesh.commit();
    ADD_FAILURE() << "an infinite coordinate was taken";
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), INSITU_ERROR_MESH);
    EXPECT_NE(std::string(error.what()).find("piece 0, cell 0"), std::string::npos) << error.what();
  }
}

TEST_F(Cuda, MemoryIsCountedAndGivenBack) {
  core::Memory memory;
  {
    const test::TestMesh from = one_shape(test::MeshKind::hexahedra, 8, 0.2, 96);
    fixtures::Committed committed(from);
    const auto locator = make_locator(memory);
    locator->commit(committed.mesh.mesh(), test::view_of(committed.mesh.mesh()), INSITU_CHANGED_ALL,
                    nullptr, committed.threads);
    test::cells_of(*locator, from.vertices, INSITU_EXACT);
    EXPECT_EQ(memory.current(INSITU_MEMORY_DEVICE), locator->report().bytes);
    EXPECT_GT(locator->report().bytes_copied, 0);
  }
  EXPECT_EQ(memory.current(), 0);
}

// INSITU_GPU_BIG=1: a million jittered hexahedra, 10 M random points, 1 M on vertices, edges and
// faces.
TEST_F(Cuda, BigMeshAnswersAsTheCpu) {
  if (!std::getenv("INSITU_GPU_BIG"))
    GTEST_SKIP() << "INSITU_GPU_BIG is not set";
  const workload::Mesh from = workload::make_box(workload::Kind::hexahedra, 100, 0.2);
  fixtures::Committed committed;
  const insitu_array x =
      insitu_array_of(from.points.data(), INSITU_FLOAT64, from.vertex_count(), 3);
  insitu_cells cells = insitu_cells_default();
  cells.count = from.cell_count();
  cells.shape = INSITU_HEXAHEDRON;
  cells.connectivity = insitu_array_of(from.connectivity.data(), INSITU_INT32, cells.count, 8);
  committed.mesh.mesh().set_points(0, &x, 1);
  committed.mesh.mesh().set_cells(0, &cells);
  committed.commit();
  const auto locator = make_locator(committed.memory);
  locator->commit(committed.mesh.mesh(), test::view_of(committed.mesh.mesh()), INSITU_CHANGED_ALL,
                  nullptr, committed.threads);
  for (const auto& [pattern, count] :
       {std::pair(workload::Pattern::random, 10000000),
        std::pair(workload::Pattern::vertices, 333333), std::pair(workload::Pattern::edges, 333333),
        std::pair(workload::Pattern::faces, 333334)}) {
    const workload::Queries queries = workload::make_queries(from, pattern, count);
    for (const auto accuracy : {INSITU_EXACT, INSITU_STANDARD}) {
      const Answers gpu = on_gpu(*locator, queries.points, accuracy, {});
      expect_same(gpu, on_cpu(committed.sampler(), committed.threads, queries.points, accuracy, {}),
                  queries.points, workload::name(pattern));
      RecordProperty(std::string(workload::name(pattern)) +
                         (accuracy == INSITU_EXACT ? "_exact" : "_standard"),
                     std::to_string(gpu.counts.settled_on_host));
    }
  }
}
