#include "scene/tracers/field_between.h"

#include <algorithm>

namespace insitu::scene {

FieldBetween::FieldBetween(const commit::CommittedMesh& mesh, const mesh::FieldView& field,
                           const StepInterval& interval, insitu_accuracy accuracy, double time)
    : sampler_(mesh.sampler()), field_(field), before_(interval.other_cells),
      steps_(mesh.mesh().earlier_fields(field.name)) {
  options_.accuracy = accuracy;
  steps_.insert(steps_.begin(), field);
  steps_.resize(std::min(steps_.size(), std::size_t(1 + interval.steps_before)));
  count_ = interval.times.usable(steps_.size());
  if (count_ > 1)
    interval.times.weights(time, count_, weights_);
  alpha_ = interval.times.alpha(time);
  if (before_)
    field_before_ = before_->field(field.name);
  if (field_before_ && field_before_->components != field.components)
    field_before_.reset();
}

void FieldBetween::put(const math::Vec3d& x, const query::Location& place, double* scratch,
                       double* to) const {
  const auto n = std::size_t(field_.components);
  if (field_before_) {
    const query::Sampler there = before_->sampler();
    if (const query::Location at = there.locate(x, -1, options_)) {
      there.interpolate(*field_before_, at, to);
      if (!place)
        return;
      sampler_.interpolate(field_, place, scratch);
      for (std::size_t c = 0; c < n; ++c)
        to[c] = (1.0 - alpha_) * to[c] + alpha_ * scratch[c];
      return;
    }
  }
  if (!place)
    return;
  std::fill(to, to + n, 0.0);
  for (int s = 0; s < count_; ++s) {
    sampler_.interpolate(steps_[std::size_t(s)], place, scratch);
    for (std::size_t c = 0; c < n; ++c)
      to[c] += weights_[s] * scratch[c];
  }
}

} // namespace insitu::scene
