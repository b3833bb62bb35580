#pragma once

#include <memory>
#include <string>
#include <vector>

#include "adaptive_meshes.h"
#include "core/context.h"
#include "paper/table.h"
#include "render/frame.h"

namespace insitu::bench::paper {

/// An adaptive mesh of ours with a field that is 1 within a sphere and 0 far outside.
class AdaptiveCase {
public:
  static AdaptiveCase of_blocks(std::int64_t cells);
  /// Balanced, about a front, as solvers refine.
  static AdaptiveCase of_front(std::int64_t cells);
  /// Random: the hard case.
  static AdaptiveCase of_octree(std::int64_t cells);
  /// That octree with more leaves, none beside one of more than one level above or below.
  static AdaptiveCase of_balanced_octree(std::int64_t cells);

  const char* name() const {
    return is_front_      ? "front octree"
           : is_balanced_ ? "balanced octree"
           : is_octree_   ? "random octree"
                          : "blocks";
  }
  const char* key() const { return is_front_ ? "front" : is_octree_ ? "octree" : "blocks"; }
  int level_count() const { return is_octree_ ? octree_.level_count : blocks_.level_count; }
  /// The same with its finest levels left off.
  AdaptiveCase cut(int level_count) const;
  /// Over the arrays here; not committed.
  std::unique_ptr<commit::CommittedMesh> make(core::Memory& memory) const;

private:
  void set_values();
  bool is_octree_ = false, is_balanced_ = false, is_front_ = false;
  workload::AmrMesh blocks_;
  workload::Octree octree_;
};

/// A committed mesh with its session's memory, and what it holds of it.
struct Held {
  std::unique_ptr<core::Context> context;
  PlainDual plain; ///< of a reference
  std::unique_ptr<commit::CommittedMesh> mesh;
  double data = 0.0, peak = 0.0, total = 0.0; ///< bytes; the solver's own arrays left out
};
/// As gridlets and stitching cells; and the same dual mesh as hexahedra and so on, its vertices
/// shared.
Held hold(const AdaptiveCase& mesh, int threads);
Held hold_reference(const Held& ours, int threads);

/// The volume over the mesh's box, thin enough for no ray to end early; nothing is skipped.
render::FrameSettings march_frame(const commit::CommittedMesh& mesh, int size);
/// A convergence frame: one path a pixel, multiple isotropic scattering under a white dome.
render::FrameSettings path_frame(const commit::CommittedMesh& mesh, int size);
/// View `i` of `count` around the box, spread over the sphere, from five distances in turn.
render::Camera orbit(int i, int count);

/// Figures 7 and 8 of one mesh, and a plot.
struct Orbit {
  Table figure_7, figure_8;
  std::string plot;
  bool failed = false; ///< counts did not agree
};
/// Figure 8, of the views' samples in stitching cells.
Table measure_faces(const AdaptiveCase& mesh, const Held& ours, const Held& reference, int views,
                    int size, int repetitions);
Orbit measure_orbit(const AdaptiveCase& mesh, const Held& ours, const Held& reference, int views,
                    int size, int repetitions);

} // namespace insitu::bench::paper
