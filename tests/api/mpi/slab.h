#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <insitu/insitu.hpp>
#include <vector>

/// What a process has of a mesh that is cut into slabs.
namespace {

constexpr int side = 6; ///< cells along each axis, of moved vertices

/// The slab [first, last) of cells along z, with the numbers that these have in the whole.
struct Slab {
  int first, last;
  std::vector<double> points, p, c, u;
  std::vector<std::int32_t> connectivity;
  std::vector<std::int64_t> cells, vertices;

  Slab(int first_layer, int last_layer) : first(first_layer), last(last_layer) {
    constexpr int n = side + 1;
    const auto local = [&](int i, int j, int k) { return ((k - first) * n + j) * n + i; };
    for (int k = first; k <= last; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          vertices.push_back((k * n + j) * n + i);
    for (int k = first; k < last; ++k)
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
          cells.push_back((k * side + j) * side + i);
          for (const auto [di, dj, dk] : {std::array{0, 0, 0},
                                          {1, 0, 0},
                                          {1, 1, 0},
                                          {0, 1, 0},
                                          {0, 0, 1},
                                          {1, 0, 1},
                                          {1, 1, 1},
                                          {0, 1, 1}})
            connectivity.push_back(local(i + di, j + dj, k + dk));
        }
    step(0);
  }
  bool empty() const { return first == last; }
  /// Vertices and values of a cycle, each a function of its number.
  void step(int cycle) {
    constexpr int n = side + 1;
    points.clear();
    p.clear();
    c.clear();
    u.clear();
    for (const std::int64_t v : vertices) {
      const double i = double(v % n), j = double(v / n % n), k = double(v / n / n);
      points.insert(points.end(), {i + 0.2 * std::sin(j + k), j + 0.2 * std::cos(i + 0.1 * cycle),
                                   k + 0.1 * std::sin(i * j)});
      p.push_back(std::sin(i + 0.3 * cycle) + 0.1 * k);
      u.insert(u.end(), {3.0 - j, i - 3.0, 0.3 * std::cos(0.3 * cycle)});
    }
    for (const std::int64_t cell : cells)
      c.push_back(std::cos(double(cell) + cycle));
  }
  /// Once; the arrays stay where they are.
  void give(insitu::Mesh& mesh) const {
    if (empty())
      return;
    insitu::Piece piece = mesh.piece(0);
    piece.points(points);
    piece.hexahedra(connectivity);
    piece.global_ids(insitu::Association::cell, cells);
    piece.global_ids(insitu::Association::vertex, vertices);
    piece.vertex_field("p", p);
    piece.cell_field("c", c);
    piece.vertex_field("u", insitu::Array(u).components(3));
  }
};

} // namespace
