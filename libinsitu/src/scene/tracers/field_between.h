#pragma once

#include <optional>
#include <vector>

#include "advect/integrate/in_time.h"
#include "commit/committed_mesh.h"
#include "commit/earlier/earlier_mesh.h"

namespace insitu::scene {

/// Between which steps particles move.
struct StepInterval {
  advect::StepTimes times{0.0, 0.0};
  int steps_before = 0; ///< before this one on the current cells, that may serve
  /// The step before, if it is on other cells; or null.
  const commit::EarlierMesh* other_cells = nullptr;
};

/// A field at a time between the last step and this one, interpolated as the velocity is: over the
/// steps on these cells, or between the step before on its own cells and this one
/// (advect::CrossingVelocity).
class FieldBetween {
public:
  /// A step on other cells is left out of account if it does not have the field, or has another
  /// kind of it.
  FieldBetween(const commit::CommittedMesh& mesh, const mesh::FieldView& field,
               const StepInterval& interval, insitu_accuracy accuracy, double time);

  /// place: x among the current cells, or none. scratch, to: [components]; `to` is left alone where
  /// no step holds x. Thread-safe.
  void put(const math::Vec3d& x, const query::Location& place, double* scratch, double* to) const;

private:
  const query::Sampler sampler_;
  const mesh::FieldView field_;
  const commit::EarlierMesh* before_;
  std::optional<mesh::FieldView> field_before_;
  query::LocateOptions options_;
  double alpha_;
  std::vector<mesh::FieldView> steps_;
  int count_;
  double weights_[advect::most_steps] = {1.0};
};

} // namespace insitu::scene
