#include "query/nearest/nearest_on_cell.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "cells/kernels/faces.h"

namespace insitu::query {

using cells::Decision;
using cells::Reason;
using math::Vec3d;

namespace {

bool is_before(const Vec3d& a, const Vec3d& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

double length(const Vec3d& a) {
  return std::sqrt(math::dot(a, a));
}

Vec3d between(const Vec3d& a, const Vec3d& b, double t) {
  return a + t * (b - a); // exact where a coordinate is the same at both ends
}

/// A vertex: where it is, and as seen from the place.
struct Corner {
  Vec3d x, from;
};

/// What is nearest so far.
struct Best {
  NearestOnCell found;
  double most;

  void take(double squared, const Vec3d& point, const Decision& on) {
    if (!(squared <= most) || !(squared < found.squared))
      return;
    found = {squared, point, on};
  }
  double limit() const { return std::min(most, found.squared); }
};

/// ends: the numbers of the ends, in the cell.
void look_at_edge(Corner a, Corner b, int edge, std::pair<int, int> ends, Best& best) {
  if (is_before(b.x, a.x)) {
    std::swap(a, b);
    std::swap(ends.first, ends.second);
  }
  const Vec3d along = b.from - a.from;
  const double length = math::dot(along, along), t = -math::dot(a.from, along);
  if (!(t > 0.0))
    return best.take(math::dot(a.from, a.from), a.x, Decision(Reason::on_vertex, ends.first));
  if (!(t < length))
    return best.take(math::dot(b.from, b.from), b.x, Decision(Reason::on_vertex, ends.second));
  const Vec3d at = a.from + (t / length) * along;
  best.take(math::dot(at, at), between(a.x, b.x, t / length), Decision(Reason::on_edge, edge));
}

/// The interior of a triangle.
void look_at_triangle(const Corner* given, int face, Best& best) {
  Corner c[3] = {given[0], given[1], given[2]};
  std::sort(c, c + 3, [](const Corner& a, const Corner& b) { return is_before(a.x, b.x); });
  const Vec3d e = c[1].from - c[0].from, f = c[2].from - c[0].from;
  const Vec3d normal = math::cross(e, f);
  const double area = math::dot(normal, normal);
  if (!(area > 0.0))
    return;
  // Barycentric coordinates of the place's image in the plane.
  const double u = math::dot(math::cross(-c[0].from, f), normal) / area;
  const double v = math::dot(math::cross(e, -c[0].from), normal) / area;
  if (!(u > 0.0 && v > 0.0 && u + v < 1.0))
    return;
  const double height = math::dot(c[0].from, normal);
  best.take(height * height / area, c[0].x + u * (c[1].x - c[0].x) + v * (c[2].x - c[0].x),
            Decision(Reason::on_face, face));
}

/// A part of a bilinear patch as seen from the place: middle + a*along + b*across + a*b*twist, for
/// a and b from -1 to 1.
struct Part {
  Vec3d middle, along, across, twist;
  double u, v, half; ///< of the whole patch: the middle, and half of the width

  Vec3d at(double a, double b) const { return middle + a * along + b * across + (a * b) * twist; }
  /// The a and b for which a point of the parallelogram, without the twist, is nearest.
  std::pair<double, double> nearest() const {
    const double aa = math::dot(along, along), bb = math::dot(across, across);
    const double ab = math::dot(along, across);
    const double ma = -math::dot(middle, along), mb = -math::dot(middle, across);
    const double det = aa * bb - ab * ab;
    const auto clamped = [](double t, double length) {
      return length > 0.0 ? std::clamp(t / length, -1.0, 1.0) : 0.0;
    };
    if (det > 0.0) {
      const double a = (ma * bb - mb * ab) / det, b = (mb * aa - ma * ab) / det;
      if (std::fabs(a) <= 1.0 && std::fabs(b) <= 1.0)
        return {a, b};
    }
    std::pair<double, double> best;
    double least = std::numeric_limits<double>::infinity();
    const auto look = [&](double a, double b) {
      const Vec3d p = middle + a * along + b * across;
      const double squared = math::dot(p, p);
      if (squared < least) {
        least = squared;
        best = {a, b};
      }
    };
    for (const double side : {-1.0, 1.0}) {
      look(side, clamped(mb - side * ab, bb));
      look(clamped(ma - side * ab, aa), side);
    }
    return best;
  }
  /// Whether the squared distance is convex over all of the part, so that descent ends in its
  /// least. Its second derivatives are those of a quadratic but for the mixed one, which has the
  /// twist.
  bool is_convex() const {
    const double a = length(along), b = length(across), t = length(twist);
    const double mixed = std::fabs(math::dot(along, across)) + std::fabs(math::dot(middle, twist)) +
                         2.0 * t * (a + b + t);
    return a > t && b > t && (a - t) * (b - t) > 1.001 * mixed;
  }
  /// The a and b of the nearest point of such a part: Newton's method within the bounds, and along
  /// one of them at a time where that does not come nearer.
  std::pair<double, double> nearest_of_convex(double a, double b) const {
    Vec3d p = at(a, b);
    double least = math::dot(p, p);
    for (int step = 0; step < 50; ++step) {
      const Vec3d pa = along + b * twist, pb = across + a * twist;
      const double ga = math::dot(p, pa), gb = math::dot(p, pb);
      const double aa = math::dot(pa, pa), bb = math::dot(pb, pb);
      const double ab = math::dot(pa, pb) + math::dot(p, twist), det = aa * bb - ab * ab;
      const bool holds_a = std::fabs(a) == 1.0 && a * ga <= 0.0;
      const bool holds_b = std::fabs(b) == 1.0 && b * gb <= 0.0;
      double to_a = holds_a ? a : a - (holds_b ? ga / aa : (ga * bb - gb * ab) / det);
      double to_b = holds_b ? b : b - (holds_a ? gb / bb : (gb * aa - ga * ab) / det);
      to_a = std::clamp(to_a, -1.0, 1.0);
      to_b = std::clamp(to_b, -1.0, 1.0);
      Vec3d next = at(to_a, to_b);
      if (!(math::dot(next, next) < least)) {
        to_a = std::clamp(a - ga / aa, -1.0, 1.0);
        to_b = b;
        next = at(to_a, to_b);
        if (!(math::dot(next, next) < least)) {
          to_a = a;
          to_b = std::clamp(b - gb / bb, -1.0, 1.0);
          next = at(to_a, to_b);
          if (!(math::dot(next, next) < least))
            break;
        }
      }
      p = next;
      a = to_a;
      b = to_b;
      least = math::dot(p, p);
    }
    return {a, b};
  }
  /// A quarter of the part; which: of four.
  Part quarter(int which) const {
    const double a = which & 1 ? 0.5 : -0.5, b = which & 2 ? 0.5 : -0.5;
    return {at(a, b),     0.5 * (along + b * twist),  0.5 * (across + a * twist),
            0.25 * twist, u + 2.0 * a * (0.5 * half), v + 2.0 * b * (0.5 * half),
            0.5 * half};
  }
};

/// The interior of a bilinear patch.
class Patch {
public:
  Patch(const Corner* given, int face, Best& best) : face_(face), best_(best) {
    // The corners in an order that all cells of the face have in common.
    const int first =
        int(std::min_element(given, given + 4,
                             [](const Corner& a, const Corner& b) { return is_before(a.x, b.x); }) -
            given);
    const bool forth = is_before(given[(first + 1) & 3].x, given[(first + 3) & 3].x);
    for (int k = 0; k < 4; ++k)
      c_[k] = given[(first + (forth ? k : 4 - k)) & 3];
  }

  void look() {
    const auto mean = [&](double a, double b, double c, double d) {
      return 0.25 * (a * c_[0].from + b * c_[1].from + c * c_[2].from + d * c_[3].from);
    };
    // u goes from corner 0 to 1, v from 0 to 3.
    const Part whole{mean(1, 1, 1, 1),
                     mean(-1, 1, 1, -1),
                     mean(-1, -1, 1, 1),
                     mean(1, -1, 1, -1),
                     0.5,
                     0.5,
                     0.5};
    rounding_ = 0x1p-52 * (length(whole.middle) + length(whole.along) + length(whole.across) +
                           length(whole.twist));
    limit_ = std::sqrt(best_.limit());
    thread_local std::vector<Waiting> waiting;
    waiting.clear();
    look_at_part(whole, waiting);
    for (int parts = 0; !waiting.empty() && parts < most_parts; ++parts) {
      const Waiting next = waiting.back();
      waiting.pop_back();
      if (!(next.lower <= limit_ + rounding_))
        continue;
      const auto begin = std::ptrdiff_t(waiting.size());
      for (int k = 0; k < 4; ++k)
        look_at_part(next.part.quarter(k), waiting);
      // The nearest one last, since it is taken up first.
      std::sort(waiting.begin() + begin, waiting.end(),
                [](const Waiting& a, const Waiting& b) { return a.lower > b.lower; });
    }
  }

private:
  /// A bound on the work where a whole arc of the patch is equally near.
  static constexpr int most_parts = 4096;
  struct Waiting {
    Part part;
    double lower; ///< no point of the part is nearer
  };

  /// Takes the part's nearest point, and keeps the part if there may be a nearer one.
  void look_at_part(const Part& part, std::vector<Waiting>& waiting) {
    auto [a, b] = part.nearest();
    const double off = length(part.twist);
    const double lower = length(part.middle + a * part.along + b * part.across) - off;
    if (lower > limit_ + rounding_)
      return;
    const bool is_flat = off <= rounding_, is_convex = !is_flat && part.is_convex();
    if (is_convex)
      std::tie(a, b) = part.nearest_of_convex(a, b);
    const double u = part.u + a * part.half, v = part.v + b * part.half;
    if (u > 0.0 && u < 1.0 && v > 0.0 && v < 1.0) { // the edges have been looked at
      const Vec3d at = part.at(a, b);
      const double squared = math::dot(at, at);
      best_.take(squared, between(between(c_[0].x, c_[1].x, u), between(c_[3].x, c_[2].x, u), v),
                 Decision(Reason::on_face, face_));
      limit_ = std::min(limit_, std::sqrt(squared));
    }
    if (!is_flat && !is_convex)
      waiting.push_back({part, lower});
  }

  Corner c_[4];
  int face_;
  Best& best_;
  double limit_ = 0.0, rounding_ = 0.0;
};

} // namespace

NearestOnCell nearest_on_cell(mesh::Shape shape, const Vec3d* x, const Vec3d& p,
                              const Metric& metric, double most) {
  const cells::FaceTable table = cells::face_table(shape);
  Corner corners[8];
  for (int v = 0; v < table.vertex_count; ++v)
    corners[v] = {x[v], metric.from(p, x[v])};
  Best best{{}, most};
  for (int e = 0; e < table.edge_count; ++e) {
    const auto& [a, b] = table.edges[e].vertices;
    look_at_edge(corners[a], corners[b], e, {a, b}, best);
  }
  for (int f = 0; f < table.face_count; ++f) {
    const cells::Face& face = table.faces[f];
    Corner ring[4];
    for (int k = 0; k < face.vertex_count; ++k)
      ring[k] = corners[face.vertices[k]];
    if (face.vertex_count == 3)
      look_at_triangle(ring, f, best);
    else
      Patch(ring, f, best).look();
  }
  return best.found;
}

} // namespace insitu::query
