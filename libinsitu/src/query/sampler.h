#pragma once

#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "math/vec.h"
#include "mesh/view.h"

namespace insitu::accel {
class Tree;
}

namespace insitu::query {

/// The owner of a point: flat cell id (see mesh::MeshView), or -1 outside, and VTK's parametric
/// coordinates in it.
struct Location {
  std::int64_t cell = -1;
  math::Vec3d parametric;
  explicit operator bool() const { return cell >= 0; }
};

struct LocateOptions {
  insitu_accuracy accuracy = INSITU_STANDARD;
  /// Coordinates between the earlier (0) and the current step (1); needs MeshView::earlier_points
  /// unless 1.
  double alpha = 1.0;
};

/// Answers point queries on a committed mesh. Cheap to copy; valid until the next commit. All calls
/// are const and thread-safe, and their answers do not depend on threads, hints or batching.
class Sampler {
public:
  Sampler(const mesh::MeshView& mesh, const accel::Tree& tree) : mesh_(&mesh), tree_(&tree) {}

  const mesh::MeshView& mesh() const { return *mesh_; }
  const accel::Tree& tree() const { return *tree_; }

  /// The lowest flat cell id of the closed cells that hold p. hint: a cell to try first, or -1;
  /// it changes the time, not the answer.
  Location locate(const math::Vec3d& p, std::int64_t hint = -1,
                  const LocateOptions& options = {}) const;

  /// The same for a batch, in parallel; points and locations have the same size.
  void locate(const core::Threads& threads, std::span<const math::Vec3d> points,
              std::span<Location> locations, const LocateOptions& options = {}) const;

  /// The same on the calling thread alone (for callers that are inside a parallel_for).
  void locate_serial(std::span<const math::Vec3d> points, std::span<Location> locations,
                     const LocateOptions& options = {}) const;

  /// The field's components at a location (which must be inside): shape functions for vertex
  /// fields, the cell's value for cell fields.
  void interpolate(const mesh::FieldView& field, const Location& at, double* values) const;

  /// Like interpolate for a vertex-gathered evaluation of several fields at one location: the cell
  /// is gathered once. values holds the fields' components one after the other.
  void interpolate(std::span<const mesh::FieldView> fields, const Location& at,
                   double* values) const;

  /// The gradient, in physical space, of one component of a vertex field within the location's
  /// cell (zero for cell fields). alpha as in LocateOptions.
  math::Vec3d gradient(const mesh::FieldView& field, int component, const Location& at,
                       double alpha = 1.0) const;

private:
  const mesh::MeshView* mesh_;
  const accel::Tree* tree_;
};

} // namespace insitu::query
