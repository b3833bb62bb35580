#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "accel/tree/tree.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "core/random.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::test {

using math::Vec3d;

/// Interleaved doubles as a field view's piece.
struct TestField {
  std::vector<double> values;
  std::array<const std::byte*, 3> component;
  mesh::FieldPieceView piece;
  mesh::FieldView view;

  TestField(insitu_association association, std::size_t items, int components = 3)
      : values(items * std::size_t(components)) {
    const auto* base = reinterpret_cast<const std::byte*>(values.data());
    for (std::size_t c = 0; c < std::size_t(components); ++c)
      component[c] = base + c * sizeof(double);
    piece.component = component.data();
    piece.layout.count = std::int64_t(items);
    piece.layout.stride[0] = std::int64_t(sizeof(double)) * components;
    view = {"velocity", association, components, &piece};
  }
  TestField(const TestField&) = delete;
  void set(std::size_t item, const Vec3d& v) {
    for (std::size_t a = 0; a < 3; ++a)
      values[3 * item + a] = v[int(a)];
  }
};

/// The cube [low, high]^3 in n x n x n hexahedra with jittered inner vertices, under one tree.
class BoxMesh {
public:
  BoxMesh(int n, double low, double high, double jitter = 0.25)
      : n_(n), cell_size_((high - low) / n), tree_(memory_) {
    const int m = n + 1;
    for (int k = 0; k < m; ++k)
      for (int j = 0; j < m; ++j)
        for (int i = 0; i < m; ++i) {
          Vec3d p = Vec3d{low, low, low} + cell_size_ * Vec3d{double(i), double(j), double(k)};
          // Vertices of a face stay on it, so that the cube stays one.
          const int ijk[3] = {i, j, k};
          for (int a = 0; a < 3; ++a) {
            const double u = core::random_unit(11, points.size(), std::uint64_t(a));
            if (ijk[a] == n)
              p[a] = high;
            else if (ijk[a] > 0)
              p[a] += jitter * cell_size_ * (2.0 * u - 1.0);
          }
          points.push_back(p);
        }
    const auto id = [m](int i, int j, int k) { return std::int64_t((k * m + j) * m + i); };
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          for (const int z : {k, k + 1})
            for (const auto& [x, y] : {std::pair{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}})
              connectivity_.push_back(id(x, y, z));

    piece_.layout = mesh::CellLayout::uniform;
    piece_.uniform_shape = mesh::Shape::hexahedron;
    piece_.cell_count = n * n * n;
    piece_.vertex_count = std::int64_t(points.size());
    piece_.connectivity.data = reinterpret_cast<const std::byte*>(connectivity_.data());
    piece_.connectivity.count = piece_.cell_count;
    piece_.connectivity.stride = 8 * sizeof(std::int64_t);
    piece_.connectivity.is_int32 = false;
    piece_.id_stride = sizeof(std::int64_t);
    const auto* base = reinterpret_cast<const std::byte*>(points.data());
    for (std::size_t a = 0; a < 3; ++a)
      piece_.points.component[a] = base + a * sizeof(double);
    piece_.points.layout.count = piece_.vertex_count;
    piece_.points.layout.stride[0] = sizeof(Vec3d);
    first_cell_[1] = piece_.cell_count;
    first_vertex_[1] = piece_.vertex_count;
    view_.pieces = &piece_;
    view_.first_cell = first_cell_;
    view_.first_vertex = first_vertex_;
    view_.piece_count = 1;
    view_.free_of_folds = true;
    tree_.build(view_, core::Threads(1), accel::Builder::automatic);
  }
  BoxMesh(const BoxMesh&) = delete;

  /// Moves vertex p to f(p); the earlier points are kept for pathlines.
  template <class F>
  void move(F f) {
    earlier_ = points;
    view_.largest_displacement = 0.0;
    for (Vec3d& p : points) {
      const Vec3d to = f(p);
      for (int a = 0; a < 3; ++a)
        view_.largest_displacement = std::max(view_.largest_displacement, std::abs(to[a] - p[a]));
      p = to;
    }
    view_.earlier_points = earlier_.data();
    tree_.refit(view_, core::Threads(1));
  }
  const std::vector<Vec3d>& earlier() const { return earlier_; }

  query::Sampler sampler() const { return {view_, tree_}; }
  double cell_size() const { return cell_size_; }
  std::size_t cell_count() const { return std::size_t(piece_.cell_count); }

  /// f(x) at every vertex (at(p) of them if given).
  template <class F>
  void fill(TestField& field, F f) const {
    for (std::size_t v = 0; v < points.size(); ++v)
      field.set(v, f(points[v]));
  }
  TestField vertex_field() const { return TestField(INSITU_VERTEX, points.size()); }
  TestField cell_field() const { return TestField(INSITU_CELL, cell_count()); }

  std::vector<Vec3d> points;

private:
  int n_;
  double cell_size_;
  std::vector<std::int64_t> connectivity_;
  std::vector<Vec3d> earlier_;
  core::Memory memory_;
  mesh::PieceView piece_;
  std::int64_t first_cell_[2] = {0, 0};
  std::int64_t first_vertex_[2] = {0, 0};
  mesh::MeshView view_;
  accel::Tree tree_;
};

/// n points in the cube [low, high]^3.
inline std::vector<Vec3d> random_points(std::uint64_t seed, std::size_t n, double low,
                                        double high) {
  std::vector<Vec3d> points(n);
  for (std::size_t i = 0; i < n; ++i)
    for (int a = 0; a < 3; ++a)
      points[i][a] = low + (high - low) * core::random_unit(seed, i, std::uint64_t(a));
  return points;
}

inline bool in_cube(const Vec3d& p, double low, double high) {
  for (int a = 0; a < 3; ++a)
    if (!(p[a] >= low && p[a] <= high))
      return false;
  return true;
}

} // namespace insitu::test
