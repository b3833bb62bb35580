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
  if (!space_.is_curved() || boundary_.response != AtBoundary::slide || !(out > 0.0))
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

/// A particle that is at a wall.
template <class V>
struct Mover<V>::Contact {
  Spot at;
  std::optional<Vec3d> v = {}; ///< the velocity there, if it was asked for
  Vec3d n = {};                ///< of the wall, outwards, once that is known
  bool flat = false;           ///< that wall, where the particle is
};

/// A particle that the velocity takes out of the mesh: goes on along the wall, or back from it, for
/// as long as the velocity presses it to the wall.
template <class V>
insitu_ending Mover<V>::touch(State& p, double to, Work& work) {
  Contact c;
  if (goes_on_) {
    take_up();
    c = {now_.contact.at, {}, now_.contact.n, now_.contact.flat};
    if (now_.contact.has_v)
      c.v = now_.contact.v;
  } else {
    if (!find(p, c.at))
      return INSITU_END_LEFT; // the mesh has moved away from it
  }
  if (boundary_.response == AtBoundary::leave || boundary_.response == AtBoundary::stop) {
    now_.contact = {c.at, false, false, {}, {}};
    if (travels() && moves_on(Stage::touch, c.at.cell)) // it has the cells beside its sides
      return INSITU_END_COUNT;
    return pass(p, c.at);
  }
  do {
    if (travels()) {
      now_.contact = {c.at, c.v.has_value(), c.flat, c.v.value_or(Vec3d{}), c.n};
      if (moves_on(Stage::touch, c.at.cell))
        return INSITU_END_COUNT;
    }
    if (!c.v) {
      Vec3d v;
      ++work.evaluations;
      velocity_.begin(c.at.cell);
      if (const Sampled s = velocity_at(c.at.x, p.time, v); s != Sampled::inside)
        return s == Sampled::outside ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
      velocity_.accepted();
      c.v = v;
    }
    Glide step{c.n, *c.v, c.at};
    const std::optional<insitu_ending> ending =
        c.flat && glide(p, step, to, work) ? glided(c, step, p, work) : step_along(c, p, to, work);
    if (ending)
      return *ending;
  } while (p.time != to && steps_left_ > 0 && p.length < max_length_);
  return INSITU_END_ALIVE;
}

/// Takes the particle to the end of a step along a flat wall. Returns how its touch of the wall
/// ends, if it does.
template <class V>
std::optional<insitu_ending> Mover<V>::glided(Contact& c, const Glide& step, State& p, Work& work) {
  const Spot from = c.at;
  ++work_.contacts;
  c.at = step.at;
  c.v = step.v;
  p.length += length_of(c.at.x - from.x);
  p.time = step.until;
  p.x = velocity_.place(c.at.x);
  spot_cell_ = c.at.cell;
  if (recorder_)
    recorder_->bent(p, step.first - c.at.x);
  ++work.steps;
  --steps_left_;
  if (is_over())
    return INSITU_END_REMOVED;
  if (c.at.cell != from.cell) {
    if (is_behind(c.at, c.n, 1.0))
      return INSITU_END_ALIVE;
    c.flat = walls_.is_on_flat_face(c.at, c.n, 1.0);
  }
  return {};
}

/// Whether the axes at both places, which are near each other, are almost the same, also behind a
/// periodic side.
template <class V>
bool Mover<V>::same_axes(const Vec3d& x, const Vec3d& y) const {
  return space_.same_axes(x, y) ||
         (setup_->sides.any() && space_.same_axes(x, x + setup_->sides.between(x, y)));
}

/// A step along the wall by Heun's method, or back from it. What the wall itself moves is not
/// resisted. Returns how the particle's touch of the wall ends, if it does.
template <class V>
std::optional<insitu_ending> Mover<V>::step_along(Contact& c, State& p, double to, Work& work) {
  const Spot from = c.at;
  const Vec3d v = *c.v;
  c.v.reset();
  const double now = flow().geometry_alpha(p.time);
  const Vec3d rate = walls_.scale(from.x).coordinates(v);
  const double cells = cells_along(from, v, c.n, now);
  if (settings_.ends_at_rest && !(cells > 0.0))
    return INSITU_END_STAGNATED;
  const double remaining = direction_ * (to - p.time);
  double h = std::min(cells > 0.0 ? contact_cells / cells : remaining, remaining);
  if (settings_.max_step > 0.0)
    h = std::min(h, settings_.max_step);
  if (max_length_ - p.length < length_of(v) * h)
    h = (max_length_ - p.length) / length_of(v);
  const double until = h < remaining ? p.time + direction_ * h : to;
  const double then = flow().geometry_alpha(until);
  c.at.x = walls_.carry(from, now, then);
  const Vec3d shift = c.at.x - from.x;
  // Between its ends the step begins along the first rate, which led to `first`.
  Vec3d mean = rate;
  std::optional<Vec3d> first;
  if (boundary_.response == AtBoundary::slide) {
    Spot ahead = c.at;
    double length = 0.0;
    Vec3d v1;
    if (walls_.move(ahead, h * rate - shift, boundary_, then, length) == Moved::inside) {
      velocity_.begin(ahead.cell);
      ++work.evaluations;
      if (velocity_at(ahead.x, until, v1) == Sampled::inside && same_axes(from.x, ahead.x)) {
        mean = 0.5 * (rate + walls_.scale(ahead.x).coordinates(v1));
        first = ahead.x;
      }
    }
  }
  const Moved moved = walls_.move(c.at, h * mean - shift, boundary_, then, p.length);
  c.n = walls_.wall();
  const bool turned = !same_axes(from.x, c.at.x);
  p.time = until;
  placed(p, c.at);
  if (recorder_)
    recorder_->bent(p, first && !turned ? Way(space_, setup_->sides, c.at.x, *first).displacement()
                                        : Vec3d{});
  ++work.steps;
  --steps_left_;
  if (moved != Moved::inside)
    return ending_of(moved);
  if (is_over())
    return INSITU_END_REMOVED;
  if (settings_.ends_at_rest && h * cells > 0.5 * contact_cells &&
      cells_crossed(Way(space_, setup_->sides, from.x, c.at.x).displacement(),
                    walls_.extent(c.at.cell, then)) <= rest_cells)
    return INSITU_END_STAGNATED;
  const bool slides = boundary_.response == AtBoundary::slide;
  if (!slides || c.n == Vec3d{} || turned || is_behind(c.at, c.n, then) ||
      !(math::dot(v, c.n) > 0.0))
    return INSITU_END_ALIVE;
  // On a flat wall it saves a step to find the wall again, to ask what is behind it.
  c.flat =
      !space_.is_curved() && !flow().blends_geometry() && walls_.is_on_flat_face(c.at, c.n, then);
  return {};
}

INSITU_MOVERS()

} // namespace insitu::advect
