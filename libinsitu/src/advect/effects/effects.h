#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "advect/integrate/in_time.h"
#include "math/vec.h"
#include "mesh/view.h"
#include "query/sampler.h"

/// What particles feel beside the velocity, as plain data for one advance; a tracer without effects
/// goes none of these ways. Lengths are in the mesh's units, or metres on a geodetic mesh, where
/// vectors are along east, north and up; times are in the solver's.
namespace insitu::advect {

/// A velocity that is added: `constant`, or factor times a field of three components, or a field of
/// one component along `direction`.
struct Drift {
  math::Vec3d constant;
  std::optional<FieldInTime> field;
  double factor = 1.0;
  math::Vec3d direction;
  bool is_local = false; ///< `constant` and `direction` are east, north and up at the particle, on
                         ///< a geocentric mesh, along whose axes fields of three components are
};

/// A number, or a field of one component.
struct Coefficient {
  double constant = 0.0;
  std::optional<FieldInTime> field;
};

/// A random walk whose particles spread as d<x^2>/dt = 2 K along each axis. Where K is a field, its
/// gradient is part of the walk, so that particles do not gather where K is small (Visser, Mar.
/// Ecol. Prog. Ser. 158, 1997, for vertex fields; LaBolle et al., Water Resour. Res. 36, 2000, for
/// cell fields, which jump).
struct Diffusion {
  Coefficient horizontal,
      vertical;      ///< along x and y, level; along z, upright. Length^2 / time, not negative
  double step = 0.0; ///< time of one step of the walk; 0: such that it is a part of a cell
  std::uint64_t seed = 0;
};

/// Particles with a velocity v of their own (Maxey and Riley, Phys. Fluids 26, 1983, without the
/// history term and Faxen's): dv/dt = (u - v) / response_time + acceleration - 2 rotation x v
/// + fluid_share Du/Dt.
struct Inertia {
  double response_time = std::numeric_limits<double>::infinity(); ///< infinite: no drag
  math::Vec3d acceleration;                                       ///< by gravity, less buoyancy
  math::Vec3d rotation;                                           ///< of the frame: angle / time
  double fluid_share = 0.0;          ///< 3 / (2 density ratio + 1) with added mass, else 0
  std::optional<math::Vec3d> begins; ///< the velocity of new particles; else that of the flow
};

enum class AtBoundary : std::uint8_t {
  leave,   ///< the particle ends: "left"
  stop,    ///< it ends where it is: "stopped"
  slide,   ///< the part of its motion that points out of the mesh is lost
  reflect, ///< the same is mirrored
  put_back ///< it is where it began the step (the advance, or a step of the walk), until that ends
};

struct BoundaryEffect {
  AtBoundary response = AtBoundary::leave;
  bool periodic[3] = {};    ///< what leaves one side of the mesh's box comes in at the opposite one
  double restitution = 1.0; ///< reflect, of inertial particles: share of the normal velocity kept
  bool any_periodic() const { return periodic[0] || periodic[1] || periodic[2]; }
};

/// Whether a particle of this age at this place ends as removed; values: of the fields of
/// Effects::removes_by there, the magnitudes of vectors. Called from any thread.
using Removes = std::function<bool(const std::vector<double>& values, const query::Location& at,
                                   const math::Vec3d& x, double age)>;

struct Effects {
  std::vector<Drift> drifts;
  std::optional<Diffusion> diffusion;
  std::optional<Inertia> inertia;
  std::optional<BoundaryEffect> boundary;
  Removes removes; ///< or null; asked at the end of each advance
  std::vector<mesh::FieldView> removes_by;
  /// The mesh is geocentric: vertical is the ellipsoid's normal at the particle, and the vectors of
  /// `inertia` but the rotation are east, north and up there.
  bool geocentric = false;
  bool is_flat = false; ///< the mesh is: fields of two components are vectors

  bool any() const { return !drifts.empty() || displaces() || bool(removes); }
  /// Whether there is more than the velocity that moves particles.
  bool displaces() const { return diffusion || inertia || boundary; }
  /// Whether a particle at a place of the sampler's mesh, of which the fields are, is removed.
  bool is_removed(const query::Sampler& sampler, const query::Location& at, const math::Vec3d& x,
                  double age) const {
    std::vector<double> values, components;
    for (const mesh::FieldView& field : removes_by) {
      components.resize(std::size_t(field.components));
      sampler.interpolate(field, at, components.data());
      double squares = 0.0;
      for (const double c : components)
        squares += c * c;
      values.push_back(field.components == 1 ? components[0] : std::sqrt(squares));
    }
    return removes(values, at, x, age);
  }
};

/// What effects did in one advance.
struct EffectWork {
  std::int64_t walk_steps = 0; ///< of the random walk
  std::int64_t contacts = 0;   ///< meetings with the boundary that had a response
  std::int64_t pinned = 0;     ///< moves cut short after too many contacts in a row

  EffectWork& operator+=(const EffectWork& b) {
    walk_steps += b.walk_steps;
    contacts += b.contacts;
    pinned += b.pinned;
    return *this;
  }
};

} // namespace insitu::advect
