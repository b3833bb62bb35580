#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>

#include "math/vec.h"

/// What integrate() asks of a field: a velocity, and what some fields know besides.
namespace insitu::advect {

using math::Vec3d;

/// What a velocity field answers at a point and a time.
enum class Sampled : std::uint8_t { inside, outside, not_finite };

/// A velocity field dx/dt = v(x, t). It is asked at trial points; accepted() tells it that the
/// point asked last is the particle's new position, and extent() is then the size, along x, y and
/// z, of the cell around that position: the measure of steps and of where a particle leaves. It is
/// positive, and infinite for an unbounded field without cells.
template <class F>
concept VelocityField = requires(F& f, const Vec3d& x, double t, Vec3d& v) {
  { f(x, t, v) } -> std::same_as<Sampled>;
  f.accepted();
  { f.extent() } -> std::convertible_to<Vec3d>;
};

/// Euclidean length without overflow or underflow in between.
inline double length_of(const Vec3d& v) {
  return std::hypot(v.x, v.y, v.z);
}

/// What a displacement d at the position x measures in the units of lengths and tolerances: for
/// error vectors per unit time as well, and so for speeds. A field whose coordinates are not
/// lengths, such as degrees, has a double length(x, d), linear in the size of d; others cost
/// nothing.
template <class F>
double measure(const F& field, const Vec3d& x, const Vec3d& d) {
  if constexpr (requires {
                  { field.length(x, d) } -> std::same_as<double>;
                })
    return field.length(x, d);
  else
    return length_of(d);
}

/// What a particle comes to at a face of its cell.
enum class Crossed : std::uint8_t { into_next, to_boundary, nowhere };

/// A field of cells, each with a formula of its own, for steps that end at faces. confine(x, w, t)
/// chooses the cell into which a particle at x goes in direction w: until release(), that cell's
/// formula answers, also some way beyond its faces, and points too far beyond are outside.
/// depth(x, t) is how far within that cell a point lies, negative outside, in parametric units;
/// last_depth() is that of the point asked last. cross(x, w, t) chooses the next cell, where a
/// particle comes to a face. Where the point asked last is a path's end, or out of the cell at part
/// `high` of it, the field may know more at once: is_inside_before(path), at its quarters too, and
/// face_on(path, low, high), the part where it goes out of the cell, negative if not known.
template <class F>
concept CellwiseField = requires(F& f, const Vec3d& x, double t) {
  { f.confine(x, x, t) } -> std::same_as<bool>;
  f.release();
  { f.depth(x, t) } -> std::same_as<double>;
  { f.last_depth() } -> std::same_as<double>;
  { f.cross(x, x, t) } -> std::same_as<Crossed>;
};

/// A field that knows where its domain ends: leave(a, b, t, dt), with a the particle's place, is
/// where the segment leaves it, travelled from t to t + dt: contextually false, or with t (in
/// [0, 1]), inside (a point in the domain, on the boundary to rounding), face and normal. The
/// particle's place is then that point. It may tell by way_out(a, b, t) at what part of the
/// segment that is, or a negative number, and change nothing. One that takes points beyond its
/// domain by rounding for points in it tells by kept_inside(x), with x the point asked last, where
/// a particle that comes there is, and by kept_inside(x, t) where at a time that is its own to
/// rounding.
template <class F>
concept ExitingField = requires(F& f, const Vec3d& x, double t) {
  { f.leave(x, x, t, t)->inside } -> std::convertible_to<Vec3d>;
  { f.leave(x, x, t, t)->t } -> std::convertible_to<double>;
};

/// The cells of this extent that displacement d crosses.
inline double cells_crossed(const Vec3d& d, const Vec3d& extent) {
  return std::max({std::abs(d.x) / extent.x, std::abs(d.y) / extent.y, std::abs(d.z) / extent.z});
}

} // namespace insitu::advect
