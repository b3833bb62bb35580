#pragma once

#include <vector>

#include "advect/integrate/settings.h"
#include "query/some_cells.h"

namespace insitu::advect {

/// Where a particle left, or was seeded outside.
struct LeftAt {
  std::size_t particle = 0;
  Vec3d x;                ///< the last place inside, or the seed; in the mesh's frame
  std::int64_t cell = -1; ///< that holds it; -1: none does, as for seeds outside
  Vec3d normal;           ///< of the face, outwards, among the cells; 0: not known
  double alpha = 1.0;     ///< of the coordinates there
  bool seeded = false;    ///< outside
};

/// Tells apart why particles left, by what lies just beyond their face: nothing, cells that are
/// hidden or another process's, cells in which the velocity has no value, or a gap before the mesh
/// goes on.
class Exits {
public:
  /// whole: all cells that own points, of which the tracer may have some. left_out: brought up to
  /// date when it is asked for; it must outlive the object.
  Exits(const query::Sampler& whole, core::FunctionRef<query::SomeCells*()> left_out,
        insitu_accuracy accuracy)
      : whole_(whole), left_out_(left_out), accuracy_(accuracy) {}

  /// A place, or a way on from there, about which cells of other processes have a say too.
  struct Beyond {
    bool open = false; ///< others may tell
    Vec3d x, way;      ///< way: 0: the place alone
    double alpha = 1.0;
  };

  /// inside: the tracer's cells. INSITU_END_SEED_OUTSIDE or INSITU_END_LEFT where nothing else is
  /// to be said. beyond, if not null: is set where these cells do not tell, and others may.
  insitu_ending ending(const query::Sampler& inside, const LeftAt& left, Beyond* beyond = nullptr);
  /// What the cells here have to say about another process's particle: INSITU_END_LEFT: nothing.
  insitu_ending ending(const query::Sampler& inside, const Beyond& beyond);
  /// What counts, of what the cells of two processes have to say.
  static insitu_ending stronger(insitu_ending a, insitu_ending b);

private:
  insitu_ending of_place(const Vec3d& image, double alpha);

  query::Sampler whole_;
  core::FunctionRef<query::SomeCells*()> left_out_;
  query::SomeCells* made_ = nullptr;
  bool asked_ = false;
  insitu_accuracy accuracy_;
};

} // namespace insitu::advect
