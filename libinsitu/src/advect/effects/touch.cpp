// Particles at walls, without inertia: Mover's way of moving them.
#include <algorithm>
#include <cmath>
#include <optional>

#include "advect/effects/mover.h"

namespace insitu::advect {

namespace {

/// The part of a cell that a particle goes on along a wall, or back from it, in one step.
constexpr double contact_cells = 0.1;
/// A streamline that comes no further along a wall, or into a corner, than this part of a cell in
/// such a step is at rest there.
constexpr double rest_cells = 1e-7;

} // namespace

/// The velocity that particles have in the direction of time in which they go.
template <class V>
Sampled Mover<V>::velocity_at(const Vec3d& point, double time, Vec3d& v) {
  query::Location here;
  const Sampled sampled = velocity_.sample(point, time, v, here);
  v = direction_ * v;
  return sampled;
}

/// A particle that leaves or stops where it is, or else comes in again at a periodic side.
template <class V>
insitu_ending Mover<V>::pass(State& p, Spot at) {
  Vec3d v;
  velocity_.begin(at.cell);
  if (const Sampled s = velocity_at(at.x, p.time, v); s != Sampled::inside)
    return s == Sampled::outside ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
  --steps_left_;
  const double alpha = flow().geometry_alpha(p.time);
  const Vec3d d = walls_.scale(at.x).coordinates(v);
  const double skins = cells_crossed(d, walls_.skin(at, alpha));
  const std::int64_t contacts = work_.contacts;
  const Moved moved =
      skins > 0.0 ? walls_.move(at, (8.0 / skins) * d, boundary_, alpha, p.length) : Moved::left;
  if (moved == Moved::inside && work_.contacts == contacts)
    return ending_of(boundary_.response == AtBoundary::stop ? Moved::stopped : Moved::left);
  placed(p, at);
  if (recorder_)
    recorder_->straight(p);
  return ending_of(moved);
}

/// Cells crossed per time. Beside a pole, where degrees of longitude are short, what a wall keeps a
/// particle from does not count in them.
template <class V>
double Mover<V>::cells_along(const Spot& at, const Vec3d& v, const Vec3d& wall,
                             double alpha) const {
  const Vec3d extent = walls_.extent(at.cell, alpha);
  const Scale per_metre = walls_.scale(at.x);
  const double out = math::dot(v, wall);
  if (!space_.is_chart() || boundary_.response != AtBoundary::slide || !(out > 0.0))
    return cells_crossed(per_metre.coordinates(v), extent);
  return std::max(cells_crossed(per_metre.coordinates(v - out * wall), extent),
                  cells_crossed(out * wall, walls_.edges(at.cell, alpha)));
}

/// Whether there are cells a little beyond a wall.
template <class V>
bool Mover<V>::is_behind(const Spot& at, const Vec3d& n, double alpha) const {
  return walls_.is_inside(at.x + 8.0 * by_axis(n, walls_.skin(at, alpha)), at.cell, alpha);
}

/// A step along a flat wall, whose face belongs to the cell at its beginning.
template <class V>
struct Mover<V>::Glide {
  Vec3d n;            ///< of the wall, outwards
  Vec3d v;            ///< the velocity at the beginning, and then at the end
  Spot at;            ///< the same
  Vec3d first = {};   ///< where the first rate leads
  double until = 0.0; ///< the end's time
};

/// Heun's method in the wall's plane: touch()'s, but for what finds the wall, so that it needs the
/// velocity at two places and no more; and what the wall keeps the particle from does not count in
/// its cells. False, and nothing is changed, where that does not do: where it comes to an edge, or
/// the velocity lifts it off or grows.
template <class V>
bool Mover<V>::glide(const State& p, Glide& step, double to, Work& work) {
  const auto along = [&](const Vec3d& v) { return v - math::dot(v, step.n) * step.n; };
  if (!(math::dot(step.v, step.n) > 0.0))
    return false;
  const Vec3d rate = along(step.v), extent = walls_.extent(step.at.cell, 1.0);
  const double cells = cells_crossed(rate, extent), remaining = direction_ * (to - p.time);
  if (!(cells > 0.0))
    return false;
  double h = std::min(contact_cells / cells, remaining);
  if (settings_.max_step > 0.0)
    h = std::min(h, settings_.max_step);
  h = std::min(h, (max_length_ - p.length) / length_of(rate));
  const double until = h < remaining ? p.time + direction_ * h : to;
  const Vec3d first = step.at.x + h * rate;
  Vec3d v;
  ++work.evaluations;
  if (velocity_at(first, until, v) != Sampled::inside)
    return false;
  const Vec3d mean = 0.5 * (step.v + v), d = h * along(mean);
  if (!(math::dot(mean, step.n) > 0.0) || !(cells_crossed(d, extent) <= 2.0 * contact_cells))
    return false;
  const Vec3d end = step.at.x + d;
  query::Location here;
  ++work.evaluations;
  if (velocity_.sample(end, until, v, here) != Sampled::inside)
    return false;
  velocity_.accepted();
  step = {step.n, direction_ * v, {kept_inside(end), here.cell}, first, until};
  return true;
}

/// A particle that the velocity takes out of the mesh: goes on along the wall, or back from it, for
/// as long as the velocity presses it to the wall.
template <class V>
insitu_ending Mover<V>::touch(State& p, double to, Work& work) {
  Spot at;
  if (!find(p, at))
    return INSITU_END_LEFT; // the mesh has moved away from it
  if (boundary_.response == AtBoundary::leave || boundary_.response == AtBoundary::stop)
    return pass(p, at);
  Vec3d n; // of the wall it is at, once that is known
  const bool may_glide =
      boundary_.response == AtBoundary::slide && !space_.is_chart() && !flow().blends_geometry();
  bool flat = false;          // that wall, where the particle is
  std::optional<Vec3d> known; // the velocity there, if it was asked for
  do {
    Vec3d v;
    if (known) {
      v = *known;
      known.reset();
    } else {
      ++work.evaluations;
      velocity_.begin(at.cell);
      if (const Sampled s = velocity_at(at.x, p.time, v); s != Sampled::inside)
        return s == Sampled::outside ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
      velocity_.accepted();
    }
    if (Glide step{n, v, at}; flat && glide(p, step, to, work)) {
      const Vec3d from = at.x;
      const std::int64_t cell = at.cell;
      ++work_.contacts;
      at = step.at;
      known = step.v;
      p.length += length_of(at.x - from);
      p.time = step.until;
      p.x = velocity_.place(at.x);
      spot_cell_ = at.cell;
      if (recorder_)
        recorder_->bent(p, step.first - at.x);
      ++work.steps;
      --steps_left_;
      if (is_over())
        return INSITU_END_REMOVED;
      if (at.cell != cell) {
        if (is_behind(at, n, 1.0))
          break;
        flat = walls_.is_on_flat_face(at, n, 1.0);
      }
      continue;
    }
    const double now = flow().geometry_alpha(p.time);
    const Vec3d rate = walls_.scale(at.x).coordinates(v);
    const double cells = cells_along(at, v, n, now);
    if (settings_.ends_at_rest && !(cells > 0.0))
      return INSITU_END_STAGNATED;
    const auto same_axes = [&](const Vec3d& x) { // also behind a periodic side
      return space_.same_axes(at.x, x) ||
             (setup_->sides.any() && space_.same_axes(at.x, at.x + setup_->sides.between(at.x, x)));
    };
    const double remaining = direction_ * (to - p.time);
    double h = std::min(cells > 0.0 ? contact_cells / cells : remaining, remaining);
    if (settings_.max_step > 0.0)
      h = std::min(h, settings_.max_step);
    if (max_length_ - p.length < length_of(v) * h)
      h = (max_length_ - p.length) / length_of(v);
    const double until = h < remaining ? p.time + direction_ * h : to;
    const double then = flow().geometry_alpha(until);
    // Heun's method along the wall. What the wall itself moves is not resisted. Between its ends
    // the step begins along the first rate, which led to `first`.
    Vec3d mean = rate;
    std::optional<Vec3d> first;
    Spot end = at;
    end.x = walls_.carry(at, now, then);
    const Vec3d shift = end.x - at.x;
    if (boundary_.response == AtBoundary::slide) {
      Spot ahead = end;
      double length = 0.0;
      BoundaryEffect quiet = boundary_;
      Vec3d v1;
      if (walls_.move(ahead, h * rate - shift, quiet, then, length) == Moved::inside) {
        velocity_.begin(ahead.cell);
        ++work.evaluations;
        if (velocity_at(ahead.x, until, v1) == Sampled::inside && same_axes(ahead.x)) {
          mean = 0.5 * (rate + walls_.scale(ahead.x).coordinates(v1));
          first = ahead.x;
        }
      }
    }
    const Vec3d from = at.x;
    const Moved moved = walls_.move(end, h * mean - shift, boundary_, then, p.length);
    n = walls_.wall();
    const bool turned = !same_axes(end.x);
    at = end;
    p.time = until;
    placed(p, at);
    if (recorder_)
      recorder_->bent(p, first && !turned ? Way(space_, setup_->sides, at.x, *first).displacement()
                                          : Vec3d{});
    ++work.steps;
    --steps_left_;
    if (moved != Moved::inside)
      return ending_of(moved);
    if (is_over())
      return INSITU_END_REMOVED;
    if (settings_.ends_at_rest && h * cells > 0.5 * contact_cells &&
        cells_crossed(Way(space_, setup_->sides, from, at.x).displacement(),
                      walls_.extent(at.cell, then)) <= rest_cells)
      return INSITU_END_STAGNATED;
    // On a flat wall it saves a step to find the wall again, to ask what is behind it.
    if (boundary_.response != AtBoundary::slide || n == Vec3d{} || turned ||
        is_behind(at, n, then) || !(math::dot(v, n) > 0.0))
      break;
    flat = may_glide && walls_.is_on_flat_face(at, n, then);
  } while (p.time != to && steps_left_ > 0 && p.length < max_length_);
  return INSITU_END_ALIVE;
}

template class Mover<DriftVelocity>;
template class Mover<ChartVelocity>;
template class Mover<CrossingVelocity<DriftVelocity>>;
template class Mover<CrossingVelocity<ChartVelocity>>;

} // namespace insitu::advect
