#include "advect/integrate/check.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "core/status.h"

namespace insitu::advect {

namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

} // namespace

void check_velocity(const mesh::FieldView& velocity, const mesh::MeshView& mesh) {
  const bool may_be_flat = mesh.is_flat || mesh.cell_count() == 0;
  if (velocity.components != 3 && !(may_be_flat && velocity.components == 2))
    throw core::Error(INSITU_ERROR_FIELD, "tracer: velocity '" + std::string(velocity.name) +
                                              "' needs 3 components, it has " +
                                              std::to_string(velocity.components));
}

IntegratorSettings settings_for(const mesh::FieldView& velocity, IntegratorSettings settings) {
  if (velocity.association == INSITU_CELL)
    settings.min_cells = std::max(settings.min_cells, 0.01);
  return settings;
}

void check_settings(const IntegratorSettings& s) {
  const auto refuse = [](const std::string& what, double value, const char* wanted) {
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "tracer: " + what + " must be " + wanted + ", " + number(value) + " given");
  };
  // Written so that NaN is refused.
  if (!(s.step >= 0.0))
    refuse("step", s.step, "positive");
  if (!(s.tolerance > 0.0))
    refuse("tolerance", s.tolerance, "positive");
  if (!(s.min_step >= 0.0))
    refuse("min_step", s.min_step, "positive");
  if (!(s.max_step >= 0.0))
    refuse("max_step", s.max_step, "positive");
  if (s.max_step > 0.0 && s.min_step > s.max_step)
    refuse("min_step", s.min_step, ("at most max_step = " + number(s.max_step)).c_str());
  if (s.max_steps < 1)
    refuse("max_steps", double(s.max_steps), "at least 1");
  if (!(s.min_cells >= 0.0))
    refuse("min_cells", s.min_cells, "positive");
  if (!(s.exit_tolerance > 0.0))
    refuse("exit_tolerance", s.exit_tolerance, "positive");
}

} // namespace insitu::advect
