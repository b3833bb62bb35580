#include "advect/field/face_on_path.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "advect/integrate/control.h"
#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"

namespace insitu::advect {

using math::Vec3d;
using mesh::Shape;

namespace {

/// cells::parametric_distance from each face, which is linear in r: at + dot(slope, r).
struct Distances {
  struct Face {
    double at = 0.0;
    Vec3d slope;
    double operator()(const Vec3d& r) const { return at + dot(slope, r); }
  };
  int count = 0;
  Face faces[6];
};

Distances distances_of(Shape shape) {
  const auto distance = [shape](int face, const Vec3d& r) {
    double weight[8];
    cells::shape_functions(shape, r, weight);
    return cells::parametric_distance(shape, face, weight);
  };
  Distances d;
  d.count = cells::face_table(shape).face_count;
  for (int f = 0; f < d.count; ++f) {
    const double at = distance(f, {0, 0, 0});
    d.faces[f] = {
        at,
        {distance(f, {1, 0, 0}) - at, distance(f, {0, 1, 0}) - at, distance(f, {0, 0, 1}) - at}};
  }
  return d;
}

const Distances& distances(Shape shape) {
  static const auto table = [] {
    std::array<Distances, 16> all;
    for (const Shape s : {Shape::tetrahedron, Shape::voxel, Shape::hexahedron, Shape::wedge})
      all[std::size_t(s)] = distances_of(s);
    return all;
  }();
  return table[std::size_t(shape)];
}

cells::TrilinearMap<double> map_of(const mesh::CellVertices& cell) {
  const Vec3d* const x = cell.x;
  const Vec3d e1 = x[1] - x[0], e2 = x[2] - x[0], e3 = x[3] - x[0];
  if (cell.shape == Shape::tetrahedron)
    return {e1, e2, e3, {}, {}, {}, {}};
  if (cell.shape == Shape::wedge)
    return {e1, e2, e3, {}, (x[4] - x[0]) - e1 - e3, (x[5] - x[0]) - e2 - e3, {}};
  return cells::trilinear_map(cell.shape, x);
}

/// Newton's step at coordinates q towards a place on a path, and the coordinates' rate with theta.
struct Towards {
  Vec3d step, rate;
  bool singular;
};
Towards towards(const cells::TrilinearMap<double>& map, const Vec3d& vertex, const DenseStep& path,
                double theta, const Vec3d& q) {
  Vec3d x, a, b, c;
  map(q, x, a, b, c);
  const auto n = cells::newton_step(a, b, c, path.at(theta) - vertex - x);
  return {n.step, n.towards(path.rate(theta)), n.singular};
}

/// Whether all distances from faces at q, found but for `error`, are sure to be positive; those
/// from faces that are no ends may be rounding.
bool is_inside(const Distances& all, unsigned along, const Vec3d& q, double error) {
  for (int f = 0; f < all.count; ++f) {
    const double least = (along >> f & 1U) == 0 ? error : -control::on_face;
    if (!(all.faces[f](q) > least))
      return false;
  }
  return true;
}

} // namespace

PlaceOnPath face_on_path(const mesh::CellVertices& cell, unsigned along, const DenseStep& path,
                         double low, double high, const Vec3d& r) {
  constexpr int most_iterations = 12;
  // Quadratic convergence: what is left after a step this small is far below control::on_face.
  constexpr double small = 1e-7, beyond = 0.1 * control::on_face, near_low = 1e-5;
  // On the inside of the face, whatever the last digit: who asks for the place's cell gets this
  // one.
  constexpr double aim = 0.05 * control::on_face;
  const Distances& all = distances(cell.shape);
  if (all.count == 0)
    return {};
  const cells::TrilinearMap<double> map = map_of(cell);
  const auto is_end = [along](int f) { return (along >> f & 1U) == 0; };
  Vec3d q = r;
  double theta = high;
  int face = -1;
  for (int i = 0; i < most_iterations; ++i) {
    const Towards n = towards(map, cell.x[0], path, theta, q);
    const Vec3d& w = n.rate;
    q += n.step;
    if (n.singular)
      return {};
    if (face < 0) { // that which the path, if it were straight, would come to first
      double first = high;
      for (int f = 0; f < all.count; ++f) {
        const double distance = all.faces[f](q), slope = dot(all.faces[f].slope, w);
        if (is_end(f) && distance < 0.0 && slope < 0.0 && theta - distance / slope < first) {
          first = theta - distance / slope;
          face = f;
        }
      }
      if (face < 0)
        return {};
    }
    const double slope = dot(all.faces[face].slope, w);
    const double change = (aim - all.faces[face](q)) / slope;
    theta += change;
    q += change * w;
    if (!(slope < 0.0 && theta > low && theta < high))
      return {};
    if (!(cells::largest_of(n.step) + std::abs(change) * cells::largest_of(w) < small))
      continue;
    int worst = face;
    double depth = -beyond;
    for (int f = 0; f < all.count; ++f)
      if (const double distance = all.faces[f](q); is_end(f) && distance < depth) {
        depth = distance;
        worst = f;
      }
    if (worst == face) {
      // Not out and in again before: halfway it is inside.
      const double half = 0.5 * (theta - low);
      Vec3d middle = q - half * w;
      for (int k = 0; k < 3 && theta > low + near_low; ++k) {
        const Towards m = towards(map, cell.x[0], path, low + half, middle);
        middle += m.step;
        if (!m.singular && is_inside(all, along, middle, cells::largest_of(m.step)))
          return {theta, q};
      }
      return {};
    }
    face = worst; // it went out through that one before
  }
  return {};
}

bool is_inside_before(const mesh::CellVertices& cell, unsigned along, const DenseStep& path,
                      const Vec3d& r) {
  const Distances& all = distances(cell.shape);
  if (all.count == 0)
    return false;
  const cells::TrilinearMap<double> map = map_of(cell);
  Vec3d q = r;
  Towards n = towards(map, cell.x[0], path, 1.0, q);
  for (const double theta : {0.75, 0.5, 0.25}) {
    q += n.step - 0.25 * n.rate;
    n = towards(map, cell.x[0], path, theta, q);
    // What is left after the step is a part of it.
    const double error = cells::largest_of(n.step);
    if (n.singular || !(error < 0.1))
      return false;
    if (!is_inside(all, along, q + n.step, error))
      return false;
  }
  return true;
}

} // namespace insitu::advect
