#pragma once

#include <cstdint>
#include <memory>

#include "accel/faces/face_neighbours.h"
#include "math/vec.h"
#include "mesh/shape.h"
#include "query/sampler.h"
#include "query/walk/number_steps.h"

namespace insitu::advect {

/// Guesses at the cell beyond a face, which have to be proven. By number: where cells are numbered
/// row by row, as on blocks and in layers, the step from a cell's number to its neighbour's is the
/// same almost everywhere. Where the mesh has a table of neighbours, by that.
class CellsBeyond {
public:
  /// Without a table looks for steps that most of a few cells have, once a topology; the time of
  /// some tens of queries. On a geodetic mesh, of its images.
  explicit CellsBeyond(const query::Sampler& sampler);
  /// For so many particles; null where that would take longer than they may gain.
  static std::unique_ptr<const CellsBeyond> worth(const query::Sampler& sampler,
                                                  std::int64_t particles) {
    constexpr std::int64_t few = 64;
    return particles < few && !sampler.neighbours() ? nullptr
                                                    : std::make_unique<const CellsBeyond>(sampler);
  }

  /// False: there is nothing to guess by.
  bool knows() const { return knows_; }
  /// So much that it is worth while to find out first how a point lies in the last cell.
  bool knows_most() const { return knows_most_; }
  /// Of most faces of a few cells no guess is made: with a table there would be.
  bool lacks_neighbours() const { return lacks_neighbours_; }
  /// Guesses for one point, each from where it lies in the cell before. A table tells one face at a
  /// time: a way over an edge or a vertex goes through the cells between.
  int most_guesses() const { return neighbours_ ? 4 : 2; }

  /// The cell in which a point may lie that has these coordinates in this cell, beyond its faces or
  /// this near to them; -1 where nothing is guessed. It is some number: there may be no such cell.
  std::int64_t guess(std::int64_t cell, mesh::Shape shape, const math::Vec3d& r,
                     double near = 0.0) const {
    if (cell >= cells_)
      return -1;
    if (neighbours_) {
      const int face = face_beyond(shape, r, near);
      return face < 0 ? -1 : neighbours_->across(cell, face);
    }
    const unsigned sides = sides_beyond(shape, r, near);
    const query::NumberSteps::Of& steps = of(shape == mesh::Shape::wedge);
    if (sides == 0 || (sides & ~steps.known) != 0)
      return -1;
    for (int side = 0; side < most_sides; ++side)
      if (sides >> side & 1U)
        cell += steps.step[side];
    return cell < cells_ ? cell : -1;
  }

  /// The guess at the cell across a face of a shape (cells::face_table), or -1.
  std::int64_t across(std::int64_t cell, mesh::Shape shape, int face) const;

  /// Asks for what a guess from this cell reads.
  void foresee(std::int64_t cell) const {
    if (neighbours_ && cell < cells_)
      neighbours_->foresee(cell);
  }

private:
  /// The face beyond which the point is furthest, or -1.
  static int face_beyond(mesh::Shape shape, const math::Vec3d& r, double near);

  static constexpr int most_sides = query::NumberSteps::most_sides;
  const query::NumberSteps::Of& of(bool wedges) const {
    return wedges ? steps_.wedges : steps_.bricks;
  }

  /// Bits: hexahedra and voxels have their faces' order (r = 0, r = 1, s = 0, ...), wedges r, s,
  /// their sum, t = 0 and t = 1; others none.
  static unsigned sides_beyond(mesh::Shape shape, const math::Vec3d& r, double near);
  static query::NumberSteps learn(const query::Sampler& sampler);
  static void learn(const query::Sampler& sampler, bool wedges, int side,
                    query::NumberSteps::Of& steps);
  bool tells_most(const mesh::MeshView& mesh) const;

  std::int64_t cells_; ///< of the mesh: from those behind, of other processes, nothing is guessed
  const accel::FaceNeighbours* neighbours_;
  query::NumberSteps steps_;
  bool knows_ = false, knows_most_ = false, lacks_neighbours_ = false;
};

} // namespace insitu::advect
