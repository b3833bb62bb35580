#pragma once

#include <cstdint>

#include "advect/effects/effects.h"
#include "advect/field/homes.h"
#include "advect/integrate/settings.h"
#include "advect/particles.h"

namespace insitu::advect {

/// Where a particle is.
struct Spot {
  math::Vec3d x;          ///< among the cells: see Space
  std::int64_t cell = -1; ///< that holds x
};

/// A Mover between two moves of its particle, in plain data; a member without a meaning at its
/// stage has any value. Cells are flat ids, or -1.
struct KeptMover {
  /// What the mover is about: between the steps of integrate(), along a wall, in flight, along a
  /// wall with inertia, before a step of the walk, or on the way back to where that began. Before
  /// it has the particle: that comes in to the current cells by the flow (come_in), or is there,
  /// and the mover begins with it.
  enum class Stage : std::uint8_t {
    flow,
    touch,
    fly,
    touch_flying,
    walk,
    put_back,
    come_in,
    begin
  };
  /// A turn of the flow and the walk.
  struct Turn {
    bool begun = false;
    double from = 0.0, until = 0.0;
  };
  /// What put_back goes back to.
  struct Undo {
    bool inside = false;
    State before;
    Spot start;
    CellName cell; ///< of the start, which may be far from here by now
  };
  /// At a wall; n: its normal, v: the velocity there, if it was asked for.
  struct Contact {
    Spot at;
    bool has_v = false, flat = false;
    math::Vec3d v, n;
  };
  struct Flier {
    math::Vec3d x, force;
    bool knows_force = false, begun = false, closing = false;
    double too_long = 0.0;
  };
  struct FlyingContact {
    Spot at;
    math::Vec3d n, extent;
    double little = 0.0;
    bool stuck = false;
  };

  Stage stage = Stage::flow;
  std::int64_t spot_cell = -1, steps_left = 0;
  std::int64_t steps = 0; ///< of this call of integrate()
  double last_bounce = -1.0, direction = 1.0;
  double to = 0.0; ///< until when the mover goes without the walk
  Turn turn;
  Undo undo;
  Contact contact;
  Flier flier;
  FlyingContact flying;
  Carried carried;
  EffectWork effects; ///< of the mover's thread

  /// f(id) of each id of a cell.
  template <class F>
  void for_each_cell(F&& f) {
    for (std::int64_t* id : {&spot_cell, &contact.at.cell, &flying.at.cell})
      f(*id);
  }
};

/// Who tells what a mover has come to.
class MarkedMover {
public:
  virtual ~MarkedMover() = default;
  virtual void mark(KeptMover& to) const = 0;
};

} // namespace insitu::advect
