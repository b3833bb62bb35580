#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "advect/effects/space.h"
#include "mesh/view.h"
#include "query/chart_image.h"

namespace insitu::advect {

/// How a particle moves on a geodetic mesh: the integrator's coordinates are longitude, latitude
/// and the vertical number or, near a pole, those of the chart turned to it (geo::Pole), where
/// steps over the pole are as smooth as any. The particle changes charts between steps. Velocities
/// are metres per second east, north and up; depth 0 stays exactly 0 where nothing moves up.
class ChartMotion {
public:
  explicit ChartMotion(const query::ChartImage* chart) : chart_(chart) {}

  /// A position in the mesh's frame, in the coordinates of the chart that suits it.
  math::Vec3d enter(const math::Vec3d& position) {
    pole_ = geo::Pole::none;
    if (!(std::abs(position.y) <= units().quarter())) // beyond a pole is nowhere
      return position;
    pole_ = suits(position, geo::Pole::none);
    return geo::between_charts(units(), geo::Pole::none, pole_, normalised(position));
  }
  /// The mesh's frame again, the longitude within the mesh's turn.
  math::Vec3d position(const math::Vec3d& x) const {
    return normalised(geo::between_charts(units(), pole_, geo::Pole::none, x));
  }

  /// The same for an image: the coordinates in which it is entered.
  math::Vec3d enter_image(const math::Vec3d& image) {
    const geo::Pole from = chart_->pole_of(image);
    const math::Vec3d q{image.x - chart_->offset(from), image.y, image.z};
    pole_ = suits(geo::between_charts(units(), from, geo::Pole::none, q), geo::Pole::none);
    const math::Vec3d x = geo::between_charts(units(), from, pole_, q);
    return pole_ == geo::Pole::none ? normalised(x) : x;
  }
  /// The chart whose coordinates these are.
  geo::Pole pole() const { return pole_; }
  void go_by(geo::Pole pole) { pole_ = pole; }
  /// Takes on the coordinates that are those on another mesh; true if they are others.
  bool go_by(const ChartMotion& other) { return std::exchange(pole_, other.pole_) != other.pole_; }
  /// Whether positions come out of a turned chart.
  bool is_turned() const { return pole_ != geo::Pole::none; }

  double west() const { return chart_->west; }
  /// A longitude that only rounding has west of the mesh's turn: its image lies a turn to the east.
  bool is_west_by_rounding(const math::Vec3d& x) const {
    return pole_ == geo::Pole::none && x.x < west() &&
           x.x >= west() - 8.0 * std::numeric_limits<double>::epsilon() * units().turn();
  }

  /// Where the point lies among the mesh's cells; false beyond the chart's reach.
  bool image(const math::Vec3d& x, math::Vec3d& out) const {
    if (!(std::abs(x.y) <= units().quarter()))
      return false;
    if (pole_ == geo::Pole::none) {
      out = (*chart_)(x);
      return true;
    }
    if (!(std::abs(x.x) < units().quarter()))
      return false;
    const math::Vec3d p = geo::between_charts(units(), pole_, geo::Pole::none, x);
    if (chart_->pole_at(p.y) != pole_)
      out = (*chart_)(p);
    else
      out = {x.x + chart_->offset(pole_), x.y, x.z};
    return true;
  }

  /// A point near a, in the coordinates that a's image is in: a straight way from the image.
  math::Vec3d along(const math::Vec3d& a, const math::Vec3d& image, const math::Vec3d& b) const {
    const geo::Pole pole = chart_->pole_of(image);
    if (pole == pole_)
      return {b.x + (image.x - a.x), b.y, b.z};
    math::Vec3d q = geo::between_charts(units(), pole_, pole, b);
    q.x += chart_->offset(pole);
    if (pole == geo::Pole::none)
      q.x += units().turn() * std::round((image.x - q.x) / units().turn());
    return q;
  }
  /// The way back, of a point near a's image.
  math::Vec3d from_image(const math::Vec3d& a, const math::Vec3d& image,
                         const math::Vec3d& q) const {
    const geo::Pole pole = chart_->pole_of(image);
    if (pole == pole_)
      return {q.x - (image.x - a.x), q.y, q.z};
    math::Vec3d b =
        geo::between_charts(units(), pole, pole_, {q.x - chart_->offset(pole), q.y, q.z});
    if (pole_ == geo::Pole::none)
      b.x += units().turn() * std::round((a.x - b.x) / units().turn());
    return b;
  }

  /// A vector east, north and up at x, along the east and north of the image's chart.
  math::Vec3d turned(const math::Vec3d& x, const math::Vec3d& image, geo::Pole image_pole,
                     const math::Vec3d& v) const {
    if (image_pole == geo::Pole::none || (v.x == 0.0 && v.y == 0.0))
      return v;
    const geo::ChartPlace here = geo::place_of(
        units(), geo::Pole::none, geo::between_charts(units(), pole_, geo::Pole::none, x));
    const geo::ChartPlace there = geo::place_of(
        units(), image_pole, {image.x - chart_->offset(image_pole), image.y, image.z});
    const math::Vec3d along = v.x * here.east + v.y * here.north;
    return {dot(along, there.east), dot(along, there.north), v.z};
  }

  /// The rate of x. velocity: at the image, along the east and north of the image's chart.
  math::Vec3d rates(const math::Vec3d& x, const math::Vec3d& image, geo::Pole image_pole,
                    math::Vec3d velocity) const {
    if (image_pole != pole_) {
      const geo::ChartPlace from = geo::place_of(
          units(), image_pole, {image.x - chart_->offset(image_pole), image.y, image.z});
      const geo::ChartPlace to = geo::place_of(units(), pole_, x);
      const math::Vec3d v = velocity.x * from.east + velocity.y * from.north;
      velocity.x = dot(v, to.east);
      velocity.y = dot(v, to.north);
    }
    return geo::chart_rates(units(), pole_, x, velocity);
  }

  /// Metres of a displacement, or metres per second of a rate, halfway along it.
  double length(const math::Vec3d& x, const math::Vec3d& d) const {
    const double small = 0.02 * units().turn(); // else it is no place to look at
    const bool halfway = std::abs(d.x) < small && std::abs(d.y) < small;
    const math::Vec3d m = geo::chart_metres(units(), pole_, halfway ? x + 0.5 * d : x, d);
    return std::hypot(m.x, m.y, m.z);
  }

  /// Between two steps: x may go over to another chart, or by whole turns; its rate goes along.
  /// True for another chart.
  bool settle(math::Vec3d& x, math::Vec3d& rate) {
    const math::Vec3d p = geo::between_charts(units(), pole_, geo::Pole::none, x);
    const geo::Pole to = suits(p, pole_);
    if (to == pole_) {
      if (to == geo::Pole::none)
        x = normalised(x);
      return false;
    }
    const math::Vec3d v = geo::chart_metres(units(), pole_, x, rate);
    const geo::ChartPlace from = geo::place_of(units(), pole_, x);
    const math::Vec3d y = geo::between_charts(units(), pole_, to, x);
    const geo::ChartPlace there = geo::place_of(units(), to, y);
    const math::Vec3d along = v.x * from.east + v.y * from.north;
    pole_ = to;
    x = to == geo::Pole::none ? normalised(y) : y;
    rate = geo::chart_rates(units(), to, x, {dot(along, there.east), dot(along, there.north), v.z});
    return true;
  }

  /// The size of a cell's bounding box in the particle's coordinates. An edge far shorter than the
  /// others, in metres, counts as 1e-6 of the longest.
  math::Vec3d extent(const mesh::CellVertices& cell, geo::Pole cell_pole) const {
    math::Vec3d low, high;
    for (int v = 0; v < cell.count; ++v) {
      math::Vec3d p = cell.x[v];
      p.x -= chart_->offset(cell_pole);
      if (cell_pole != pole_)
        p = geo::between_charts(units(), cell_pole, pole_, p);
      for (int a = 0; a < 3; ++a) {
        low[a] = v == 0 ? p[a] : std::min(low[a], p[a]);
        high[a] = v == 0 ? p[a] : std::max(high[a], p[a]);
      }
    }
    const math::Vec3d middle = 0.5 * (low + high);
    math::Vec3d size = high - low, metres;
    for (int a = 0; a < 3; ++a) {
      math::Vec3d unit{};
      unit[a] = 1.0;
      const math::Vec3d m = geo::chart_metres(units(), pole_, middle, unit);
      metres[a] = std::max(std::hypot(m.x, m.y, m.z), std::numeric_limits<double>::min());
    }
    const double longest = std::max({size.x * metres.x, size.y * metres.y, size.z * metres.z});
    for (int a = 0; a < 3; ++a)
      size[a] = std::max({size[a], 1e-6 * longest / metres[a], std::numeric_limits<double>::min()});
    return size;
  }

private:
  const geo::ChartUnits& units() const { return chart_->units; }
  math::Vec3d normalised(const math::Vec3d& p) const {
    return {geo::longitude_from(chart_->west, units(), p.x), p.y, p.z};
  }
  /// Within 15 degrees of a pole, or 16 for one that comes from there, and where cells are copied
  /// to the pole's chart, that chart.
  geo::Pole suits(const math::Vec3d& p, geo::Pole now) const {
    if (const geo::Pole cells = chart_->pole_at(p.y); cells != geo::Pole::none)
      return cells;
    const double limit = units().quarter() * (now == geo::Pole::none ? 75.0 : 74.0) / 90.0;
    return p.y > limit ? geo::Pole::north : p.y < -limit ? geo::Pole::south : geo::Pole::none;
  }

  const query::ChartImage* chart_;
  geo::Pole pole_ = geo::Pole::none; ///< of the particle's coordinates
};

} // namespace insitu::advect
