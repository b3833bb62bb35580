#pragma once

#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <vector>

#include "advect/pathlines.h"
#include "fixtures/committed.h"

namespace insitu::test {

using Flow = std::function<Vec3d(const Vec3d&, double)>;

/// A solver that makes its mesh anew: cells, vertices and velocity lie in arrays of each step's
/// own, and those of the step before are overwritten as soon as the next one is there.
class Remeshed {
public:
  explicit Remeshed(int thread_limit = 0) : threads(thread_limit), mesh("remeshed", memory) {}
  Remeshed(const Remeshed&) = delete;

  /// The unit cube, of a kind of cells, with `at` of its points as vertices.
  static TestMesh cube(MeshKind kind, int size, std::uint64_t seed,
                       const std::function<Vec3d(const Vec3d&)>& at = nullptr) {
    TestMesh mesh = make_mesh({.kind = kind, .size = size}, seed);
    for (Vec3d& p : mesh.vertices) {
      p = p / double(size);
      p = at ? at(p) : p;
    }
    return mesh;
  }

  /// Other cells, and the flow at their vertices at a time.
  void remesh(const TestMesh& from, const Flow& flow, double time) {
    std::unique_ptr<Step> old = std::exchange(step_, std::make_unique<Step>(from));
    const insitu_array points = step_->arrays.point_array();
    const insitu_cells cells = step_->arrays.cells();
    mesh.mesh().set_points(0, &points, 1);
    mesh.mesh().set_cells(0, &cells);
    give_velocity(flow, time);
    if (old) {
      std::fill(old->arrays.points.begin(), old->arrays.points.end(), 7e77);
      std::fill(old->arrays.ids.begin(), old->arrays.ids.end(), 0x7fffffff);
      std::fill(old->arrays.types.begin(), old->arrays.types.end(), std::uint8_t(255));
      std::fill(old->velocity.begin(), old->velocity.end(), 7e77);
    }
    old_.push_back(std::move(old));
    commit();
  }
  /// The same cells, their vertices moved.
  void move(const std::function<Vec3d(const Vec3d&)>& to, const Flow& flow, double time) {
    for (std::size_t i = 0; i < step_->arrays.points.size(); i += 3) {
      const double* p = &step_->arrays.points[i];
      const Vec3d x = to({p[0], p[1], p[2]});
      for (std::size_t a = 0; a < 3; ++a)
        step_->arrays.points[i + a] = x[int(a)];
    }
    give_velocity(flow, time);
    mesh.mesh().set_changed(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS);
    commit();
  }
  void keep(bool with_cells = true) { mesh.keep_earlier({{"v", 1}}, with_cells, threads); }

  mesh::FieldView velocity() const { return mesh.mesh().field("v"); }
  std::optional<advect::StepBefore> before() const {
    if (!mesh.earlier_mesh())
      return std::nullopt;
    return advect::StepBefore{mesh.earlier_mesh()->sampler(), *mesh.earlier_mesh()->field("v"), {}};
  }

  core::Memory memory;
  core::Threads threads;
  core::Log log{INSITU_LOG_ERROR, [](insitu_log_level, const char*, void*) {}, nullptr};
  commit::CommittedMesh mesh;

  /// Particles that go with the velocity through `steps` steps to `end`, as the tracer has them at
  /// 0; step s has the cells mesh_of(s). whole: the step before is given with its cells. Returns
  /// the last advance.
  template <class MeshOf>
  advect::Advance carry(advect::Tracer& tracer, const MeshOf& mesh_of, const Flow& flow, double end,
                        int steps, bool whole) {
    remesh(mesh_of(0), flow, 0.0);
    advect::Advance a = tracer.advance(mesh.sampler(), velocity(), nullptr, 0.0, 0.0, threads);
    for (int s = 1; s <= steps; ++s) {
      const double t0 = end * (s - 1) / steps, t1 = end * s / steps;
      keep();
      remesh(mesh_of(std::size_t(s)), flow, t1);
      const auto earlier = before();
      EXPECT_TRUE(earlier);
      a = tracer.advance(mesh.sampler(), velocity(), nullptr, t0, t1, threads, nullptr,
                         whole ? &*earlier : nullptr);
      EXPECT_EQ(a.counts.sum(), tracer.counts().seeded);
      EXPECT_EQ(a.blended_velocity, whole);
    }
    return a;
  }

private:
  struct Step {
    explicit Step(const TestMesh& mesh) : arrays(mesh) {}
    fixtures::SolverArrays arrays;
    std::vector<double> velocity;
  };
  void give_velocity(const Flow& flow, double time) {
    step_->velocity.clear();
    const std::vector<double>& x = step_->arrays.points;
    for (std::size_t i = 0; i < x.size(); i += 3) {
      const Vec3d v = flow({x[i], x[i + 1], x[i + 2]}, time);
      step_->velocity.insert(step_->velocity.end(), {v.x, v.y, v.z});
    }
    const insitu_array array =
        insitu_array_of(step_->velocity.data(), INSITU_FLOAT64, step_->arrays.vertex_count(), 3);
    mesh.mesh().set_field(0, "v", INSITU_VERTEX, &array, 1);
  }
  void commit() {
    mesh.commit(threads, log, memory, false);
    mesh.look_for_folds(threads);
  }

  std::unique_ptr<Step> step_;
  std::vector<std::unique_ptr<Step>> old_;
};

} // namespace insitu::test
