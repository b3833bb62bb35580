#pragma once

#include <algorithm>
#include <cstdint>

#include "advect/field/cell_cache.h"
#include "advect/integrate/dense.h"
#include "advect/integrate/fields.h"

namespace insitu::advect {

/// Keeps a particle to one cell, its own, for steps that end at faces (see CellwiseField): how deep
/// in that cell points lie, along which of its faces the particle goes, and which cell is the next.
/// The cell itself is the own one of a CellCache.
class Confinement {
public:
  bool is_on() const { return is_on_; }
  /// Whether the cell to which start() has confined a particle answered for its place before, with
  /// the velocity that it has there now.
  bool is_answered() const { return is_answered_; }
  void release() { is_on_ = false; }

  /// Confines a particle at x to the cell into which it goes; hint: a cell near it, or -1; place:
  /// that of the point asked last. False where there is none to keep.
  bool start(CellCache& cells, const Moment& moment, const math::Vec3d& x,
             const math::Vec3d& towards, std::int64_t hint, const PlaceInCell& place);

  /// Notes a point's coordinates in the own cell, and the margin there. Returns whether the cell
  /// answers for the point: its interpolation goes on for half a cell beyond its faces.
  bool found(const KeptCell& own, bool converged, const math::Vec3d& r, double margin) {
    r_ = r;
    depth_ = depth_at(own, r, margin);
    for (int a = 0; a < 3; ++a) {
      least_[a] = std::min(least_[a], r[a]);
      most_[a] = std::max(most_[a], r[a]);
    }
    return converged && margin > -0.5;
  }
  /// A step begins at the point that was found last.
  void begin_step() { least_ = most_ = r_; }
  /// Whether the points found since the step began lie so near to each other in the own cell, for
  /// how deep the last one is, that the path did not leave the cell.
  bool stays_clear() const {
    const math::Vec3d d = most_ - least_;
    return depth_ > 4.0 * std::max({d.x, d.y, d.z});
  }
  /// The depth of the point that was found last.
  double last_depth() const { return depth_; }
  /// The coordinates of the point asked last in the own cell.
  const math::Vec3d& coordinates() const { return r_; }
  /// How deep in the own cell a point lies; -1 where that is not known. See CellwiseField.
  double depth(const KeptCell& own, const math::Vec3d& x);
  /// Coordinates in the own cell, exactly on the faces on which x lies, as owners' are: to
  /// rounding, and unless the mesh moves, whose coordinates between steps are rounded as well,
  /// also on those in whose planes it lies.
  static math::Vec3d on_faces(const KeptCell& own, const math::Vec3d& x, const math::Vec3d& r,
                              double error, bool moves);

  // Of a cell that does not move; see CellwiseField.
  double face_on(const KeptCell& own, const DenseStep& path, double low, double high);
  bool is_inside_before(const KeptCell& own, const DenseStep& path) const;

  /// Where a particle goes in the own cell: of a mesh that moves, against its material, if cells
  /// take boundaries.
  math::Vec3d way_in(const CellCache& cells, const Moment& moment,
                     const math::Vec3d& towards) const;

  // The parts of a CellwiseField's cross(): a place a little way on from x, the cell that holds it,
  // and what follows from where it is.
  math::Vec3d beyond(CellCache& cells, const Moment& moment, const math::Vec3d& x,
                     const math::Vec3d& towards);
  query::Location locate(CellCache& cells, const Moment& moment, const math::Vec3d& x) const;
  Crossed cross(CellCache& cells, const Moment& moment, const math::Vec3d& x,
                const query::Location& at);
  /// Where the particle goes, at the face that it comes to, in the coordinates of the next cell.
  void go_towards(const math::Vec3d& towards) { towards_ = towards; }

  /// Whether the place that a confined particle has come to may be beyond the mesh by more than
  /// rounding: a particle that goes along a face may be, and one that has just come to a face,
  /// which this call then forgets.
  bool may_be_beyond();
  /// How far beyond the mesh that place may be.
  double reach(const KeptCell& own, const Moment& moment) const;

private:
  static double most_way(const CellCache& cells, const Moment& moment, const math::Vec3d& way);
  static query::Location beside_own(CellCache& cells, const Moment& moment, const math::Vec3d& x);
  Crossed enter(CellCache& cells, const Moment& moment, const math::Vec3d& x,
                const query::Location& at);
  /// The depth at coordinates in the own cell, and this margin there.
  double depth_at(const KeptCell& own, const math::Vec3d& r, double margin) const {
    return along_ == 0 ? margin : depth_beside(own.vertices.shape, r);
  }
  double depth_beside(mesh::Shape shape, const math::Vec3d& r) const;

  bool is_on_ = false;
  bool is_answered_ = false;
  bool landed_ = false; ///< the particle has just come to a face of the own cell
  /// Faces of the own cell, a bit each, along which the particle goes: they are no ends of its way.
  unsigned along_ = 0;
  double depth_ = 0.0;       ///< of the point that was found last
  math::Vec3d r_;            ///< in the own cell, of the point asked last
  math::Vec3d least_, most_; ///< of the coordinates found since the step began
  math::Vec3d towards_;      ///< where the particle goes, at the face that it comes to
};

} // namespace insitu::advect
