#include "render/surface/tiles/cell_slabs.h"

#include <algorithm>
#include <cmath>

#include "render/surface/tiles/trilinear_cell.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/surface/tiles/cell_slabs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::render::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using Floats = hn::Rebind<float, Doubles>;

/// first: of the field's slab, at the level.
unsigned meet_target(const CellSlabs& cell, const CellSlabs::Slab& first, const RayLanes& rays,
                     unsigned among) {
  const Floats d;
  const Doubles dd;
  constexpr int lanes = int(hn::MaxLanes(d));
  constexpr unsigned all = unsigned((std::uint64_t(1) << lanes) - 1);
  unsigned bits = 0;
  for (int i = 0; i < RayLanes::most; i += lanes) {
    if (!(among >> i & all))
      continue;
    hn::Vec<Floats> at[3], to_end[3];
    auto far = hn::Zero(d);
    for (int a = 0; a < 3; ++a) {
      const auto centre = hn::Set(dd, cell.centre[a]), scale = hn::Set(dd, cell.inverse_size);
      at[a] = hn::DemoteTo(d, hn::Mul(hn::Sub(hn::Load(dd, rays.origin[a] + i), centre), scale));
      to_end[a] = hn::Load(d, rays.direction[a] + i);
      far = hn::Add(far, hn::Abs(at[a]));
    }
    // What rounding may make of places: of the way to the cell, and of that in it.
    const auto slack =
        hn::MulAdd(hn::Add(far, hn::Set(d, 2.0f)), hn::Set(d, 0x1p-19f), hn::Set(d, cell.rounding));
    auto from = hn::Neg(slack);
    auto to = hn::MulAdd(hn::Load(d, rays.t_max + i),
                         hn::Set(d, float(cell.inverse_size) * (1 + 0x1p-20f)), slack);
    for (int k = 0; k < cell.count; ++k) {
      const CellSlabs::Slab& slab = k == 0 ? first : cell.slab[k];
      const auto x = hn::Set(d, slab.normal[0]), y = hn::Set(d, slab.normal[1]),
                 z = hn::Set(d, slab.normal[2]);
      const auto place = hn::MulAdd(x, at[0], hn::MulAdd(y, at[1], hn::Mul(z, at[2])));
      auto speed = hn::MulAdd(x, to_end[0], hn::MulAdd(y, to_end[1], hn::Mul(z, to_end[2])));
      speed = hn::CopySign(hn::Max(hn::Abs(speed), hn::Set(d, 0x1p-40f)), speed);
      const auto inverse = hn::Div(hn::Set(d, 1.0f), speed);
      const auto s = hn::Mul(hn::Sub(hn::Sub(hn::Set(d, slab.from), slack), place), inverse);
      const auto t = hn::Mul(hn::Sub(hn::Add(hn::Set(d, slab.to), slack), place), inverse);
      from = hn::Max(from, hn::Min(s, t));
      to = hn::Min(to, hn::Max(s, t));
    }
    // Beyond floats nothing is told.
    const auto misses = hn::And(hn::Gt(from, to), hn::Lt(far, hn::Set(d, 1e30f)));
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(d, misses, byte);
    bits |= (~unsigned(byte[0]) & all) << i;
  }
  return bits & among;
}

} // namespace insitu::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::render {

using math::Vec3d;

HWY_EXPORT(meet_target);

namespace {

/// Of a number's mean derivatives along the axes: the four edges at each.
template <class T>
T mean_slope(const T (&corner)[8], int axis) {
  T sum{};
  for (int c = 0; c < 8; ++c)
    if (!(c >> axis & 1))
      sum = sum + (corner[c | 1 << axis] - corner[c]);
  return 0.25 * sum;
}

/// A vector of length 1, or 0 where its length is no number.
Vec3d unit_or_zero(const Vec3d& v) {
  const double length = std::sqrt(dot(v, v));
  return length > 0 && std::isfinite(length) && std::isfinite(1 / length) ? v / length : Vec3d{};
}

/// The slab across n of points, wide enough for a normal in floats.
CellSlabs::Slab slab_of(const Vec3d& n, const Vec3d* y, const double* shift, int count) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (int v = 0; v < count; ++v) {
    const double at = dot(n, y[v]) - (shift ? shift[v] : 0.0);
    low = std::min(low, at);
    high = std::max(high, at);
  }
  const auto slack = float(1e-6 + 1e-6 * (std::fabs(low) + std::fabs(high)));
  return {{float(n.x), float(n.y), float(n.z)}, float(low) - slack, float(high) + slack};
}

} // namespace

CellSlabs::CellSlabs(mesh::Shape shape, int n, const Vec3d* x, const double* values) {
  low = *std::min_element(values, values + n);
  high = *std::max_element(values, values + n);
  double size = 0, largest = 0;
  for (int v = 0; v < n; ++v)
    centre += (1.0 / n) * x[v];
  Vec3d y[8], corner[8];
  double f[8], of_corner[8];
  for (int v = 0; v < n; ++v)
    for (int a = 0; a < 3; ++a) {
      size = std::max(size, std::fabs(x[v][a] - centre[a]));
      largest = std::max(largest, std::fabs(x[v][a]));
    }
  if (!(size > 0 && high > low && std::isfinite(1 / size) && std::isfinite(1 / (high - low))))
    return;
  for (int v = 0; v < n; ++v) {
    y[v] = (x[v] - centre) / size;
    f[v] = (values[v] - low) / (high - low);
  }
  to_corners(shape, y, corner);
  to_corners(shape, f, of_corner);
  const Vec3d j[3] = {mean_slope(corner, 0), mean_slope(corner, 1), mean_slope(corner, 2)};
  Vec3d m[3] = {cross(j[1], j[2]), cross(j[2], j[0]), cross(j[0], j[1])};
  const double determinant = dot(j[0], m[0]);
  Vec3d g;
  for (int a = 0; a < 3; ++a) {
    m[a] = m[a] / determinant;
    g += mean_slope(of_corner, a) * m[a];
  }
  const double steep = std::sqrt(dot(g, g));
  if (!(steep > 1e-6 && steep < 1e6)) // degenerate, or a field of no direction
    return;
  inverse_size = 1 / size;
  rounding = float(0x1p-48 * largest / size);
  place = 1 / steep;
  const Vec3d normal = g / steep;
  double shift[8];
  for (int v = 0; v < n; ++v)
    shift[v] = f[v] / steep;
  slab[count++] = slab_of(normal, y, shift, n);
  for (const Vec3d& row : m)
    slab[count++] = slab_of(unit_or_zero(row), y, nullptr, n);
  if (const PatchDomain domain = domain_of(shape); domain != PatchDomain::cube)
    slab[count++] =
        slab_of(unit_or_zero(m[0] + m[1] + (domain == PatchDomain::simplex ? m[2] : Vec3d{})), y,
                nullptr, n);
  // How far the gradient wanders.
  double worst = 0;
  for (int a = 0; a < 3; ++a) {
    double off = 0, row = 0;
    for (int axis = 0; axis < 3; ++axis) {
      double greatest = 0;
      for (int c = 0; c < 8; ++c)
        if (const int b = c | 1 << axis; b != c) {
          const Vec3d edge = corner[b] - corner[c];
          greatest = std::max(greatest, std::fabs(dot(m[a], edge) - (a == axis ? 1.0 : 0.0)));
          if (a == axis)
            off =
                std::max(off, std::fabs((of_corner[b] - of_corner[c]) / steep - dot(normal, edge)));
        }
      row += greatest;
    }
    worst = std::max(worst, row);
    length[a] = float(1.001 * std::sqrt(dot(m[a], m[a])));
    left[a] = float(1.001 * off + 1e-7);
  }
  if (worst < 0.9)
    error = float(worst);
}

unsigned CellSlabs::may_meet(const RayLanes& lanes, unsigned rays, double level) const {
  if (inverse_size == 0)
    return rays;
  Slab first = slab[0];
  // normal y - f / steep lies between its ends, and f is the level's.
  const double at = place * ((level - low) / (high - low));
  const auto slack = float(0x1p-22 * std::fabs(at));
  first.from = float(at + first.from) - slack;
  first.to = float(at + first.to) + slack;
  return HWY_DYNAMIC_DISPATCH(meet_target)(*this, first, lanes, rays);
}

/// What the field may do along a vector beside what its mean gradient says, over |g|.
double CellSlabs::wander(const Vec3d& along) const {
  double largest = 0, sum = 0, of_all = 0;
  for (int a = 0; a < 3; ++a) {
    const float(&n)[3] = slab[1 + a].normal;
    const double way = double(length[a]) * std::fabs(dot(Vec3d{n[0], n[1], n[2]}, along));
    largest = std::max(largest, way);
    sum += double(left[a]) * way;
    of_all += double(left[a]);
  }
  const double e = double(error);
  return sum + of_all * largest * e / (1 - e) + 1e-6;
}

bool CellSlabs::leaves(const Vec3d& normal, double clearance, const Vec3d& direction) const {
  if (!(error < 1))
    return false;
  const Vec3d n{slab[0].normal[0], slab[0].normal[1], slab[0].normal[2]};
  const double across = dot(n, normal), rise = std::fabs(across) - wander(normal);
  if (!(rise > 0.01))
    return false;
  // The start itself is off the surface by what its root and rounding are off.
  return clearance * inverse_size * rise > 2e-8 + 4.0 * double(rounding) &&
         std::copysign(1.0, across) * dot(n, direction) > wander(direction) + 1e-5;
}

} // namespace insitu::render
#endif
