#include "paper/face_tests.h"

#include <vector>

#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "measure.h"

namespace insitu::bench::paper {

namespace {

using math::Vec3d;

struct Pair {
  mesh::CellVertices cell;
  Vec3d point;
};

template <mesh::Shape S>
bool in_planes(const Vec3d* x, const Vec3d& p) {
  constexpr cells::FaceTable table = cells::face_table(S);
  bool in = true, out = true; // wedges are the other way round
  for (int f = 0; f < table.face_count; ++f) {
    const auto& v = table.faces[f].vertices;
    const Vec3d a = x[v[0]];
    const double side = dot(cross(x[v[1]] - a, x[v[2]] - a), p - a);
    in &= side <= 0.0;
    out &= side >= 0.0;
  }
  return in || out;
}

bool is_in_planes(const mesh::CellVertices& cell, const Vec3d& p) {
  switch (cell.shape) {
  case mesh::Shape::tetrahedron:
    return in_planes<mesh::Shape::tetrahedron>(cell.x, p);
  case mesh::Shape::pyramid:
    return in_planes<mesh::Shape::pyramid>(cell.x, p);
  case mesh::Shape::wedge:
    return in_planes<mesh::Shape::wedge>(cell.x, p);
  case mesh::Shape::voxel:
    return in_planes<mesh::Shape::voxel>(cell.x, p);
  default:
    return in_planes<mesh::Shape::hexahedron>(cell.x, p);
  }
}

bool is_in_map(const mesh::CellVertices& cell, const Vec3d& p) {
  return cells::inverse_map(cell.shape, cell.x, p).margin >= 0.0;
}

template <class Test>
double time_one(const std::vector<Pair>& pairs, int repetitions, std::vector<char>& in,
                Test&& test) {
  Series series;
  for (int i = 0; i < repetitions; ++i)
    series.time([&] {
      for (std::size_t k = 0; k < pairs.size(); ++k)
        in[k] = test(pairs[k].cell, pairs[k].point);
    });
  return 1e9 * series.for_ratio(1) / double(pairs.size());
}

} // namespace

FaceTests time_face_tests(const mesh::MeshView& mesh, std::span<const Vec3d> points,
                          std::span<const query::Location> at, int repetitions) {
  constexpr std::size_t most = 50'000;
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < points.size() && pairs.size() < most; ++i)
    if (at[i]) {
      pairs.push_back({{}, points[i]});
      mesh::gather(mesh, at[i].cell, pairs.back().cell);
    }
  FaceTests out;
  out.cells = std::int64_t(pairs.size());
  if (pairs.empty())
    return out;
  std::vector<char> planar(pairs.size()), bilinear(pairs.size());
  out.planar_ns = time_one(pairs, repetitions, planar, is_in_planes);
  out.bilinear_ns = time_one(pairs, repetitions, bilinear, is_in_map);
  for (std::size_t k = 0; k < pairs.size(); ++k)
    out.otherwise += planar[k] != bilinear[k];
  return out;
}

} // namespace insitu::bench::paper
