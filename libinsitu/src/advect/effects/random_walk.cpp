#include "advect/effects/random_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "advect/integrate/integrators.h"
#include "core/random.h"

namespace insitu::advect {

namespace {

using math::Vec3d;

constexpr double field_cells = 0.25, constant_cells = 0.5;

/// Three independent normal numbers (Box and Muller 1958).
Vec3d normal_numbers(std::uint64_t seed, std::int64_t id, std::int64_t number) {
  const std::uint64_t key = core::random_bits(seed, std::uint64_t(id), 0);
  double n[4];
  for (std::uint64_t pair = 0; pair < 2; ++pair) {
    // 1 - u is in (0, 1]: its logarithm is finite.
    const double radius =
        std::sqrt(-2.0 * std::log(1.0 - core::random_unit(key, std::uint64_t(number), 2 * pair)));
    const double angle = 2.0 * M_PI * core::random_unit(key, std::uint64_t(number), 2 * pair + 1);
    n[2 * pair] = radius * std::cos(angle);
    n[2 * pair + 1] = radius * std::sin(angle);
  }
  return {n[0], n[1], n[2]};
}

bool coefficient(const Coefficient& c, const query::Sampler& sampler, const query::Location& at,
                 double alpha, double& k) {
  k = c.constant;
  if (c.field)
    c.field->blended(sampler, at, alpha, &k);
  if (!std::isfinite(k))
    return false;
  k = std::max(k, 0.0);
  return true;
}

Vec3d gradient(const Coefficient& c, const query::Sampler& sampler, const query::Location& at,
               double alpha, double geometry) {
  if (!c.field)
    return {};
  Vec3d g = sampler.gradient(c.field->now, 0, at, geometry);
  if (!c.field->earlier.empty() && alpha != 1.0)
    g = alpha * g + (1.0 - alpha) * sampler.gradient(c.field->earlier[0], 0, at, geometry);
  return g;
}

bool jumps(const Coefficient& c) {
  return c.field && c.field->now.association == INSITU_CELL;
}

Vec3d root_by_axis(const Vec3d& v) {
  return {std::sqrt(v.x), std::sqrt(v.y), std::sqrt(v.z)};
}

double largest(const Coefficient& c, const mesh::MeshView& mesh, const core::Threads& threads) {
  if (!c.field)
    return c.constant;
  const mesh::FieldView& field = c.field->now;
  constexpr std::int64_t grain = 16384;
  double most = 0.0;
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const std::int64_t count = field.pieces[p].layout.count;
    std::vector<double> part(std::size_t((count + grain - 1) / grain), 0.0);
    threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      double& m = part[std::size_t(begin / grain)];
      for (std::int64_t i = begin; i < end; ++i)
        if (const double k = field.pieces[p].load(i, 0); k > m && std::isfinite(k))
          m = k;
    });
    for (const double m : part)
      most = std::max(most, m);
  }
  return most;
}

} // namespace

Vec3d largest_coefficients(const Diffusion& diffusion, const mesh::MeshView& mesh,
                           const core::Threads& threads) {
  const double h = largest(diffusion.horizontal, mesh, threads);
  return {h, h, largest(diffusion.vertical, mesh, threads)};
}

bool RandomWalk::coefficients(const query::Location& at, double alpha, Vec3d& k) const {
  if (!coefficient(diffusion_->horizontal, *sampler_, at, alpha, k.x) ||
      !coefficient(diffusion_->vertical, *sampler_, at, alpha, k.z))
    return false;
  k.y = k.x;
  return true;
}

/// Of the horizontal coefficient along the level axes at x, of the vertical one along the vertical.
Vec3d RandomWalk::gradients(const Vec3d& x, const query::Location& at, double alpha,
                            double geometry, const Space& space) const {
  const Scale per_metre = space.scale(x);
  const auto along_axes = [&](const Coefficient& c) {
    return space.to_level(x, per_metre.covector(gradient(c, *sampler_, at, alpha, geometry)));
  };
  const Vec3d h = along_axes(diffusion_->horizontal), v = along_axes(diffusion_->vertical);
  return {h.x, h.y, v.z};
}

double RandomWalk::step(const Vec3d& edges) const {
  if (diffusion_->step > 0.0)
    return diffusion_->step;
  double dt = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const Coefficient& c = a < 2 ? diffusion_->horizontal : diffusion_->vertical;
    const double reach = (c.field ? field_cells : constant_cells) * edges[a];
    dt = std::min(dt, reach * reach / (2.0 * largest_[a])); // 0: infinite
  }
  return dt;
}

bool RandomWalk::walk(Spot& at, double dt, std::int64_t id, std::int64_t number,
                      const BoundaryEffect& boundary, double alpha, double geometry, Walls& walls,
                      Moved& moved) const {
  const query::LocateOptions options{accuracy_, geometry};
  const query::Location here = sampler_->locate(at.x, at.cell, options);
  Vec3d k;
  moved = Moved::inside;
  if (!here)
    return true; // the mesh has moved away: the velocity will say so
  if (!coefficients(here, alpha, k))
    return false;
  const Vec3d normals = normal_numbers(diffusion_->seed, id, number);
  const Space& space = walls.space();
  double length = 0.0;
  Vec3d drift;
  if (jumps(diffusion_->horizontal) || jumps(diffusion_->vertical)) {
    // LaBolle: the coefficient is taken where the walk with the one here would lead.
    Spot ahead = at;
    const Vec3d d = by_axis(root_by_axis((2.0 * dt) * k), normals);
    walls.move(ahead, space.level_displacement(at.x, d), boundary, geometry, length);
    if (const query::Location there = sampler_->locate(ahead.x, ahead.cell, options);
        there && !coefficients(there, alpha, k))
      return false;
  } else if (diffusion_->horizontal.field || diffusion_->vertical.field) {
    // Visser: the gradient's drift, and the coefficient half of it further on.
    const Vec3d g = gradients(at.x, here, alpha, geometry, space);
    drift = dt * g;
    const Vec3d half = at.x + space.level_displacement(at.x, 0.5 * drift);
    const Vec3d image = space.image(half, space.pole_of(at.x));
    if (const query::Location there = sampler_->locate(image, here.cell, options)) {
      if (!coefficients(there, alpha, k))
        return false;
    } else { // behind the wall: as the gradient goes on
      for (int a = 0; a < 3; ++a)
        k[a] = std::max(0.0, k[a] + 0.5 * drift[a] * g[a]);
    }
  }
  if (space.is_curved() || space.is_geocentric())
    drift += dt * space.walk_drift(at.x, k.x, k.z);
  const Vec3d d = drift + by_axis(root_by_axis((2.0 * dt) * k), normals);
  if (!std::isfinite(length_of(d)))
    return false;
  moved = walls.move(at, space.level_displacement(at.x, d), boundary, geometry, length);
  return true;
}

} // namespace insitu::advect
