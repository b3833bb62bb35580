#include "cells/kernels/ray_cell.h"

#include <algorithm>
#include <cmath>

#include "cells/kernels/faces.h"

namespace insitu::cells {

namespace {

using math::Vec3d;

/// Antisymmetric to the last bit.
double edge_function(const Vec3d& a, const Vec3d& b) {
  return a.x * b.y - a.y * b.x;
}

bool lower(const Vec3d& a, const Vec3d& b) {
  if (a.x != b.x)
    return a.x < b.x;
  return a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// A face is seen edge-on where its projection has less area than this, of the square of its reach
/// from the ray: what remains is rounding.
constexpr double edge_on_area = 0x1p-40;
/// So far, of that reach, a crossing may lie off the ray.
constexpr double off_the_ray = 1e-7;

double squared_reach(const Face& face, const Vec3d* q) {
  double most = 0;
  for (int k = 0; k < face.vertex_count; ++k) {
    const Vec3d& p = q[face.vertices[k]];
    most = std::max(most, p.x * p.x + p.y * p.y);
  }
  return most;
}

/// The crossing of a face that is seen edge-on: the ray runs within it from edge to edge, and
/// counts as crossing it in the middle, for both cells. False where the ray passes beside it.
bool cross_edge_on(const Face& face, const Vec3d* x, const Vec3d* q, Crossing& c) {
  const int n = face.vertex_count;
  std::uint8_t order[4];
  int place[4]; // of the face's vertices in that order
  for (int k = 0; k < n; ++k) {
    place[k] = 0;
    for (int l = 0; l < n; ++l) {
      const Vec3d &other = x[face.vertices[l]], &own = x[face.vertices[k]];
      place[k] += lower(other, own) || (!lower(own, other) && l < k) ? 1 : 0;
    }
  }
  for (int k = 0; k < n; ++k)
    order[place[k]] = face.vertices[k];
  Vec3d way; // the line that the projection is, through the ray's point (0, 0)
  for (int k = 0; k < n; ++k)
    if (const Vec3d& p = q[order[k]]; p.x * p.x + p.y * p.y > way.x * way.x + way.y * way.y)
      way = p;
  Crossing ends[2];
  ends[0].t = HUGE_VAL;
  ends[1].t = -HUGE_VAL;
  for (int k = 0; k < n; ++k) {
    int a = place[k], b = place[(k + 1) % n];
    if (a > b)
      std::swap(a, b);
    const Vec3d &p = q[order[a]], &r = q[order[b]];
    const double from = p.x * way.x + p.y * way.y, to = r.x * way.x + r.y * way.y;
    if ((from > 0) == (to > 0))
      continue;
    const double u = from / (from - to), t = (1 - u) * p.z + u * r.z;
    for (Crossing& end : ends)
      if (&end == ends ? t < end.t : t > end.t) {
        end.t = t;
        std::fill(end.weights, end.weights + n, 0.0);
        end.weights[a] = 1 - u;
        end.weights[b] = u;
      }
  }
  if (!(ends[0].t <= ends[1].t))
    return false;
  c.count = n;
  c.t = 0.5 * (ends[0].t + ends[1].t);
  for (int k = 0; k < n; ++k) {
    c.vertices[k] = order[k];
    c.weights[k] = 0.5 * (ends[0].weights[k] + ends[1].weights[k]);
  }
  return true;
}

bool cross_triangle(const Face& face, const Vec3d* x, const Vec3d* q, Crossing& c) {
  std::uint8_t v[3] = {face.vertices[0], face.vertices[1], face.vertices[2]};
  const double e0 = edge_function(q[v[1]], q[v[2]]), e1 = edge_function(q[v[2]], q[v[0]]),
               e2 = edge_function(q[v[0]], q[v[1]]);
  if (!((e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0)))
    return false;
  // Sums below must not depend on the cell's order.
  std::sort(v, v + 3, [&](std::uint8_t a, std::uint8_t b) { return lower(x[a], x[b]); });
  const double w0 = std::fabs(edge_function(q[v[1]], q[v[2]])),
               w1 = std::fabs(edge_function(q[v[2]], q[v[0]])),
               w2 = std::fabs(edge_function(q[v[0]], q[v[1]]));
  const double sum = w0 + w1 + w2;
  if (!(sum > 0.0))
    return false; // its edges belong to other faces too
  if (sum <= edge_on_area * squared_reach(face, q))
    return cross_edge_on(face, x, q, c);
  c.count = 3;
  std::copy(v, v + 3, c.vertices);
  c.weights[0] = w0 / sum;
  c.weights[1] = w1 / sum;
  c.weights[2] = w2 / sum;
  c.t = c.weights[0] * q[v[0]].z + c.weights[1] * q[v[1]].z + c.weights[2] * q[v[2]].z;
  return true;
}

/// (u, v) of the ray in the projected patch; up to two solutions of a quadratic, ascending by how
/// far they lie outside the unit square.
int invert_bilinear(const Vec3d& p00, const Vec3d& p10, const Vec3d& p11, const Vec3d& p01,
                    double (&uv)[2][2]) {
  const Vec3d e = p10 - p00, f = p01 - p00, g = (p00 - p10) + (p11 - p01), h = -p00;
  const double k2 = edge_function(g, f), k1 = edge_function(e, f) + edge_function(h, g),
               k0 = edge_function(h, e);
  double roots[2];
  int n = 0;
  double discriminant = k1 * k1 - 4 * k2 * k0;
  if (discriminant < 0 && discriminant > -1e-14 * k1 * k1)
    discriminant = 0;
  if (discriminant < 0)
    return 0;
  const double s = -0.5 * (k1 + std::copysign(std::sqrt(discriminant), k1));
  if (s != 0)
    roots[n++] = k0 / s;
  if (k2 != 0 && (n == 0 || s / k2 != roots[0]))
    roots[n++] = s / k2;
  int found = 0;
  for (int i = 0; i < n; ++i) {
    const double v = roots[i];
    const Vec3d along = e + v * g, rest = h - v * f;
    const double u = std::fabs(along.x) > std::fabs(along.y) ? rest.x / along.x : rest.y / along.y;
    if (std::isfinite(u) && std::isfinite(v)) {
      uv[found][0] = u;
      uv[found++][1] = v;
    }
  }
  return found;
}

void set_patch_point(double u, double v, const Quad& quad, const Vec3d* q, Crossing& c) {
  u = std::clamp(u, 0.0, 1.0);
  v = std::clamp(v, 0.0, 1.0);
  c.count = 4;
  std::copy(quad.vertices, quad.vertices + 4, c.vertices);
  c.weights[0] = (1 - u) * (1 - v);
  c.weights[1] = u * (1 - v);
  c.weights[2] = u * v;
  c.weights[3] = (1 - u) * v;
  c.t = 0;
  for (int k = 0; k < 4; ++k)
    c.t += c.weights[k] * q[c.vertices[k]].z;
}

/// Whether rounding moved a crossing aside, as it does where the face is seen edge-on.
bool lies_off(const Crossing& c, const Face& face, const Vec3d* q) {
  double x = 0, y = 0;
  for (int k = 0; k < c.count; ++k) {
    x += c.weights[k] * q[c.vertices[k]].x;
    y += c.weights[k] * q[c.vertices[k]].y;
  }
  return x * x + y * y > off_the_ray * off_the_ray * squared_reach(face, q);
}

double outside(double u, double v) {
  return std::max(std::max(-u, u - 1), std::max(-v, v - 1));
}

/// A quad without the corners that lie at the next one's place, as collapsed cells have them.
Face without_repeats(const Face& face, const Vec3d* x) {
  Face out = face;
  out.vertex_count = 0;
  for (int k = 0; k < 4; ++k) {
    const Vec3d &a = x[face.vertices[k]], &b = x[face.vertices[(k + 1) & 3]];
    if (a.x != b.x || a.y != b.y || a.z != b.z)
      out.vertices[out.vertex_count++] = face.vertices[k];
  }
  return out;
}

int cross_quad(const Face& face, const Vec3d* x, const Vec3d* q, Crossing* out) {
  bool positive = true, negative = true, zero = false;
  for (int k = 0; k < 4; ++k) {
    const double edge = edge_function(q[face.vertices[k]], q[face.vertices[(k + 1) & 3]]);
    positive &= edge >= 0;
    negative &= edge <= 0;
    zero |= edge == 0;
  }
  if (zero) { // as of a vertex with itself
    const Face reduced = without_repeats(face, x);
    if (reduced.vertex_count < 4)
      return reduced.vertex_count == 3 && cross_triangle(reduced, x, q, out[0]) ? 1 : 0;
  }
  const bool around = positive || negative;
  if (!around) {
    // Outside a convex projection there is nothing; a folded one may still be hit, even twice.
    bool left = true, right = true;
    for (int k = 0; k < 4; ++k) {
      const Vec3d &a = q[face.vertices[k]], &b = q[face.vertices[(k + 1) & 3]],
                  &c = q[face.vertices[(k + 2) & 3]];
      const double turn = edge_function(b - a, c - b);
      left &= turn >= 0;
      right &= turn <= 0;
    }
    if (left || right)
      return 0;
  }
  const Quad quad = canonical_order(face, x);
  double uv[2][2];
  const int n = invert_bilinear(q[quad.vertices[0]], q[quad.vertices[1]], q[quad.vertices[2]],
                                q[quad.vertices[3]], uv);
  constexpr double tolerance = 1e-9;
  if (around && n == 2 && zero &&
      std::max(outside(uv[0][0], uv[0][1]), outside(uv[1][0], uv[1][1])) <= tolerance) {
    // Through a corner and the edge across from it, say: in here, and out there.
    for (int i = 0; i < n; ++i)
      set_patch_point(uv[i][0], uv[i][1], quad, q, out[i]);
    return n;
  }
  if (around) { // exactly one crossing: the better solution
    if (n == 0)
      return 0; // no area
    const int best = n == 2 && outside(uv[1][0], uv[1][1]) < outside(uv[0][0], uv[0][1]) ? 1 : 0;
    set_patch_point(uv[best][0], uv[best][1], quad, q, out[0]);
    return !lies_off(out[0], face, q) || cross_edge_on(face, x, q, out[0]) ? 1 : 0;
  }
  int found = 0;
  for (int i = 0; i < n; ++i)
    if (outside(uv[i][0], uv[i][1]) <= tolerance)
      set_patch_point(uv[i][0], uv[i][1], quad, q, out[found++]);
  return found;
}

} // namespace

RaySpace::RaySpace(const Ray& ray) : ray_(ray) {
  const Vec3d& d = ray.direction;
  // Across the smallest component, which is never parallel.
  const double ax = std::fabs(d.x), ay = std::fabs(d.y), az = std::fabs(d.z);
  const Vec3d helper = ax <= ay && ax <= az ? Vec3d{1, 0, 0}
                       : ay <= az           ? Vec3d{0, 1, 0}
                                            : Vec3d{0, 0, 1};
  right_ = cross(d, helper);
  right_ = right_ / std::sqrt(dot(right_, right_));
  up_ = cross(d, right_);
}

Vec3d Crossing::parametric(mesh::Shape shape) const {
  double n[8] = {};
  for (int k = 0; k < count; ++k)
    n[vertices[k]] += weights[k];
  switch (shape) {
  case mesh::Shape::tetrahedron:
    return {n[1], n[2], n[3]};
  case mesh::Shape::pyramid: {
    const double base = 1 - n[4];
    if (!(base > 0))
      return {0.5, 0.5, 1};
    return {(n[1] + n[2]) / base, (n[2] + n[3]) / base, n[4]};
  }
  case mesh::Shape::wedge:
    return {n[1] + n[4], n[2] + n[5], n[3] + n[4] + n[5]};
  case mesh::Shape::voxel:
    return {n[1] + n[3] + n[5] + n[7], n[2] + n[3] + n[6] + n[7], n[4] + n[5] + n[6] + n[7]};
  default:
    return {n[1] + n[2] + n[5] + n[6], n[2] + n[3] + n[6] + n[7], n[4] + n[5] + n[6] + n[7]};
  }
}

int face_crossings(const mesh::CellVertices& cell, const RaySpace& space, Crossing* out) {
  Vec3d q[8];
  bool sides[4] = {true, true, true, true};
  for (int v = 0; v < cell.count; ++v) {
    q[v] = space(cell.x[v]);
    sides[0] &= q[v].x > 0;
    sides[1] &= q[v].x < 0;
    sides[2] &= q[v].y > 0;
    sides[3] &= q[v].y < 0;
  }
  if (sides[0] || sides[1] || sides[2] || sides[3])
    return 0;
  const FaceTable table = face_table(cell.shape);
  int n = 0;
  for (int f = 0; f < table.face_count; ++f) {
    const Face& face = table.faces[f];
    if (face.vertex_count == 3)
      n += cross_triangle(face, cell.x, q, out[n]) ? 1 : 0;
    else
      n += cross_quad(face, cell.x, q, out + n);
  }
  std::stable_sort(out, out + n, [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  return n;
}

} // namespace insitu::cells
