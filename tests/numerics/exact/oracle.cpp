#include "oracle.h"

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "cases.h"
#include "cells/kernels/faces.h"

namespace insitu::test {
namespace {

using boost::multiprecision::cpp_int;
using cells::Containment;
using math::Vec3d;
using IntVec = std::array<cpp_int, 3>;

int sign(const cpp_int& a) {
  return a.sign();
}

IntVec subtract(const IntVec& a, const IntVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
IntVec cross(const IntVec& a, const IntVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
cpp_int dot(const IntVec& a, const IntVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
cpp_int determinant(const IntVec& a, const IntVec& b, const IntVec& c) {
  return dot(a, cross(b, c));
}
bool is_zero(const IntVec& a) {
  return a[0] == 0 && a[1] == 0 && a[2] == 0;
}

/// The coordinates over a common power of two.
std::vector<IntVec> to_integers(const std::vector<Vec3d>& points) {
  int lowest = 2000;
  for (const Vec3d& p : points) {
    for (int axis = 0; axis < 3; ++axis) {
      int exponent = 0;
      if (std::frexp(p[axis], &exponent) != 0.0)
        lowest = std::min(lowest, exponent - 53);
    }
  }
  std::vector<IntVec> result;
  for (const Vec3d& p : points) {
    IntVec converted;
    for (int axis = 0; axis < 3; ++axis) {
      int exponent = 0;
      const double fraction = std::frexp(p[axis], &exponent);
      const auto mantissa = static_cast<std::int64_t>(std::ldexp(fraction, 53));
      cpp_int value = mantissa < 0 ? -mantissa : mantissa;
      if (mantissa != 0)
        value <<= exponent - 53 - lowest;
      converted[axis] = mantissa < 0 ? cpp_int(-value) : value;
    }
    result.push_back(converted);
  }
  return result;
}

/// p + q sqrt(D) for the D of one quadratic.
struct Surd {
  cpp_int p, q;
};
Surd operator+(const Surd& a, const Surd& b) {
  return {a.p + b.p, a.q + b.q};
}
Surd operator-(const Surd& a, const Surd& b) {
  return {a.p - b.p, a.q - b.q};
}
Surd operator*(const cpp_int& s, const Surd& a) {
  return {s * a.p, s * a.q};
}
Surd multiply(const Surd& a, const Surd& b, const cpp_int& D) {
  return {a.p * b.p + a.q * b.q * D, a.p * b.q + a.q * b.p};
}
int sign(const Surd& a, const cpp_int& D) {
  const int sp = sign(a.p), sq = D == 0 ? 0 : sign(a.q);
  if (sp * sq >= 0)
    return sp != 0 ? sp : sq;
  return sp * sign(cpp_int(a.p * a.p - a.q * a.q * D));
}

/// What one face says of the ray. No value: ask again with another ray.
struct FaceAnswer {
  bool on_face = false;
  int crossings = 0;
};
using Answer = std::optional<FaceAnswer>;

/// Where value = numerator / denominator lies against [0, 1]: 1 strictly inside, 0 at an end, -1
/// out.
int unit_interval(const Surd& numerator, const Surd& denominator, const cpp_int& D) {
  const int s = sign(denominator, D);
  const int low = s * sign(numerator, D), high = s * sign(denominator - numerator, D);
  return std::min(low, high);
}

Answer triangle(const std::array<IntVec, 4>& p, const IntVec& direction) {
  const int a = sign(determinant(direction, p[1], p[2]));
  const int b = sign(determinant(direction, p[2], p[0]));
  const int c = sign(determinant(direction, p[0], p[1]));
  if (a == 0 && b == 0 && c == 0)
    return {};
  if (std::min({a, b, c}) < 0 && std::max({a, b, c}) > 0)
    return FaceAnswer{};
  const int ahead = sign(determinant(p[0], p[1], p[2])) * (a + b + c > 0 ? 1 : -1);
  if (ahead < 0)
    return FaceAnswer{};
  if (a == 0 || b == 0 || c == 0)
    return {}; // through an edge; the point is on none
  return ahead == 0 ? FaceAnswer{true, 0} : FaceAnswer{false, 1};
}

Answer patch(const std::array<IntVec, 4>& p, const IntVec& direction, bool swapped = false) {
  // S(u, v) from the point, along the ray (h) and along two directions across it (f, g): each is
  // k0 + k1 u + k2 v + k3 u v. Corners p00, p10, p11, p01.
  const IntVec& D = direction;
  const auto along = [&p](const IntVec& n) {
    const cpp_int k00 = dot(n, p[0]), k10 = dot(n, p[1]), k11 = dot(n, p[2]), k01 = dot(n, p[3]);
    return std::array<cpp_int, 4>{k00, k10 - k00, k01 - k00, k00 - k10 - k01 + k11};
  };
  const auto f = along({D[1], -D[0], 0}), g = along({0, D[2], -D[1]}), h = along(D);
  const cpp_int A = f[1] * g[3] - g[1] * f[3];
  const cpp_int B = f[0] * g[3] + f[1] * g[2] - g[0] * f[3] - g[1] * f[2];
  const cpp_int C = f[0] * g[2] - g[0] * f[2];
  const bool planar =
      determinant(subtract(p[1], p[0]), subtract(p[2], p[0]), subtract(p[3], p[0])) == 0;

  if (A == 0 && B == 0) {
    if (C != 0)
      return FaceAnswer{};
    // Every u has a solution: a planar patch that shrinks to the point along a line v = constant.
    return swapped ? Answer() : patch({p[0], p[3], p[2], p[1]}, direction, true);
  }
  const cpp_int discriminant = A == 0 ? cpp_int(0) : cpp_int(B * B - 4 * A * C);
  if (discriminant < 0)
    return FaceAnswer{};
  const bool doubled = A != 0 && discriminant == 0;
  const Surd W = {A == 0 ? B : cpp_int(2 * A), 0};
  int crossings = 0, hits = 0;
  for (int root = 0; root < (A == 0 || doubled ? 1 : 2); ++root) {
    const Surd U = A == 0 ? Surd{-C, 0} : Surd{-B, root == 0 ? 1 : -1};
    // First u: a planar patch may shrink to a point along a line u = constant beyond it.
    const int inside_u = unit_interval(U, W, discriminant);
    if (inside_u < 0)
      continue;
    Surd M = f[2] * W + f[3] * U, N = {0, 0};
    if (sign(M, discriminant) != 0) {
      N = Surd{0, 0} - (f[0] * W + f[1] * U);
    } else {
      M = g[2] * W + g[3] * U;
      N = Surd{0, 0} - (g[0] * W + g[1] * U);
      if (sign(M, discriminant) == 0) {
        if (sign(N, discriminant) == 0 && sign(f[0] * W + f[1] * U, discriminant) == 0)
          return {};
        continue; // v at infinity
      }
    }
    const int inside = std::min(inside_u, unit_interval(N, M, discriminant));
    if (inside < 0)
      continue;
    const Surd height = multiply(h[0] * W + h[1] * U, M, discriminant) +
                        multiply(h[2] * W + h[3] * U, N, discriminant);
    const int ahead = sign(height, discriminant) * sign(W, discriminant) * sign(M, discriminant);
    if (ahead < 0)
      continue;
    if (ahead == 0) {
      hits += doubled ? 2 : 1;
    } else if (inside == 0 || doubled) {
      return {};
    } else {
      ++crossings;
    }
  }
  // A plane patch that folds back covers some of its plane twice: that is no boundary.
  return FaceAnswer{planar ? hits % 2 != 0 : hits != 0, crossings};
}

bool on_segment(const IntVec& a, const IntVec& b) {
  return is_zero(cross(a, b)) && dot(a, b) <= 0;
}

bool collinear(const std::array<IntVec, 4>& p, int count) {
  for (int k = 0; k < count; ++k) {
    for (int l = 0; l < k; ++l) {
      for (int m = 0; m < l; ++m) {
        if (!is_zero(cross(subtract(p[k], p[m]), subtract(p[l], p[m]))))
          return false;
      }
    }
  }
  return true;
}

} // namespace

Containment oracle_contain(mesh::Shape shape, const Vec3d* vertices, const Vec3d& point,
                           std::uint64_t seed) {
  const cells::FaceTable table = cells::face_table(shape);
  std::vector<Vec3d> points(vertices, vertices + table.vertex_count);
  points.push_back(point);
  std::vector<IntVec> r = to_integers(points);
  for (int i = 0; i < table.vertex_count; ++i) {
    r[i] = subtract(r[i], r[table.vertex_count]);
    if (is_zero(r[i]))
      return Containment::on_vertex;
  }
  for (int i = 0; i < table.edge_count; ++i) {
    const auto& v = table.edges[i].vertices;
    if (on_segment(r[v[0]], r[v[1]]))
      return Containment::on_edge;
  }
  std::mt19937_64 random(seed);
  const auto component = [&random] {
    return cpp_int(static_cast<std::int64_t>(random() % 4001) - 2000);
  };
  for (int attempt = 0; attempt < 100; ++attempt) {
    IntVec direction = {component(), component(), component()};
    if (direction[1] == 0)
      direction[1] = 1; // f and g need it
    int crossings = 0;
    bool generic = true;
    for (int i = 0; i < table.face_count && generic; ++i) {
      const cells::Face& face = table.faces[i];
      std::array<IntVec, 4> p;
      for (int k = 0; k < face.vertex_count; ++k)
        p[k] = r[face.vertices[k]];
      if (collinear(p, face.vertex_count))
        continue; // its edges have been asked
      const Answer answer = face.vertex_count == 3 ? triangle(p, direction) : patch(p, direction);
      generic = answer.has_value();
      if (!generic)
        break;
      if (answer->on_face)
        return Containment::on_face;
      crossings += answer->crossings;
    }
    if (generic)
      return crossings % 2 != 0 ? Containment::inside : Containment::outside;
  }
  throw std::runtime_error("oracle: no generic ray found, seed " + std::to_string(seed) + ", " +
                           describe(shape, vertices, point));
}

} // namespace insitu::test
