#pragma once

#include <array>
#include <cmath>
#include <insitu/insitu.hpp>
#include <vector>

/// A cube in which a flow is known at all times, in cells of any kind.
namespace runs {

using Point = std::array<double, 3>;

/// Linear in space and time: what meshes of any cells say, between any two steps.
inline Point flow(const Point& x, double t) {
  return {0.1 - 0.3 * x[1] + t * (0.2 * x[2] - 0.05), 0.3 * x[0] - 0.15 + 0.1 * t * x[1],
          0.05 - 0.1 * x[2] + t * (0.1 * x[0] - 0.02)};
}
inline Point wind(const Point& x, double t) {
  return {0.1 * t, 0.1 * x[2], -0.2 * t * x[0]};
}
inline double density(const Point& x, double t) {
  return x[0] + 2 * x[1] + 3 * x[2] * t;
}

/// The way of a particle that the flow and a tenth of the wind carry, by small steps of RK4.
inline Point carried(Point x, double from, double to, double share) {
  const int steps = 2000;
  const double h = (to - from) / steps;
  const auto rate = [&](const Point& p, double t) {
    const Point u = flow(p, t), w = wind(p, t);
    return Point{u[0] + share * w[0], u[1] + share * w[1], u[2] + share * w[2]};
  };
  const auto on = [](const Point& p, double dt, const Point& v) {
    return Point{p[0] + dt * v[0], p[1] + dt * v[1], p[2] + dt * v[2]};
  };
  for (int s = 0; s < steps; ++s) {
    const double t = from + s * h;
    const Point a = rate(x, t), b = rate(on(x, h / 2, a), t + h / 2),
                c = rate(on(x, h / 2, b), t + h / 2), d = rate(on(x, h, c), t + h);
    for (std::size_t i = 0; i < 3; ++i)
      x[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  return x;
}

/// The unit cube in n^3 cells, each of them one hexahedron or six tetrahedra; its inner vertices
/// are shifted.
struct Cube {
  std::vector<double> points, velocity, winds, density;
  std::vector<std::int32_t> ids;
  bool tetrahedra;

  Cube(int n, bool as_tetrahedra, double shift) : tetrahedra(as_tetrahedra) {
    const int m = n + 1;
    for (int v = 0; v < m * m * m; ++v) {
      const int ijk[3] = {v % m, v / m % m, v / m / m};
      for (int a = 0; a < 3; ++a)
        points.push_back((ijk[a] + (ijk[a] % n == 0 ? 0.0 : shift * std::sin(v + a))) / n);
    }
    for (int c = 0; c < n * n * n; ++c) {
      const int i = c % n, j = c / n % n, k = c / n / n;
      const auto id = [&](int corner) {
        return ((k + (corner >> 2)) * m + j + (corner >> 1 & 1)) * m + i + (corner & 1);
      };
      if (tetrahedra) {
        for (const auto& [a, b] : {std::pair{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}})
          ids.insert(ids.end(), {id(0), id(a), id(b), id(7)});
      } else {
        for (const int corner : {0, 1, 3, 2, 4, 5, 7, 6})
          ids.push_back(id(corner));
      }
    }
  }
  void fill(double time) {
    velocity.clear();
    winds.clear();
    density.clear();
    for (std::size_t v = 0; v < points.size(); v += 3) {
      const Point x{points[v], points[v + 1], points[v + 2]};
      for (const double u : flow(x, time))
        velocity.push_back(u);
      for (const double w : wind(x, time))
        winds.push_back(w);
      density.push_back(runs::density(x, time));
    }
  }
  void give(insitu::Mesh& mesh, double time) {
    fill(time);
    mesh.points(insitu::Array(points).components(3));
    mesh.cells(tetrahedra ? insitu::Shape::tetrahedron : insitu::Shape::hexahedron, ids);
    give_fields(mesh);
  }
  void give_fields(insitu::Mesh& mesh) {
    mesh.vertex_field("velocity", insitu::Array(velocity).components(3));
    mesh.vertex_field("wind", insitu::Array(winds).components(3));
    mesh.vertex_field("density", density);
  }
};

} // namespace runs
