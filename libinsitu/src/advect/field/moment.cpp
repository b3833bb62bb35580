#include "advect/field/moment.h"

namespace insitu::advect {

using math::Vec3d;

Moment::Moment(const query::Sampler& sampler, const mesh::FieldView& now,
               const EarlierSteps& earlier, double t0, double t1, insitu_accuracy accuracy)
    : sampler_(&sampler), fields_{now}, times_(t0, t1, earlier.before),
      steps_(times_.usable(1 + earlier.fields.size())),
      moves_(sampler.mesh().earlier_points && t1 != t0), accuracy_(accuracy) {
  for (int step = 1; step < steps_; ++step)
    fields_[step] = earlier.fields[std::size_t(step - 1)];
  if (sampler.mesh().is_flat)
    for (int step = 0; step < steps_; ++step)
      fields_[step].components = 2;
}

Vec3d Moment::at_step(const double* values, int step) const {
  const double* const v = values + components() * step;
  return {v[0], v[1], components() > 2 ? v[2] : 0.0};
}

Sampled Moment::interpolate(const query::Location& at, Vec3d& v) const {
  double u[3 * most_steps];
  sampler_->interpolate(fields(), at, u);
  return blend([&](int step) { return at_step(u, step); }, v);
}

Vec3d Moment::gradient(const query::Location& at, int component, double t) const {
  if (component >= components())
    return {};
  const auto of = [&](int step) {
    return sampler_->gradient(fields_[step], component, at, geometry_alpha_at(t));
  };
  if (steps_ == 1)
    return of(0);
  double w[most_steps];
  times_.weights(t, steps_, w);
  Vec3d sum = w[0] * of(0);
  for (int step = 1; step < steps_; ++step)
    sum += w[step] * of(step);
  return sum;
}

Vec3d Moment::rate_of_change(const query::Location& at, double t) const {
  if (steps_ == 1)
    return {};
  double u[3 * most_steps], w[most_steps];
  sampler_->interpolate(fields(), at, u);
  times_.rates(t, steps_, w);
  Vec3d sum;
  for (int step = 0; step < steps_; ++step)
    sum += w[step] * at_step(u, step);
  return sum;
}

} // namespace insitu::advect
