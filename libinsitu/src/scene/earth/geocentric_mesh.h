#pragma once

#include <cstdint>

#include "commit/committed_mesh.h"
#include "core/context.h"
#include "scene/earth/shared_mesh.h"

namespace insitu::scene {

/// A mesh on Earth as frames from space draw it: its vertices in geocentric metres, their heights
/// above the WGS84 ellipsoid times a factor (see geo::Frame). The vertices are the one copy,
/// counted as INSITU_MEMORY_GEOCENTRIC; the rest is shared with the solver's mesh.
///
/// Cells are straight here between their geocentric vertices, whatever they are in the solver's
/// coordinates: an edge of length L lies up to L^2 / (8 R) below the surface that its ends are on,
/// R = 6.37e6 m (a degree: 242 m), before any exaggeration.
class GeocentricMesh {
public:
  GeocentricMesh(const std::string& name, double exaggeration, core::Memory& memory);

  /// Throws core::Error for a solver's mesh that is not on Earth or that is adaptive.
  static void check(const commit::CommittedMesh& own);

  /// Brings it up to date with `own`, the solver's mesh, which is committed: vertices are converted
  /// and the tree refitted or rebuilt only if own's changed since. Throws core::Error for a mesh
  /// that is not on Earth, that is adaptive, or whose depths would reach the Earth's centre.
  commit::CommittedMesh& update(const commit::CommittedMesh& own, core::Context& context);

  /// How often vertices were converted.
  std::int64_t conversions() const { return conversions_; }

private:
  void convert(const commit::CommittedMesh& own, core::Context& context);

  double exaggeration_;
  core::Buffer<math::Vec3d> points_;
  SharedMesh shared_;
  std::int64_t conversions_ = 0;
};

} // namespace insitu::scene
