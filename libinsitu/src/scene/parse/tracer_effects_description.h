#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "math/vec.h"
#include "scene/expression/trigger.h"
#include "scene/parse/names.h"

/// The effects on a tracer's particles, as plain data; part of description.h.
namespace insitu::scene {

struct NumberOrField {
  double number = 0.0;
  Name field; ///< empty: the number
};

/// Coefficients along x and y, and along z: length^2 / time.
struct DiffusionEffect {
  NumberOrField horizontal, vertical;
  double step = 0.0; ///< of the walk; 0: by the cells
  std::int64_t seed = 0;
};

/// A constant velocity, or a speed along `down`.
struct SettlingEffect {
  std::optional<math::Vec3d> velocity;
  NumberOrField speed;
  std::optional<math::Vec3d> down; ///< unit; else against the third axis, or along it in depths
};

struct WindageEffect {
  Name field;
  double factor = 1.0;
};

/// Either a response time, or a diameter with densities and a viscosity, or neither: no drag.
struct InertiaEffect {
  std::optional<double> response_time, diameter, viscosity;
  std::optional<double> density, fluid_density;
  math::Vec3d gravity;
  bool added_mass = false;
  std::optional<math::Vec3d> velocity; ///< at first; else the flow's
};

enum class WallResponse { leave, stop, slide, reflect, put_back };
struct WallEffect {
  WallResponse other = WallResponse::leave; ///< of sides that are not periodic
  bool periodic[3] = {};
  double restitution = 1.0;
};

struct RemoveEffect {
  Expression when;
  int line = 0;
};

struct TracerEffects {
  std::optional<DiffusionEffect> diffusion;
  std::optional<SettlingEffect> settling;
  std::optional<WindageEffect> windage;
  std::optional<InertiaEffect> inertia;
  std::optional<math::Vec3d> rotation; ///< of the frame, with inertia alone
  std::optional<WallEffect> boundary;
  std::optional<double> age_limit;
  std::optional<RemoveEffect> remove;

  /// Whether particles go other ways than the flow's.
  bool moves() const { return diffusion || settling || windage || inertia || boundary; }
};

} // namespace insitu::scene
