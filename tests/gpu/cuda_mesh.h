#pragma once

#include <bit>
#include <gtest/gtest.h>

#include "gpu_mesh.h"

/// Meshes on a CUDA device beside the CPU's, and answers of both.
namespace insitu::test {

using accel::Backend;
using accel::Method;
using math::Vec3d;

/// Skips where there is no device.
class Cuda : public testing::Test {
protected:
  void SetUp() override {
    if (const std::string why = query::why_unavailable(Backend::cuda); !why.empty())
      GTEST_SKIP() << why;
  }
};

inline std::unique_ptr<query::DeviceLocator> make_locator(core::Memory& memory) {
  return query::make_device_locator(Backend::cuda, Method::bvh, memory);
}

inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (a != a && b != b);
}

/// All that is told of some points.
struct Answers {
  std::vector<std::int64_t> cells;
  std::vector<double> parametric;
  std::vector<std::uint8_t> reasons;
  std::vector<std::vector<double>> values;
  query::DeviceCounts counts;

  Answers(std::size_t n, std::span<const mesh::FieldView> fields)
      : cells(n, -7), parametric(3 * n, -7.0), reasons(n, 77) {
    for (const mesh::FieldView& f : fields)
      values.emplace_back(n * std::size_t(f.components), -7.0);
  }
};

inline Answers on_cpu(const query::Sampler& sampler, const core::Threads& threads,
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
  }
  sampler.interpolate(fields, query::Answered{at, {}}, 0, values.data());
  return out;
}

inline Answers on_gpu(const query::DeviceLocator& locator, const std::vector<Vec3d>& points,
                      insitu_accuracy accuracy, std::span<const mesh::FieldView> fields) {
  Answers out(points.size(), fields);
  std::vector<double*> values;
  for (auto& v : out.values)
    values.push_back(v.data());
  query::DeviceQuery query;
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

inline bool are_strictly_inside(std::uint8_t a) {
  return a == INSITU_REASON_CERTIFIED || a == INSITU_REASON_EXACT;
}

inline void expect_same(const Answers& gpu, const Answers& cpu, const std::vector<Vec3d>& points,
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
  explicit GpuMesh(const TestMesh& from) : on_cpu(from) {
    add_fields();
    locator = make_locator(on_cpu.memory);
  }
  void add_fields() {
    const mesh::MeshView& view = on_cpu.mesh.mesh().view();
    Random random(5);
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
    locator->commit(on_cpu.mesh.mesh(), view_of(on_cpu.mesh.mesh()), what, nullptr, on_cpu.threads);
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
    return test::on_cpu(on_cpu.sampler(), on_cpu.threads, points, accuracy, f);
  }

  fixtures::Committed on_cpu;
  std::vector<double> vectors;
  std::vector<float> scalars;
  std::unique_ptr<query::DeviceLocator> locator;
};

inline TestMesh one_shape(MeshKind kind, int size, double jitter, std::uint64_t seed) {
  return make_mesh({.kind = kind, .size = size, .jitter = jitter}, seed);
}

} // namespace insitu::test
