// A field that is 0 at the vertices of a face, edge or cell's vertex is 0 on it, to the bit, for
// every way to ask.
#include <gtest/gtest.h>

#include "../advect/box_mesh.h"
#include "../advect/lane_runs.h"
#include "cells/kernels/faces.h"
#include "cells/kernels/on_feature.h"
#include "fixtures/committed.h"

namespace insitu::test {
namespace {

/// A mesh whose vertices lie on a grid so coarse that dyadic points of faces and edges are exact.
TestMesh on_a_grid(MeshKind kind) {
  TestMesh mesh = make_mesh({.kind = kind, .size = 3, .jitter = 0.2}, 17);
  for (Vec3d& p : mesh.vertices)
    for (int a = 0; a < 3; ++a)
      p[a] = std::round(p[a] * 64.0) / 64.0;
  return mesh;
}

/// Points of the feature with these corners, in order around it.
std::vector<Vec3d> points_on(const std::vector<Vec3d>& x) {
  std::vector<Vec3d> points;
  for (int i = 1; i < 8; ++i)
    for (int j = 1; j < 8; ++j) {
      const double u = i / 8.0, v = j / 8.0;
      if (x.size() == 1)
        return {x[0]};
      if (x.size() == 2)
        points.push_back((1 - u) * x[0] + u * x[1]);
      else if (x.size() == 3 && i + j < 8)
        points.push_back((1 - u - v) * x[0] + u * x[1] + v * x[2]);
      else if (x.size() == 4)
        points.push_back((1 - u) * (1 - v) * x[0] + u * (1 - v) * x[1] + u * v * x[2] +
                         (1 - u) * v * x[3]);
    }
  return points;
}

class Weights : public ::testing::TestWithParam<MeshKind> {};

TEST_P(Weights, AreZeroBesideTheFeatureThatHoldsThePoint) {
  const TestMesh from = on_a_grid(GetParam());
  fixtures::Committed m(from);
  std::vector<double> values(from.vertices.size());
  const insitu_array array =
      insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
  m.mesh.mesh().set_field(0, "f", INSITU_VERTEX, &array, 1);
  m.commit();
  m.mesh.look_for_folds(m.threads);
  const query::Sampler sampler = m.sampler();
  const mesh::FieldView field = m.mesh.mesh().field("f");
  Random random(3);
  std::int64_t on_boundary = 0;
  const auto try_feature = [&](const MeshCell& cell, const std::uint8_t* local, int count) {
    for (double& value : values)
      value = random.uniform(1.0, 1e3);
    std::vector<Vec3d> x;
    for (int k = 0; k < count; ++k) {
      const auto v = std::size_t(cell.vertices[local[k]]);
      values[v] = 0.0;
      x.push_back(from.vertices[v]);
    }
    const std::vector<Vec3d> points = points_on(x);
    std::vector<query::Location> serial(points.size()), batch(points.size());
    std::vector<std::uint8_t> reasons(points.size());
    sampler.locate_serial(points, serial);
    sampler.locate(m.threads, points, batch, {}, reasons);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_GE(reasons[i], std::uint8_t(query::Reason::on_face)) << i;
      ++on_boundary;
      for (const query::Location& at : {sampler.locate(points[i]), serial[i], batch[i]}) {
        double value = NAN;
        ASSERT_TRUE(at);
        sampler.interpolate(field, at, &value);
        ASSERT_EQ(value, 0.0) << "point " << i << " of a feature of " << count << " vertices";
      }
    }
  };
  for (std::size_t c = 0; c < from.cells.size(); c += 3) {
    const MeshCell& cell = from.cells[c];
    const cells::FaceTable table = cells::face_table(cell.shape);
    for (int f = 0; f < table.face_count; ++f)
      try_feature(cell, table.faces[f].vertices, table.faces[f].vertex_count);
    for (int e = 0; e < table.edge_count; ++e)
      try_feature(cell, table.edges[e].vertices, 2);
    for (std::uint8_t v = 0; v < table.vertex_count; ++v)
      try_feature(cell, &v, 1);
  }
  EXPECT_GT(on_boundary, 1000);
}

INSTANTIATE_TEST_SUITE_P(AllKinds, Weights, ::testing::ValuesIn(all_kinds));

TEST(Weights, OfAnyCoordinatesPutOnAFeatureAreZeroBesideIt) {
  // Also coordinates that rounding, or a cell that is all but flat, has somewhere else.
  Random random(4);
  for (const Shape shape : all_shapes) {
    const cells::FaceTable table = cells::face_table(shape);
    const auto try_on = [&](cells::Reason reason, int feature) {
      const cells::Decision decision(reason, feature);
      ASSERT_EQ(decision.reason(), reason);
      ASSERT_EQ(decision.feature(), feature);
      const unsigned on = cells::vertices_of(shape, decision);
      for (int i = 0; i < 1000; ++i) {
        const Vec3d r = random.uniform({-0.001, -0.001, -0.001}, {1.001, 1.001, 1.001});
        double weight[8], sum = 0.0;
        cells::shape_functions(shape, cells::put_on(shape, decision, r), weight);
        for (int v = 0; v < table.vertex_count; ++v) {
          const double beside = (on >> v & 1U) == 0 ? weight[v] : 0.0;
          ASSERT_EQ(beside, 0.0) << int(shape) << " " << int(reason) << " " << feature;
          sum += weight[v];
        }
        ASSERT_NEAR(sum, 1.0, 1e-12);
      }
    };
    for (int f = 0; f < table.face_count; ++f)
      try_on(cells::Reason::on_face, f);
    for (int e = 0; e < table.edge_count; ++e)
      try_on(cells::Reason::on_edge, e);
    for (int v = 0; v < table.vertex_count; ++v)
      try_on(cells::Reason::on_vertex, v);
  }
}

} // namespace
} // namespace insitu::test
