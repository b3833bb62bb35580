// Particles with inertia at walls: Mover's way of moving them.
#include <algorithm>

#include "advect/effects/mover.h"

namespace insitu::advect {

namespace {

constexpr double contact_cells = 0.1;
/// A particle that would not come further than this part of a cell from the wall rests on it: a
/// ball bounces infinitely often in a finite time.
constexpr double rest_cells = 1e-6;

} // namespace

/// A particle with inertia comes to the wall: its velocity is turned there. Returns how its contact
/// ends, if it does: else now_.flying is set.
template <class V>
std::optional<insitu_ending> Mover<V>::meet_flying(Vec3d& x, State& p, Carried& carried,
                                                   double now) {
  Spot at;
  if (!find(x, p.time, at))
    return INSITU_END_LEFT; // the mesh has moved away from it
  const Vec3d extent = walls_.extent(at.cell, now);
  const Vec3d edges = walls_.edges(at.cell, now);
  const double little = rest_cells * std::min({edges.x, edges.y, edges.z});
  const bool stuck = last_bounce_ >= 0.0 && p.length - last_bounce_ <= little;
  const Vec3d d = walls_.scale(at.x).coordinates(carried.velocity);
  Vec3d n;
  if (const double skins = cells_crossed(d, walls_.skin(at, now)); skins > 0.0) {
    const Moved moved =
        walls_.move(at, (8.0 / skins) * d, boundary_, now, p.length, &carried.velocity);
    landed(x, at);
    if (moved != Moved::inside)
      return ending_of(moved);
    n = walls_.wall();
  }
  last_bounce_ = p.length;
  --steps_left_;
  if (n == Vec3d{} && !stuck)
    return INSITU_END_ALIVE; // through a periodic side
  now_.flying = {at, n, extent, little, stuck};
  return std::nullopt;
}

/// A particle with inertia at the wall: its velocity is turned there. One that the forces press to
/// the wall, and that would not come far from it, goes on along it.
template <class V>
insitu_ending Mover<V>::touch_flying(Vec3d& x, State& p, Carried& carried, double to, Work& work) {
  const bool goes_on = goes_on_;
  if (goes_on)
    take_up();
  KeptMover::FlyingContact& c = now_.flying;
  const double response_time = effects_->inertia->response_time;
  double now = flow().geometry_alpha(p.time);
  if (!goes_on) {
    if (const std::optional<insitu_ending> ending = meet_flying(x, p, carried, now))
      return *ending;
  }
  Spot at = c.at;
  Vec3d n = c.n;
  const Vec3d extent = c.extent;
  const double little = c.little;
  const bool stuck = c.stuck;
  BoundaryEffect rest = boundary_;
  if (rest.response == AtBoundary::reflect)
    rest.response = AtBoundary::slide;
  do {
    if (travels()) {
      c.at = at;
      c.n = n;
      p.x = velocity_.place(x);
      now_.flier = {x, {}, false, true, false, 0.0};
      if (moves_on(Stage::touch_flying, at.cell))
        return INSITU_END_COUNT;
    }
    Vec3d b;
    velocity_.begin(at.cell);
    ++work.evaluations;
    if (const Sampled s = force(at.x, p.time, b); s != Sampled::inside)
      return s == Sampled::outside ? INSITU_END_LEFT : INSITU_END_NOT_FINITE;
    // What turns the velocity out of the wall presses; along the wall it turns about the normal.
    Inertia law = law_at(at.x);
    const Vec3d turn = -2.0 * math::cross(law.rotation, carried.velocity);
    const Vec3d acceleration = b - carried.velocity / response_time + turn;
    if (n != Vec3d{}) {
      law.rotation = math::dot(law.rotation, n) * n;
      b += math::dot(turn, n) * n;
    }
    const Scale per_metre = walls_.scale(at.x);
    const double press = math::dot(acceleration, n), back = math::dot(carried.velocity, n);
    if (!stuck && !(press > 0.0 && back * back / (2.0 * press) <= little))
      return INSITU_END_ALIVE;
    const double remaining = to - p.time;
    const Vec3d soon = carried.velocity + std::min(response_time, remaining) * acceleration;
    const double cells = std::max(cells_crossed(per_metre.coordinates(carried.velocity), extent),
                                  cells_crossed(per_metre.coordinates(soon), extent));
    const double h = cells > 0.0 ? std::min(contact_cells / cells, remaining) : remaining;
    const LinearPart linear(law, h);
    const double then = flow().geometry_alpha(p.time + h);
    const Vec3d moves = h * linear.phi(1, carried.velocity) + (h * h) * linear.phi(2, b);
    carried.velocity = linear.phi(0, carried.velocity) + h * linear.phi(1, b);
    Spot end = at;
    end.x = walls_.carry(at, now, then);
    const Moved moved = walls_.move(end, per_metre.coordinates(moves) - (end.x - at.x), rest, then,
                                    p.length, &carried.velocity);
    at = end;
    now = then;
    p.time = h < remaining ? p.time + h : to;
    last_bounce_ = p.length;
    landed(x, at);
    if (recorder_) {
      p.x = velocity_.place(x);
      recorder_->straight(p);
      if (is_over())
        return INSITU_END_REMOVED;
    }
    ++work.steps;
    --steps_left_;
    if (moved != Moved::inside)
      return ending_of(moved);
    n = walls_.wall();
    const Vec3d behind = by_axis(n, walls_.skin(at, now));
    if (n == Vec3d{} || walls_.is_inside(at.x + 8.0 * behind, at.cell, now))
      break;
  } while (p.time < to && steps_left_ > 0 && p.length < max_length_);
  return INSITU_END_ALIVE;
}

/// The place of a particle after a displacement.
template <class V>
void Mover<V>::landed(Vec3d& x, const Spot& at) {
  x = at.x;
  spot_cell_ = at.cell;
  velocity_.begin(at.cell);
}

INSITU_MOVERS()

} // namespace insitu::advect
