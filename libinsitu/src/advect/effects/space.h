#pragma once

#include <algorithm>
#include <cmath>

#include "geo/chart.h"
#include "geo/upright.h"
#include "query/chart_image.h"

namespace insitu::advect {

using math::Vec3d;

/// Coordinates per metre along the axes at a place: a small displacement of m metres is one of
/// d = J m coordinates. The third axis stands upright on the others.
struct Scale {
  double xx = 1.0, xy = 0.0, yx = 0.0, yy = 1.0, zz = 1.0;

  Vec3d coordinates(const Vec3d& m) const {
    return {xx * m.x + xy * m.y, yx * m.x + yy * m.y, zz * m.z};
  }
  Vec3d metres(const Vec3d& d) const {
    const double det = xx * yy - xy * yx;
    return {(yy * d.x - xy * d.y) / det, (xx * d.y - yx * d.x) / det, d.z / zz};
  }
  /// A gradient or a face's normal, of covariant components n in coordinates: J^T n.
  Vec3d covector(const Vec3d& n) const {
    return {xx * n.x + yx * n.y, xy * n.x + yy * n.y, zz * n.z};
  }
  /// The edges of a box of this extent in coordinates.
  Vec3d edges(const Vec3d& extent) const {
    const Vec3d a = metres({extent.x, 0, 0}), b = metres({0, extent.y, 0});
    return {std::hypot(a.x, a.y), std::hypot(b.x, b.y), std::abs(extent.z / zz)};
  }
};

/// The coordinates in which particles are displaced: those of the cells. On a geodetic mesh these
/// are images (query::ChartImage), cells are straight in them, and a way may go on in another sheet
/// of them: over the seam, or on the chart turned to a pole. Vectors are in metres along the axes
/// of the place's chart: east, north and up, or a turned chart's own. On a geocentric mesh vectors
/// are along the Earth's axes, as coordinates; what a scene calls level or upright is so by the
/// ellipsoid's normal at the place.
class Space {
public:
  /// chart: null where coordinates are lengths.
  explicit Space(const query::ChartImage* chart) : chart_(chart) {}
  static Space geocentric() {
    Space space(nullptr);
    space.geocentric_ = true;
    return space;
  }

  /// Whether the metres and the axes of coordinates are others from place to place.
  bool is_curved() const { return chart_ != nullptr; }
  bool is_geocentric() const { return geocentric_; }
  geo::Pole pole_of(const Vec3d& x) const { return chart_ ? chart_->pole_of(x) : geo::Pole::none; }

  bool is_beyond_pole(const Vec3d& x) const { return std::abs(x.y) > units().quarter(); }

  /// Where x, near a place on the chart turned to `pole`, is located: x itself, to the bit, or its
  /// like on another sheet.
  Vec3d image(const Vec3d& x, geo::Pole pole) const {
    if (!chart_)
      return x;
    if (pole != geo::Pole::none) {
      const Vec3d p = geo::between_charts(units(), pole, geo::Pole::none, less_offset(x, pole));
      return chart_->pole_at(p.y) == pole ? x : (*chart_)(p);
    }
    return (*chart_)(std::abs(x.y) <= units().quarter() ? x : folded(x));
  }

  /// The point q of the sheet of x on that of y, which is the same place as x and near q.
  Vec3d across(const Vec3d& x, geo::Pole pole, const Vec3d& y, const Vec3d& q) const {
    if (!chart_)
      return q;
    const geo::Pole to = pole_of(y);
    if (to == pole && (pole != geo::Pole::none || std::abs(x.y) <= units().quarter()))
      return {q.x + units().turn() * std::round((y.x - x.x) / units().turn()), q.y, q.z};
    const Vec3d normal = geo::place_of(units(), pole, less_offset(q, pole)).normal;
    Vec3d r = geo::chart_point(units(), to, normal, q.z);
    r.x = near(r.x + chart_->offset(to), y.x, to);
    return r;
  }

  /// The image, among these cells, of the place that has the image x among another mesh's.
  Vec3d image_of(const Space& other, const Vec3d& x) const {
    if (!chart_)
      return x;
    const geo::Pole pole = other.pole_of(x);
    const Vec3d q = other.less_offset(x, pole);
    if (pole == geo::Pole::none)
      return image(q, pole);
    const Vec3d p = geo::between_charts(units(), pole, geo::Pole::none, q);
    return chart_->pole_at(p.y) == pole ? Vec3d{q.x + chart_->offset(pole), q.y, q.z}
                                        : (*chart_)(p);
  }
  /// Whether the axes at that image are those at x.
  bool has_axes_of(const Space& other, const Vec3d& x, const Vec3d& image) const {
    return !chart_ || (pole_of(image) == other.pole_of(x) &&
                       (pole_of(image) != geo::Pole::none || !other.is_beyond_pole(x)));
  }
  /// v, in the axes at that image, in those at x.
  Vec3d in_axes_of(const Space& other, const Vec3d& x, const Vec3d& image, const Vec3d& v) const {
    if (has_axes_of(other, x, image))
      return v;
    const geo::ChartPlace from = place(image), to = other.place(x);
    const Vec3d w = v.x * from.east + v.y * from.north;
    return {dot(w, to.east), dot(w, to.north), v.z};
  }

  /// Whether two images of places near each other are on other sheets, or a turn apart.
  bool is_other_sheet(const Vec3d& a, const Vec3d& b) const {
    return chart_ && (pole_of(a) != pole_of(b) || std::abs(a.x - b.x) > 0.5 * units().turn());
  }

  /// Whether the axes at both places, which are near each other, have almost the same directions.
  bool same_axes(const Vec3d& x, const Vec3d& y) const {
    if (!chart_)
      return true;
    const geo::Pole pole = pole_of(x);
    const double turn = units().turn();
    return pole == pole_of(y) &&
           (pole != geo::Pole::none || std::abs(std::remainder(y.x - x.x, turn)) < turn / 8);
  }

  /// v, in the axes at x, in those at y, carried along the shortest way on the sphere of normals:
  /// what is upright stays so.
  Vec3d transport(const Vec3d& x, const Vec3d& y, const Vec3d& v) const {
    if (!chart_ || x == y)
      return v;
    const geo::ChartPlace a = place(x), b = place(y);
    // By the rotation that turns one normal into the other: w - (w.(a+b)) (a+b) / (1 + a.b)
    // + 2 (w.a) b, of which w.a is 0 here.
    const Vec3d w = v.x * a.east + v.y * a.north;
    const double c = 1.0 + dot(a.normal, b.normal);
    const Vec3d turned = c > 1e-9 ? w - (dot(w, b.normal) / c) * (a.normal + b.normal) : w;
    return {dot(turned, b.east), dot(turned, b.north), v.z};
  }

  /// A vector in the Earth's axes, and one east, north and up, in the axes at x; where x has no
  /// chart they are the same.
  Vec3d from_earth(const Vec3d& x, const Vec3d& v) const {
    if (!chart_)
      return v;
    const geo::ChartPlace at = place(x);
    return {dot(v, at.east), dot(v, at.north), dot(v, at.normal)};
  }
  Vec3d from_east_north(const Vec3d& x, const Vec3d& v) const {
    if (pole_of(x) == geo::Pole::none || (v.x == 0.0 && v.y == 0.0))
      return v;
    const geo::ChartPlace at = place(x);
    const geo::EastNorth axes = geo::east_north(at.normal);
    const Vec3d w = v.x * axes.east + v.y * axes.north;
    return {dot(w, at.east), dot(w, at.north), v.z};
  }
  Vec3d to_east_north(const Vec3d& x, const Vec3d& v) const {
    if (pole_of(x) == geo::Pole::none || (v.x == 0.0 && v.y == 0.0))
      return v;
    const geo::ChartPlace at = place(x);
    const geo::EastNorth axes = geo::east_north(at.normal);
    const Vec3d w = v.x * at.east + v.y * at.north;
    return {dot(w, axes.east), dot(w, axes.north), v.z};
  }

  Scale scale(const Vec3d& x) const {
    Scale s;
    if (!chart_)
      return s;
    const geo::Pole pole = pole_of(x);
    Vec3d p = less_offset(x, pole);
    if (pole == geo::Pole::none) // at the pole itself no longitude is a length
      p.y = std::clamp(p.y, -(1 - 1e-12) * units().quarter(), (1 - 1e-12) * units().quarter());
    const Vec3d a = geo::chart_rates(units(), pole, p, {1, 0, 0});
    const Vec3d b = geo::chart_rates(units(), pole, p, {0, 1, 0});
    return {a.x, b.x, a.y, b.y, 1.0 / units().up_per_unit()};
  }

  /// The displacement, in coordinates, to where x comes by m metres: on a chart along a great
  /// circle of the sphere of normals, so that what has no direction at x has none on the Earth.
  Vec3d displacement(const Vec3d& x, const Vec3d& m) const {
    if (!chart_)
      return m;
    const double up = m.z / units().up_per_unit();
    const geo::Pole pole = pole_of(x);
    const geo::ChartPlace at = place(x);
    const geo::Upright from{at.normal, x.z * units().up_per_unit()};
    const Vec3d n = geo::level_way(from, m.x * at.east + m.y * at.north);
    if (n == from.normal)
      return {0.0, 0.0, up};
    const Vec3d q = geo::chart_point(units(), pole, n, 0.0);
    return {near(q.x + chart_->offset(pole), x.x, pole) - x.x, q.y - x.y, up};
  }

  /// A vector at x along level axes and the vertical: east, north and up on a geocentric mesh, and
  /// else the axes at x themselves; and back.
  Vec3d to_level(const Vec3d& x, const Vec3d& v) const {
    return geocentric_ ? geo::to_east_north_up(geo::upright(x).normal, v) : v;
  }
  Vec3d from_level(const Vec3d& x, const Vec3d& v) const {
    return geocentric_ ? geo::from_east_north_up(geo::upright(x).normal, v) : v;
  }
  /// A vector that a scene gives: east, north and up wherever a mesh on Earth has them.
  Vec3d from_scene(const Vec3d& x, const Vec3d& v) const {
    return geocentric_ ? from_level(x, v) : from_east_north(x, v);
  }

  /// The displacement to where x comes by m metres along the level axes: what goes level keeps its
  /// height, on a geocentric mesh too.
  Vec3d level_displacement(const Vec3d& x, const Vec3d& m) const {
    if (!geocentric_)
      return displacement(x, m);
    const geo::Upright from = geo::upright(x);
    const Vec3d level = geo::from_east_north_up(from.normal, {m.x, m.y, 0.0});
    const Vec3d n = geo::level_way(from, level);
    if (n == from.normal)
      return m.z * n;
    return geo::geocentric_point({n, from.height + m.z}) - geo::geocentric_point(from);
  }

  /// What a random walk by level_displacement() with coefficients kh and kv has to drift, in metres
  /// per time along the level axes, for evenly mixed particles to stay so by volume. The volume
  /// over the solid angle of normals is w = (N + h)(M + h), and diffusion on the sphere of normals
  /// is w^-1 div(w A grad), A = diag(kh / (N + h)^2, kh / (M + h)^2); steps along great circles
  /// give A : Hessian, so
  ///
  ///   w^-1 div(w A) = (d/dlat (N+h)/(M+h) - tan(lat) ((N+h)/(M+h) - (M+h)/(N+h))) kh / w
  ///
  /// northwards in angle, which vanishes on a sphere, and kv dlog(w)/dh upwards are left. (In
  /// longitude and latitude the same walk drifts by -kh tan(lat) / R as well.)
  ///
  /// In space the walk's tensor is K = kh (1 - n n) + kv n n, n = grad h, whose divergence, the
  /// drift of Ito's form, is (kv - kh) div n, div n = 1/(N + h) + 1/(M + h), along n. The part of
  /// kh is what a step straight on in the tangent plane rises by in the mean, and a level one does
  /// not; so the walk has no error in height however long its level steps are.
  Vec3d walk_drift(const Vec3d& x, double kh, double kv) const {
    if (geocentric_)
      return level_walk_drift(geo::upright(x), kh, kv);
    if (!chart_)
      return {};
    return from_east_north(
        x, level_walk_drift({place(x).normal, x.z * units().up_per_unit()}, kh, kv));
  }

  /// How fast the axes at x turn about the vertical, against ones that are carried along, where x
  /// moves by v metres per time: dlon/dt sin(lat), of the chart's own longitude and latitude.
  double spin(const Vec3d& x, const Vec3d& v) const {
    if (!chart_)
      return 0.0;
    return scale(x).coordinates(v).x * units().radians_per_unit() * geo::sin_cos(units(), x.y).sin;
  }

private:
  /// East, north and up.
  static Vec3d level_walk_drift(const geo::Upright& at, double kh, double kv) {
    const geo::Radii r = geo::radii(at.normal.z);
    const double n = r.across + at.height, m = r.along + at.height;
    const double s = at.normal.z, c = std::sqrt(std::max(0.0, 1.0 - s * s));
    const double e2 = geo::eccentricity_squared / (1.0 - geo::eccentricity_squared * s * s);
    const double dn = r.across * e2 * s * c, dm = 3.0 * r.along * e2 * s * c;
    // tan(lat) (N - M), where N - M = N e2 cos^2(lat)
    const double bent = r.across * e2 * s * c * (n + m) / (n * m);
    return {0.0, kh / n * ((dn * m - n * dm) / (m * m) - bent), kv * (1.0 / n + 1.0 / m)};
  }
  const geo::ChartUnits& units() const { return chart_->units; }
  Vec3d less_offset(const Vec3d& x, geo::Pole pole) const {
    return {x.x - chart_->offset(pole), x.y, x.z};
  }
  geo::ChartPlace place(const Vec3d& x) const {
    const geo::Pole pole = pole_of(x);
    return geo::place_of(units(), pole, less_offset(x, pole));
  }
  /// Beyond a pole, by its usual name.
  Vec3d folded(const Vec3d& x) const {
    return geo::chart_point(units(), geo::Pole::none, geo::normal_of(units(), x), x.z);
  }
  double near(double longitude, double other, geo::Pole pole) const {
    if (pole != geo::Pole::none)
      return longitude;
    return longitude + units().turn() * std::round((other - longitude) / units().turn());
  }

  const query::ChartImage* chart_;
  bool geocentric_ = false;
};

} // namespace insitu::advect
