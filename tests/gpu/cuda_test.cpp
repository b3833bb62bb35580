// The CUDA backend answers as the CPU does: ids, the bits of coordinates and values, reasons.
#include <cstdlib>
#include <gtest/gtest.h>

#include "advect/mesh_velocity.h"
#include "core/status.h"
#include "gpu_mesh.h"
#include "workload/mesh.h"
#include "workload/queries.h"

using namespace insitu;
using accel::Backend;
using accel::Method;
using math::Vec3d;

namespace {

class Cuda : public testing::Test {
protected:
  void SetUp() override {
    if (const std::string why = accel::why_unavailable(Backend::cuda); !why.empty())
      GTEST_SKIP() << why;
  }
};

std::unique_ptr<accel::DeviceLocator> make_locator(core::Memory& memory) {
  return accel::make_device_locator(Backend::cuda, Method::bvh, memory);
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (a != a && b != b);
}

struct Answers {
  std::vector<std::int64_t> cells;
  std::vector<double> parametric;
  std::vector<std::uint8_t> reasons;
  std::vector<std::vector<double>> values;
  accel::DeviceCounts counts;

  Answers(std::size_t n, std::span<const mesh::FieldView> fields)
      : cells(n, -7), parametric(3 * n, -7.0), reasons(n, 77) {
    for (const mesh::FieldView& f : fields)
      values.emplace_back(n * std::size_t(f.components), -7.0);
  }
};

Answers on_cpu(const query::Sampler& sampler, const core::Threads& threads,
               const std::vector<Vec3d>& points, insitu_accuracy accuracy,
               std::span<const mesh::FieldView> fields) {
  Answers out(points.size(), fields);
  std::vector<query::Location> at(points.size());
  sampler.locate(threads, points, at, {.accuracy = accuracy}, out.reasons);
  std::vector<double*> values;
  for (auto& v : out.values)
    values.push_back(v.data());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.cells[i] = at[i].cell;
    for (int a = 0; a < 3; ++a)
      out.parametric[3 * i + std::size_t(a)] = at[i] ? at[i].parametric[a] : nan;
    if (at[i]) {
      sampler.interpolate(fields, at[i], i, values.data());
      continue;
    }
    for (std::size_t f = 0; f < fields.size(); ++f)
      for (int c = 0; c < fields[f].components; ++c)
        out.values[f][i * std::size_t(fields[f].components) + std::size_t(c)] = nan;
  }
  return out;
}

Answers on_gpu(const accel::DeviceLocator& locator, const std::vector<Vec3d>& points,
               insitu_accuracy accuracy, std::span<const mesh::FieldView> fields) {
  Answers out(points.size(), fields);
  std::vector<double*> values;
  for (auto& v : out.values)
    values.push_back(v.data());
  accel::DeviceQuery query;
  query.points = points.empty() ? nullptr : &points[0].x;
  query.count = std::int64_t(points.size());
  query.accuracy = accuracy;
  query.cells = out.cells.data();
  query.parametric = out.parametric.data();
  query.reasons = out.reasons.data();
  query.fields = fields;
  query.values = values.data();
  out.counts = locator.locate(query);
  return out;
}

bool are_strictly_inside(std::uint8_t a) {
  return a == INSITU_REASON_CERTIFIED || a == INSITU_REASON_EXACT;
}

void expect_same(const Answers& gpu, const Answers& cpu, const std::vector<Vec3d>& points,
                 const std::string& what) {
  int wrong = 0;
  const auto fail = [&](std::size_t i, const std::string& how) {
    if (++wrong < 4)
      ADD_FAILURE() << what << ", point " << i << " (" << points[i].x << ", " << points[i].y << ", "
                    << points[i].z << "): " << how;
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (gpu.cells[i] != cpu.cells[i]) {
      fail(i,
           "cell " + std::to_string(gpu.cells[i]) + ", on the CPU " + std::to_string(cpu.cells[i]));
      continue;
    }
    for (std::size_t a = 3 * i; a < 3 * i + 3; ++a)
      if (!same_bits(gpu.parametric[a], cpu.parametric[a]))
        fail(i, "coordinate " + std::to_string(gpu.parametric[a]) + ", on the CPU " +
                    std::to_string(cpu.parametric[a]));
    if (gpu.reasons[i] != cpu.reasons[i] &&
        !(are_strictly_inside(gpu.reasons[i]) && are_strictly_inside(cpu.reasons[i])))
      fail(i, "reason " + std::to_string(gpu.reasons[i]) + ", on the CPU " +
                  std::to_string(cpu.reasons[i]));
    for (std::size_t f = 0; f < gpu.values.size(); ++f) {
      const std::size_t n = gpu.values[f].size() / points.size();
      for (std::size_t c = i * n; c < (i + 1) * n; ++c)
        if (!same_bits(gpu.values[f][c], cpu.values[f][c]))
          fail(i, "value " + std::to_string(gpu.values[f][c]) + ", on the CPU " +
                      std::to_string(cpu.values[f][c]));
    }
  }
  EXPECT_EQ(wrong, 0) << what;
}

/// A committed mesh with a vector on its vertices and a float on its cells.
struct GpuMesh {
  explicit GpuMesh(const test::TestMesh& from) : on_cpu(from) {
    add_fields();
    locator = make_locator(on_cpu.memory);
  }
  void add_fields() {
    const mesh::MeshView& view = on_cpu.mesh.mesh().view();
    test::Random random(5);
    vectors.resize(std::size_t(view.vertex_count()) * 3);
    for (double& v : vectors)
      v = random.uniform(-1, 1);
    scalars.resize(std::size_t(view.cell_count()));
    for (float& s : scalars)
      s = float(random.uniform(-1, 1));
    for (std::int32_t p = 0; p < view.piece_count; ++p) {
      const std::int64_t v = view.first_vertex[p], c = view.first_cell[p];
      insitu_array a =
          insitu_array_of(vectors.data() + 3 * v, INSITU_FLOAT64, view.first_vertex[p + 1] - v, 3);
      on_cpu.mesh.mesh().set_field(p, "v", INSITU_VERTEX, &a, 1);
      a = insitu_array_of(scalars.data() + c, INSITU_FLOAT32, view.first_cell[p + 1] - c, 1);
      on_cpu.mesh.mesh().set_field(p, "s", INSITU_CELL, &a, 1);
    }
    on_cpu.commit();
  }
  void commit(std::uint32_t what = INSITU_CHANGED_ALL) {
    locator->commit(on_cpu.mesh.mesh(), test::view_of(on_cpu.mesh.mesh()), what, nullptr,
                    on_cpu.threads);
  }
  std::vector<mesh::FieldView> fields() const {
    return {on_cpu.mesh.mesh().field("v"), on_cpu.mesh.mesh().field("s")};
  }
  void check(const std::vector<Vec3d>& points, const std::string& what,
             std::initializer_list<insitu_accuracy> accuracies = {INSITU_EXACT, INSITU_STANDARD}) {
    const std::vector<mesh::FieldView> f = fields();
    for (const insitu_accuracy accuracy : accuracies)
      expect_same(on_gpu(*locator, points, accuracy, f), on_cpu_answers(points, accuracy, f),
                  points, what + (accuracy == INSITU_EXACT ? ", exact" : ", standard"));
  }
  Answers on_cpu_answers(const std::vector<Vec3d>& points, insitu_accuracy accuracy,
                         std::span<const mesh::FieldView> f) const {
    return ::on_cpu(on_cpu.sampler(), on_cpu.threads, points, accuracy, f);
  }

  fixtures::Committed on_cpu;
  std::vector<double> vectors;
  std::vector<float> scalars;
  std::unique_ptr<accel::DeviceLocator> locator;
};

test::TestMesh one_shape(test::MeshKind kind, int size, double jitter, std::uint64_t seed) {
  return test::make_mesh({.kind = kind, .size = size, .jitter = jitter}, seed);
}

} // namespace

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
  accel::DeviceQuery query;
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

TEST_F(Cuda, ArraysAndPointsInDeviceMemory) {
  const test::TestMesh from = one_shape(test::MeshKind::wedges, 6, 0.2, 91);
  GpuMesh mesh(from);
  mesh.commit();
  const std::vector<Vec3d> points = test::hard_points(from, 20000, 92);
  const fixtures::SolverArrays& arrays = mesh.on_cpu.arrays;
  const test::OnDevice<double> x(arrays.points);
  const test::OnDevice<std::int32_t> ids(arrays.ids);
  const test::OnDevice<double> vectors(mesh.vectors);
  mesh::Mesh m("device", mesh.on_cpu.memory);
  insitu_array a = arrays.point_array();
  a.data = x.data();
  a.memory = INSITU_DEVICE;
  m.set_points(0, &a, 1);
  insitu_cells cells = arrays.cells();
  cells.connectivity.data = ids.data();
  cells.connectivity.memory = INSITU_DEVICE;
  m.set_cells(0, &cells);
  a = insitu_array_of(vectors.data(), INSITU_FLOAT64, std::int64_t(from.vertices.size()), 3);
  a.memory = INSITU_DEVICE;
  m.set_field(0, "v", INSITU_VERTEX, &a, 1);
  m.update();
  const auto locator = make_locator(mesh.on_cpu.memory);
  locator->commit(m, test::view_of(m), INSITU_CHANGED_ALL, nullptr, mesh.on_cpu.threads);
  EXPECT_EQ(locator->report().bytes_copied, 0);
  const mesh::FieldView fields[] = {m.field("v")};
  const mesh::FieldView host_fields[] = {mesh.on_cpu.mesh.mesh().field("v")};
  const Answers expected = mesh.on_cpu_answers(points, INSITU_EXACT, host_fields);
  expect_same(on_gpu(*locator, points, INSITU_EXACT, fields), expected, points, "device arrays");

  // The same, asked on a stream with all in device memory.
  cudaStream_t stream;
  ASSERT_EQ(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), cudaSuccess);
  std::vector<double> flat(&points[0].x, &points[0].x + 3 * points.size());
  const test::OnDevice<double> p(flat), parametric(flat.size()), values(flat.size());
  const test::OnDevice<std::int64_t> owners(points.size());
  const test::OnDevice<std::uint8_t> reasons(points.size());
  double* value_arrays[] = {values.data()};
  accel::DeviceQuery query;
  query.points = p.data();
  query.count = std::int64_t(points.size());
  query.on_device = true;
  query.accuracy = INSITU_EXACT;
  query.stream = stream;
  query.cells = owners.data();
  query.parametric = parametric.data();
  query.reasons = reasons.data();
  query.fields = fields;
  query.values = value_arrays;
  Answers got(points.size(), fields);
  got.counts = locator->locate(query);
  ASSERT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
  got.cells = owners.read();
  got.parametric = parametric.read();
  got.reasons = reasons.read();
  got.values = {values.read()};
  expect_same(got, expected, points, "on a stream");
  cudaStreamDestroy(stream);
}

TEST_F(Cuda, TracersMoveAsOnTheCpu) {
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::mixed}) {
    const test::TestMesh from = one_shape(kind, 8, 0.2, 97);
    GpuMesh mesh(from);
    for (std::size_t v = 0; v < from.vertices.size(); ++v) { // around the middle, and upwards
      const Vec3d r = from.vertices[v] - 0.5 * (from.low + from.high);
      mesh.vectors[3 * v] = -r.y;
      mesh.vectors[3 * v + 1] = r.x;
      mesh.vectors[3 * v + 2] = 0.3;
    }
    mesh.commit();
    const mesh::FieldView field = mesh.on_cpu.mesh.mesh().field("v");
    test::Random random(98);
    std::vector<Vec3d> seeds;
    for (int i = 0; i < 5000; ++i)
      seeds.push_back(random.uniform(from.low - Vec3d{0.5, 0.5, 0.5}, from.high));
    constexpr int steps = 100;
    constexpr double h = 0.05;
    std::vector<Vec3d> expected = seeds;
    std::vector<std::uint8_t> expected_endings;
    const query::Sampler sampler = mesh.on_cpu.sampler();
    for (Vec3d& x : expected) {
      advect::MeshVelocity velocity(sampler, field, nullptr, 0, 0, INSITU_STANDARD);
      velocity.begin(-1);
      Vec3d k1;
      int ending = velocity(x, 0, k1) == advect::Sampled::inside ? INSITU_END_ALIVE
                                                                 : INSITU_END_SEED_OUTSIDE;
      for (int n = 0; n < steps && ending == INSITU_END_ALIVE; ++n) {
        const advect::Trial trial = advect::rk4_step(velocity, x, 0, h, k1);
        if (trial.sampled != advect::Sampled::inside) {
          ending = INSITU_END_LEFT;
          break;
        }
        x = trial.x;
        k1 = trial.v;
      }
      expected_endings.push_back(std::uint8_t(ending));
    }
    const test::OnDevice<double> positions(
        std::vector<double>(&seeds[0].x, &seeds[0].x + 3 * seeds.size()));
    const test::OnDevice<std::uint32_t> cells(
        std::vector<std::uint32_t>(seeds.size(), accel::none));
    const test::OnDevice<std::uint8_t> endings(std::vector<std::uint8_t>(seeds.size(), 0));
    accel::DeviceTracers tracers;
    tracers.positions = positions.data();
    tracers.cells = cells.data();
    tracers.endings = endings.data();
    tracers.count = std::int64_t(seeds.size());
    tracers.velocity = field;
    tracers.step = h;
    tracers.steps = steps / 4; // in parts, as a solver's steps are
    for (int part = 0; part < 4; ++part)
      mesh.locator->advance(tracers);
    const std::vector<double> got = positions.read();
    const std::vector<std::uint8_t> got_endings = endings.read();
    EXPECT_EQ(got_endings, expected_endings);
    int wrong = 0;
    for (std::size_t i = 0; i < seeds.size(); ++i)
      for (int a = 0; a < 3; ++a)
        wrong += !same_bits(got[3 * i + std::size_t(a)], expected[i][a]);
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(std::count(got_endings.begin(), got_endings.end(), INSITU_END_ALIVE), 500);
    EXPECT_GT(std::count(got_endings.begin(), got_endings.end(), INSITU_END_LEFT), 500);
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
