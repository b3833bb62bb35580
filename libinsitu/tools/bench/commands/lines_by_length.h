#pragma once

#include <vector>

#include "commands/advect.h"
#include "commit/committed_mesh.h"

namespace insitu::bench {

/// Lines of a mesh's field "velocity" by their lengths, as vtkStreamTracer ends them: what its ends
/// are held against. Only errors across lines are told, since its adaptive lines are not as long as
/// it says, and its times are sums of step / speed at the step's begin, of order 1.
class LinesByLength {
public:
  /// The arguments must outlive the object.
  LinesByLength(const commit::CommittedMesh& mesh, const core::Threads& threads)
      : mesh_(&mesh), threads_(&threads) {}

  /// The part of what ends are off that is across the lines at the true ends: the root of the mean
  /// square, of those that are whole, or of all; in coordinates.
  double across(const std::vector<math::Vec3d>& ends, const std::vector<math::Vec3d>& truth,
                const std::vector<bool>& whole = {}) const;
  /// The same of a peer's whole lines, against the places of the true lines that are nearest to its
  /// ends. length: that was asked for.
  double across(const PeerLines& peer, const std::vector<math::Vec3d>& seeds, double length) const;

private:
  std::vector<math::Vec3d> ends(const std::vector<math::Vec3d>& seeds,
                                const std::vector<double>& lengths) const;
  math::Vec3d direction_at(const math::Vec3d& x) const;

  const commit::CommittedMesh* mesh_;
  const core::Threads* threads_;
};

} // namespace insitu::bench
