#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"

/// Flat meshes of n x n squares of size 1, whose coordinates are few binary digits, so that areas
/// of triangles of them are exact.
namespace flat_meshes {

struct Flat {
  std::vector<double> x, y;
  std::vector<std::vector<int>> cells; ///< rings

  std::size_t vertices() const { return x.size(); }
};

enum class Kind { triangles, quads, pixels, mixed };

/// jitter: inner vertices lie up to 15/64 beside the lattice; not of pixels.
inline Flat flat_mesh(int n, Kind kind, bool jitter) {
  Flat out;
  std::mt19937_64 random(7);
  const auto off = [&](int i, int j) {
    const bool inner = i > 0 && j > 0 && i < n && j < n && jitter && kind != Kind::pixels;
    return inner ? (double(random() % 31) - 15.0) / 64.0 : 0.0;
  };
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      out.x.push_back(i + off(i, j));
      out.y.push_back(j + off(i, j));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int v = i + (n + 1) * j, w = v + n + 1;
      if (kind == Kind::triangles || (kind == Kind::mixed && (i + j) % 2 == 0)) {
        out.cells.push_back({v, v + 1, w + 1});
        out.cells.push_back({w, v, w + 1}); // from another vertex
      } else {
        out.cells.push_back({v, v + 1, w + 1, w});
      }
    }
  return out;
}

/// 1: the point is to the left of the way from a to b, 0: on its line.
inline int side(const Flat& m, int a, int b, double px, double py) {
  const auto ia = std::size_t(a), ib = std::size_t(b);
  const double area = (m.x[ib] - m.x[ia]) * (py - m.y[ia]) - (m.y[ib] - m.y[ia]) * (px - m.x[ia]);
  return (area > 0) - (area < 0);
}

/// The lowest of the closed cells that hold a point of few binary digits; -1: none does. Cells go
/// round counterclockwise and are convex.
inline int owner(const Flat& m, double px, double py) {
  for (std::size_t c = 0; c < m.cells.size(); ++c) {
    const auto& ring = m.cells[c];
    bool inside = true;
    for (std::size_t v = 0; v < ring.size() && inside; ++v)
      inside = side(m, ring[v], ring[(v + 1) % ring.size()], px, py) >= 0;
    if (inside)
      return int(c);
  }
  return -1;
}

/// A flat mesh in the arrays that the library reads.
struct Arrays {
  std::vector<double> xy;
  std::vector<int> ids, offsets{0};
  std::vector<std::uint8_t> types;

  Arrays(const Flat& m, Kind kind) {
    for (std::size_t v = 0; v < m.vertices(); ++v)
      xy.insert(xy.end(), {m.x[v], m.y[v]});
    for (std::vector<int> ring : m.cells) {
      if (kind == Kind::pixels)
        std::swap(ring[2], ring[3]);
      ids.insert(ids.end(), ring.begin(), ring.end());
      offsets.push_back(int(ids.size()));
      types.push_back(ring.size() == 3 ? 5 : kind == Kind::pixels ? 8 : 9);
    }
  }
  void give(insitu::Mesh& mesh, Kind kind) {
    mesh.flat_points(insitu::Array(xy.data(), xy.size() / 2));
    if (kind == Kind::mixed)
      mesh.mixed_cells(insitu::Array(types), insitu::Array(offsets), insitu::Array(ids));
    else
      mesh.cells(kind == Kind::triangles ? insitu::Shape::triangle
                 : kind == Kind::quads   ? insitu::Shape::quad
                                         : insitu::Shape::pixel,
                 ids.data(), types.size());
  }
};

inline double linear(double x, double y) {
  return 1.0 + 2.0 * x - 3.0 * y;
}

inline std::vector<double> values_of(const Flat& m) {
  std::vector<double> out;
  for (std::size_t v = 0; v < m.vertices(); ++v)
    out.push_back(linear(m.x[v], m.y[v]));
  return out;
}

/// Vertices, points on edges, and others of few binary digits, at any height.
inline std::vector<double> points_of(const Flat& m, int n) {
  std::mt19937_64 random(11);
  std::vector<double> xyz;
  const auto add = [&](double x, double y) {
    xyz.insert(xyz.end(), {x, y, double(random() % 7) - 3.0});
  };
  for (const auto& ring : m.cells)
    for (std::size_t v = 0; v < ring.size(); ++v) {
      const auto a = std::size_t(ring[v]), b = std::size_t(ring[(v + 1) % ring.size()]);
      add(m.x[a], m.y[a]);
      for (const double t : {0.5, 0.25, 0.8125})
        add(m.x[a] + t * (m.x[b] - m.x[a]), m.y[a] + t * (m.y[b] - m.y[a]));
    }
  for (int i = 0; i < 2000; ++i)
    add(double(random() % (64 * std::uint64_t(n) + 128)) / 64 - 1,
        double(random() % (64 * std::uint64_t(n) + 128)) / 64 - 1);
  return xyz;
}

} // namespace flat_meshes
