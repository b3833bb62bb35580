#pragma once

#include <cstdint>

#include "advect/effects/effects.h"
#include "advect/effects/kept_mover.h"
#include "advect/effects/sides.h"
#include "advect/effects/space.h"
#include "advect/field/box.h"
#include "math/vec.h"
#include "query/sampler.h"

namespace insitu::advect {

/// What became of a displacement.
enum class Moved : std::uint8_t { inside, left, stopped };

/// Moves particles by displacements through a mesh, with a response at its boundary. One object
/// serves one thread; every call is bounded, in corners, wedges and cracks as well.
class Walls {
public:
  /// sampler: among images where `space` has a chart. The arguments must outlive the object.
  Walls(const query::Sampler& sampler, insitu_accuracy accuracy, const Space& space,
        const Sides& sides, EffectWork& work)
      : sampler_(&sampler), accuracy_(accuracy), space_(space), sides_(&sides), work_(&work) {}

  /// Moves `at`, which must be inside the mesh blended by alpha, by d (in coordinates), and turns
  /// the vector `carried`, in metres, if not null, as the wall turns the motion. At a wall the
  /// response acts on what is left of d: a particle that meets walls too often is left where it is,
  /// and counted. Periodic sides let it through, if there is a cell behind. Adds the length of the
  /// path to `length`. On a chart the way is straight in the cells' coordinates; where it goes on
  /// in another sheet of them, it goes to the same place, and `carried` changes axes.
  Moved move(Spot& at, math::Vec3d d, const BoundaryEffect& boundary, double alpha, double& length,
             math::Vec3d* carried = nullptr);

  /// The outward normal (of length 1, in metres) of the wall that move() met last; 0 if it met
  /// none, one without area, or one on the chart of other axes.
  const math::Vec3d& wall() const { return wall_; }

  bool is_inside(const math::Vec3d& x, std::int64_t hint, double alpha) const {
    return bool(locate(space_.image(x, space_.pole_of(x)), hint, alpha));
  }

  /// Whether a flat face of its cell with this outward normal is where the spot is, to a few skins:
  /// so long as the cell holds what moves along it, that stays there. Not on a chart.
  bool is_on_flat_face(const Spot& at, const math::Vec3d& normal, double alpha) const;

  /// Where the material that is at the spot at alpha0 is at alpha1.
  math::Vec3d carry(const Spot& at, double alpha0, double alpha1) const;

  /// How near to the boundary a spot on it lies, in coordinates, along each axis: 1e-9 of its cell,
  /// or what rounding leaves of that.
  math::Vec3d skin(const Spot& at, double alpha) const;

  /// The box of a cell, in coordinates, and its edges in metres; of a geocentric mesh's those of a
  /// box east, north and between heights.
  Box box(std::int64_t cell, double alpha) const;
  math::Vec3d extent(std::int64_t cell, double alpha) const { return edges_of(box(cell, alpha)); }
  math::Vec3d edges(std::int64_t cell, double alpha) const;
  math::Vec3d middle(std::int64_t cell, double alpha) const; ///< of its vertices
  const Space& space() const { return space_; }
  Scale scale(const math::Vec3d& x) const { return space_.scale(x); }

private:
  query::Location locate(const math::Vec3d& x, std::int64_t hint, double alpha) const {
    return sampler_->locate(x, hint, {accuracy_, alpha});
  }
  void enter_axes(const math::Vec3d& x, const math::Vec3d& y, math::Vec3d* carried);
  void rename(Spot& at, double alpha, math::Vec3d* carried);
  bool next_sheet(Spot& at, math::Vec3d& rest, double alpha, math::Vec3d* carried);
  math::Vec3d normal_in_metres(const Scale& per_metre, const math::Vec3d& normal) const;
  void step_back(Spot& at, const math::Vec3d& out, double alpha) const;
  bool pass_side(Spot& at, const math::Vec3d& d, double alpha) const;

  const query::Sampler* sampler_;
  insitu_accuracy accuracy_;
  Space space_;
  const Sides* sides_;
  EffectWork* work_;
  math::Vec3d wall_;
};

/// a * b along each axis.
inline math::Vec3d by_axis(const math::Vec3d& a, const math::Vec3d& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

} // namespace insitu::advect
