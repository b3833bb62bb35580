#pragma once

#include <cstdint>

#include "advect/field/box.h"
#include "advect/field/moment.h"
#include "cells/kernels/kernels.h"
#include "query/sound_cells.h"

namespace insitu::advect {

/// A cell with all that is asked of it: its vertices, and the velocity there at each step. It is
/// loaded in two parts, so that many cells' data are waited for at once: open() reads the ids and
/// asks for the rest, which load() reads.
struct KeptCell {
  std::int64_t cell = -1;   ///< flat id of the cell that is loaded, or -1
  std::int64_t opened = -1; ///< of the cell that is open and not yet loaded, or -1
  double alpha = 1.0;       ///< of the geometry in vertices.x
  int values = 0;           ///< of the velocity: as many as vertices, or 1 of a cell field
  /// Whether it answers alone, where that is asked a cell at a time (Sampler::sound_cells).
  query::SoundCells::Known sound = query::SoundCells::Known::unknown;
  unsigned closed_on = 0; ///< vertices of a feature about which cells close, the last found, or 0
  mesh::CellVertices vertices;
  Box box;                             ///< of the vertices; of a mesh that moves, of everything
  math::Vec3d now[8], earlier[8];      ///< coordinates, if the mesh moves
  math::Vec3d velocity[most_steps][8]; ///< at the vertices, at each step, the current one first

  bool may_hold(const math::Vec3d& x) const { return cell >= 0 && box.holds(x); }
  void forget() { cell = opened = -1; }
  void open(std::int64_t cell, const Moment& moment);
  /// Of the cell that is open.
  void load(const Moment& moment);

  /// How far the material at coordinates r moves between the steps, if the mesh moves.
  math::Vec3d moved(const math::Vec3d& r) const {
    double weight[8];
    cells::shape_functions(vertices.shape, r, weight);
    math::Vec3d by;
    for (int i = 0; i < vertices.count; ++i)
      by += weight[i] * (now[i] - earlier[i]);
    return by;
  }
  /// The vertices at the current step.
  const math::Vec3d* current(const Moment& moment) const {
    return moment.moves() ? now : vertices.x;
  }
  /// Moves the vertices to where they are at a moment.
  void move_to(const Moment& moment) {
    if (!moment.moves() || alpha == moment.alpha())
      return;
    alpha = moment.alpha();
    for (int i = 0; i < vertices.count; ++i)
      vertices.x[i] = alpha == 1.0 ? now[i] : (1.0 - alpha) * earlier[i] + alpha * now[i];
  }
  /// The velocity at a moment at coordinates r in the cell. Returns whether it is finite.
  Sampled interpolate(const math::Vec3d& r, const Moment& moment, math::Vec3d& v) const {
    double weight[8];
    if (values == 1)
      weight[0] = 1.0;
    else
      cells::shape_functions(vertices.shape, r, weight);
    return moment.blend(
        [&](int step) {
          math::Vec3d u = weight[0] * velocity[step][0];
          for (int i = 1; i < values; ++i)
            u += weight[i] * velocity[step][i];
          return u;
        },
        v);
  }
  /// The lengths of the edges of its bounding box; see edges_of.
  math::Vec3d extent(const Moment& moment) const {
    return edges_of(moment.moves() ? box_of(vertices) : box);
  }
};

} // namespace insitu::advect
