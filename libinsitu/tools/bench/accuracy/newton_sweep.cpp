#include <algorithm>
#include <cmath>

#include "accuracy/sweeps.h"
#include "cells/kernels/kernels.h"
#include "report/format.h"
#include "workload/mesh.h"
#include "workload/queries.h"

namespace insitu::bench::accuracy {

namespace {

using math::Vec3;
using math::Vec3d;

/// Cells with a point each whose parametric coordinates are known.
struct Cells {
  std::vector<Vec3d> vertices; ///< eight each
  std::vector<Vec3d> at, points;
};

/// To a multiple of 1 / parts.
Vec3d snapped(const Vec3d& v, double parts) {
  return {std::round(parts * v.x) / parts, std::round(parts * v.y) / parts,
          std::round(parts * v.z) / parts};
}

/// Vertices are multiples of 2^-12 and parametric coordinates of 2^-6, so points are multiples of
/// 2^-30: exact in double, up to offsets of 2^23. What is wrong with an answer is then Newton's
/// part or float's; rounding of the input has none.
Cells make_cells(double offset, std::int64_t count) {
  const workload::Mesh mesh = workload::make_box(workload::Kind::hexahedra, 24, 0.2);
  const Vec3d far{offset, offset, offset};
  Cells out;
  for (std::int64_t i = 0; i < count; ++i) {
    Vec3d x[8];
    mesh.gather((i * 7919) % mesh.cell_count(), x);
    for (Vec3d& v : x) {
      v = snapped(v, 0x1p12);
      out.vertices.push_back(v + far);
    }
    const Vec3d r =
        snapped(workload::random_parametric(mesh::Shape::hexahedron, std::uint64_t(i)), 0x1p6);
    out.at.push_back(r);
    out.points.push_back(cells::map_to_physical(mesh::Shape::hexahedron, x, r) + far);
  }
  return out;
}

/// The library's Newton step, stopped by other rules than its own. Returns the steps taken.
template <class T>
int iterate(const Vec3<T>* x, const Vec3<T>& p, double tolerance, int limit, Vec3<T>& r) {
  r = {T(0.5), T(0.5), T(0.5)};
  const auto map = cells::trilinear_map(mesh::Shape::hexahedron, x);
  const Vec3<T> q = p - x[0];
  for (int i = 1; i <= limit; ++i) {
    Vec3<T> at, a, b, c;
    map(r, at, a, b, c);
    const auto n = cells::newton_step(a, b, c, q - at);
    const auto bent = cells::bent_step(map, r, n);
    r = r + bent.step;
    if (!(bent.size >= T(tolerance)))
      return i;
  }
  return limit;
}

template <class T>
Setting measure(const Cells& c, const std::string& group, const std::string& name, double tolerance,
                int limit, int repetitions) {
  std::vector<Vec3<T>> vertices, points;
  for (const Vec3d& v : c.vertices)
    vertices.push_back({T(v.x), T(v.y), T(v.z)});
  for (const Vec3d& p : c.points)
    points.push_back({T(p.x), T(p.y), T(p.z)});
  std::vector<Vec3<T>> found(points.size());
  std::int64_t steps = 0;
  Setting s;
  s.group = group;
  s.name = name;
  s.items = double(points.size());
  for (int k = 0; k < repetitions; ++k)
    s.time.time([&] {
      steps = 0;
      for (std::size_t i = 0; i < points.size(); ++i)
        steps += iterate(&vertices[8 * i], points[i], tolerance, limit, found[i]);
    });
  s.work = double(steps) / s.items;
  double sum = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d d = Vec3d{double(found[i].x), double(found[i].y), double(found[i].z)} - c.at[i];
    const double e = std::min(1.0, cells::largest_of(d)); // NaN: 1
    sum += e * e;
    worst = std::max(worst, e);
  }
  s.error = std::sqrt(sum / s.items);
  s.more = {worst};
  return s;
}

} // namespace

Sweep sweep_newton(const Extent& extent) {
  Sweep s;
  s.key = "newton";
  s.title = "Parametric coordinates";
  s.swept = "Newton's tolerance (with at most 12 steps) and its limit of steps (with no "
            "tolerance), in hexahedra "
            "with jitter 0.2; in double and in float, at offsets of 0, 1e3 and 6.4e6 cell "
            "coordinates, the box being 1 wide.";
  s.reference = "The coordinates that the points were made at. Vertices and points are exact in "
                "double at every offset.";
  s.error_label = "error of parametric coordinates, root mean square";
  s.work_label = "Newton steps a point";
  s.time_label = "seconds a point, one core, one at a time";
  s.more_labels = {"largest error"};
  const std::int64_t count = extent.quick ? 4000 : 200'000;
  const auto sweep = [&]<class T>(T, const std::string& number, double offset) {
    const Cells cells = make_cells(offset, count);
    const std::string group = number + format(", offset %g", offset);
    progress("newton: " + group);
    for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-5, 1e-8, 1e-12}) {
      Setting one = measure<T>(cells, group, "tolerance, " + format("%g", tolerance), tolerance, 12,
                               extent.repetitions);
      one.is_default = tolerance == 1e-5 && number == "double";
      s.settings.push_back(std::move(one));
    }
    for (const int limit : {1, 2, 3, 4, 6, 8})
      s.settings.push_back(measure<T>(cells, group, "limit, " + std::to_string(limit) + " steps",
                                      0.0, limit, extent.repetitions));
  };
  for (const double offset : {0.0, 1e3, 6.4e6}) {
    sweep(0.0, "double", offset);
    sweep(0.0f, "float", offset);
  }
  const Setting* chosen = s.default_of("double, offset 0");
  const Setting* loose = s.find("double, offset 0", "tolerance, 0.01");
  const Setting* near = s.find("float, offset 0", "tolerance, 1e-08");
  const Setting* far = s.find("float, offset 6.4e+06", "tolerance, 1e-08");
  const Setting* offset = s.default_of("double, offset 6.4e+06");
  s.advice = format("The tolerance of 1e-5 takes %.2f steps and leaves %.1g, at 6.4e6 %.2f and "
                    "%.1g; stopping at 0.01 saves %.0f %% of the steps for an error of %.1g. Float "
                    "is good for %.1g at the origin and for %.1g at 6.4e6, so keep coordinates in "
                    "double.",
                    chosen->work, chosen->error, offset->work, offset->error,
                    100 * (1 - loose->work / chosen->work), loose->error, near->error, far->error);
  s.notes = {"The library inverts a register full of points at a time and certifies the answer; "
             "the steps are the "
             "same ones."};
  return s;
}

} // namespace insitu::bench::accuracy
