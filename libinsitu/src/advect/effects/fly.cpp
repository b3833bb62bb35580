// Particles with inertia: Mover's way of moving them.
#include <algorithm>
#include <cmath>
#include <limits>

#include "advect/effects/mover.h"
#include "cells/kernels/kernels.h"

namespace insitu::advect {

namespace {

constexpr double first_cells = 0.1, largest_cells = 1.0, fixed_cells = 0.25, contact_cells = 0.1;
/// A particle that would not come further than this part of a cell from the wall rests on it: a
/// ball bounces infinitely often in a finite time.
constexpr double rest_cells = 1e-6;
constexpr double safety = 0.9, largest_growth = 5.0, smallest_factor = 0.2;
constexpr double largest_relative_error = 0.01;
constexpr int most_trials = 2200; // halving 1e308 to 1e-308 takes 2047

/// The velocity of the mesh at a place, if it moves.
Vec3d mesh_velocity(const MeshVelocity& flow, const query::Location& at) {
  const mesh::MeshView& mesh = flow.sampler().mesh();
  if (!flow.blends_geometry())
    return {};
  mesh::CellVertices then, now;
  mesh::gather(mesh, at.cell, then, 0.0);
  mesh::gather(mesh, at.cell, now, 1.0);
  double weight[8];
  cells::shape_functions(now.shape, at.parametric, weight);
  Vec3d moved;
  for (int v = 0; v < now.count; ++v)
    moved += weight[v] * (now.x[v] - then.x[v]);
  return moved / flow.interval();
}

} // namespace

/// b of inertial_step(): what moves the particle besides what is linear in its own velocity.
template <class V>
Sampled Mover<V>::force(const Vec3d& x, double t, Vec3d& b) {
  const Inertia& inertia = *effects_->inertia;
  query::Location at;
  Vec3d u;
  if (const Sampled s = velocity_.sample(x, t, u, at); s != Sampled::inside)
    return s;
  b = space_.from_scene(x, inertia.acceleration);
  if (std::isfinite(inertia.response_time))
    b += u / inertia.response_time;
  if (inertia.fluid_share != 0.0) {
    // Du/Dt = du/dt at a place that goes with the mesh + (u - the mesh's velocity) grad u, and the
    // axes turn where the fluid goes.
    const Vec3d relative = walls_.scale(x).coordinates(u) - mesh_velocity(flow(), at);
    Vec3d acceleration = velocity_.rate_of_change(at, t);
    for (int c = 0; c < 3; ++c)
      acceleration[c] += math::dot(velocity_.gradient(at, c, t), relative);
    const double spin = space_.spin(x, u);
    acceleration += Vec3d{-spin * u.y, spin * u.x, 0.0};
    b += inertia.fluid_share * acceleration;
  }
  return std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.z) ? Sampled::inside
                                                                        : Sampled::not_finite;
}

/// The law with the rotation along the axes at x.
template <class V>
Inertia Mover<V>::law_at(const Vec3d& x) const {
  Inertia law = *effects_->inertia;
  if (space_.is_chart())
    law.rotation = space_.from_earth(x, law.rotation);
  return law;
}

template <class V>
insitu_ending Mover<V>::fly(State& p, Carried& carried, double to, Work& work) {
  Vec3d x;
  if (!velocity_.point(p.x, x))
    return p.fresh ? INSITU_END_SEED_OUTSIDE : INSITU_END_LEFT;
  carried.velocity = space_.from_east_north(x, carried.velocity);
  const insitu_ending ending = fly_from(x, p, carried, to, work);
  carried.velocity = space_.to_east_north(x, carried.velocity);
  if (Spot at; ending == INSITU_END_ALIVE && space_.is_chart() && find(x, p.time, at))
    placed(p, at);
  else
    p.x = velocity_.place(x);
  return ending;
}

namespace {

/// Whether a way from x goes through the wall from which `back` brings a point back, by more than
/// rounding makes of x.
bool presses(const Vec3d& way, const Vec3d& back, const Vec3d& x) {
  const double rounding = 64.0 * std::numeric_limits<double>::epsilon() *
                          std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)});
  return -math::dot(way, back) > rounding * length_of(back);
}

} // namespace

template <class V>
insitu_ending Mover<V>::fly_from(Vec3d& x, State& p, Carried& carried, double to, Work& work) {
  const bool adaptive = is_adaptive(settings_.method);
  Vec3d b;
  bool known = false; // b, at x
  bool closing = false, begun = false;
  double too_long = 0.0; // the longest step that left the mesh, while closing
  for (;;) {
    if (!known) {
      Vec3d u;
      query::Location at;
      work.evaluations += 2;
      Sampled s = velocity_.sample(x, p.time, u, at);
      if (s == Sampled::inside)
        s = force(x, p.time, b);
      if (s != Sampled::inside)
        return s == Sampled::not_finite ? INSITU_END_NOT_FINITE
               : p.fresh                ? INSITU_END_SEED_OUTSIDE
                                        : INSITU_END_LEFT;
      velocity_.accepted();
      x = kept_inside(x);
      spot_cell_ = -1;
      p.fresh = false;
      if (std::isnan(carried.velocity.x))
        carried.velocity =
            effects_->inertia->begins ? space_.from_scene(x, *effects_->inertia->begins) : u;
      known = true;
      if (recorder_) {
        p.x = velocity_.place(x);
        begun ? recorder_->straight(p) : (*recorder_)(p);
        if (is_over())
          return INSITU_END_REMOVED;
      }
      begun = true;
    }
    if (!(p.time < to))
      return INSITU_END_ALIVE;
    const double remaining = to - p.time, length_left = max_length_ - p.length;
    const Vec3d extent = walls_.extent(cell(), flow().geometry_alpha(p.time));
    const Scale per_metre = walls_.scale(x);
    const Inertia inertia = law_at(x);
    const Vec3d v = carried.velocity;
    const double cells = cells_crossed(per_metre.coordinates(v), extent);
    if (!std::isfinite(cells))
      return INSITU_END_NOT_FINITE;
    if (std::isfinite(max_length_) && length_left <= 1e-12 * max_length_)
      return INSITU_END_EXPIRED;
    if (steps_left_ <= 0)
      return INSITU_END_STEP_LIMIT;

    const double cell_time = cells > 0.0 ? 1.0 / cells : remaining;
    double limit = (adaptive ? largest_cells : fixed_cells) * cell_time;
    if (settings_.max_step > 0.0)
      limit = settings_.max_step;
    double wanted = p.step;
    if (!closing && !adaptive)
      wanted = settings_.step > 0.0 ? settings_.step : limit;
    else if (wanted == 0.0)
      wanted = settings_.step > 0.0 ? settings_.step : first_cells * cell_time;
    double h = std::min({wanted, adaptive || settings_.step == 0.0 ? limit : wanted, remaining});
    if (const double speed = length_of(v); speed > 0.0)
      h = std::min(h, length_left / speed);
    const bool cut = h < wanted;

    const auto stage = [&](const Vec3d& y, double t, Vec3d& at_y) { return force(y, t, at_y); };
    const auto go = [&](const Vec3d& d) {
      return space_.image(x + space_.displacement(x, d), space_.pole_of(x));
    };
    const auto back = [&](const Vec3d& y, const Vec3d& at_y) {
      if (!space_.is_chart())
        return at_y;
      // The rotation is another there: what that changes, by the velocity at the start.
      const Vec3d other = space_.transport(y, x, law_at(y).rotation) - inertia.rotation;
      return space_.transport(y, x, at_y) - 2.0 * math::cross(other, v);
    };
    InertialTrial trial;
    double relative_error = 1e-4, chord = 0.0;
    bool exit = false, retried = false, forced = false;
    for (int trials = 0;; ++trials) {
      trial = inertial_step(stage, go, back, inertia, v, p.time, h, b);
      work.evaluations += 3;
      const double crossed = cells_crossed(per_metre.coordinates(trial.moved), extent);
      chord = length_of(trial.moved);
      double factor = 1.0;
      const auto is_close = [&] {
        return crossed <= settings_.exit_tolerance && h <= settings_.exit_tolerance * cell_time;
      };
      // Steps that rounding brings back to a wall, since they are so short, would go on without
      // end. A wall that responds takes them all; others are left by what goes on through them.
      if (trial.sampled == Sampled::inside && (closing || effects_->boundary)) {
        const Vec3d to_wall = kept_inside(trial.x) - trial.x;
        const Vec3d on = too_long * v + (0.5 * too_long * too_long / h) * (trial.v - v);
        if (!(to_wall == Vec3d{}) &&
            (effects_->boundary || is_close() || presses(per_metre.coordinates(on), to_wall, x)))
          trial.sampled = Sampled::outside;
      }
      if (trial.sampled == Sampled::not_finite && crossed <= settings_.exit_tolerance)
        return INSITU_END_NOT_FINITE;
      if (trial.sampled != Sampled::inside) {
        exit = trials == most_trials || is_close() || p.time + 0.5 * h == p.time;
        if (exit)
          break;
        too_long = closing ? std::max(too_long, h) : h;
        closing = true;
        factor = 0.5;
      } else if (crossed > 2.0 * largest_cells && settings_.max_step == 0.0 && adaptive) {
        factor = std::max(largest_cells / crossed, 1e-3);
      } else if (chord > length_left * (1.0 + 1e-12) && trials < most_trials) {
        factor = std::min(length_left / chord, 1.0 - 1e-12);
      } else if (adaptive) {
        const double fastest = std::max(length_of(v), length_of(trial.v));
        const double tolerance =
            std::max(std::min(settings_.tolerance, largest_relative_error * fastest), 1e-300);
        relative_error = std::max(trial.error / tolerance, 1e-4);
        const bool smallest =
            settings_.min_step > 0.0 ? h <= settings_.min_step : crossed <= settings_.min_cells;
        forced = relative_error > 1.0 && (smallest || trials == most_trials);
        if (forced && settings_.min_step > 0.0 && settings_.at_min_step == AtMinStep::end) {
          ++work.rejected;
          return INSITU_END_STEP_TOO_SMALL;
        }
        if (relative_error > 1.0 && !forced)
          factor = std::max({smallest_factor, safety / std::sqrt(relative_error),
                             std::min(settings_.min_step / h, 1.0 - 1e-12)});
      }
      if (factor == 1.0)
        break;
      ++work.rejected;
      retried = true;
      h *= factor;
    }

    if (exit) {
      closing = false;
      p.step = 0.0;
      known = false;
      if (!effects_->boundary)
        return INSITU_END_LEFT;
      if (const insitu_ending ending = touch_flying(x, p, carried, to, work);
          ending != INSITU_END_ALIVE)
        return ending;
      continue;
    }
    velocity_.accepted();
    trial.x = kept_inside(trial.x);
    if (recorder_) {
      State then = p;
      then.x = velocity_.place(trial.x);
      then.time = h == remaining ? to : p.time + h;
      recorder_->flew(then, Flight(space_, inertia, x, v, p.time, h, b, trial));
      if (is_over())
        return INSITU_END_REMOVED;
    }
    ++work.steps;
    work.forced += forced;
    steps_left_ -= !(closing && retried);
    carried.velocity = space_.transport(x, trial.x, trial.v);
    x = trial.x;
    p.time = h == remaining ? to : p.time + h;
    p.length += chord;
    b = trial.force;
    if (closing) {
      p.step = h;
      closing = retried; // two steps of one size in a row: past the obstacle
    } else if (adaptive) {
      const double factor = forced ? largest_growth
                                   : std::clamp(safety / std::sqrt(relative_error), smallest_factor,
                                                retried ? 1.0 : largest_growth);
      p.step = cut && !retried ? std::max(wanted, h * factor) : h * factor;
    }
  }
}

/// A particle with inertia at the wall: its velocity is turned there. One that the forces press to
/// the wall, and that would not come far from it, goes on along it.
template <class V>
insitu_ending Mover<V>::touch_flying(Vec3d& x, State& p, Carried& carried, double to, Work& work) {
  Spot at;
  if (!find(x, p.time, at))
    return INSITU_END_LEFT; // the mesh has moved away from it
  const double response_time = effects_->inertia->response_time;
  double now = flow().geometry_alpha(p.time);
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
  BoundaryEffect rest = boundary_;
  if (rest.response == AtBoundary::reflect)
    rest.response = AtBoundary::slide;
  do {
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

template class Mover<DriftVelocity>;
template class Mover<ChartVelocity>;
template class Mover<CrossingVelocity<DriftVelocity>>;
template class Mover<CrossingVelocity<ChartVelocity>>;

} // namespace insitu::advect
