#pragma once

#include "advect/integrate.h"
#include "mesh/view.h"

namespace insitu::advect {

/// Throws Error(INSITU_ERROR_FIELD) unless the field has three components.
void check_velocity(const mesh::FieldView& velocity);

/// Throws Error(INSITU_ERROR_ARGUMENT) for a negative, NaN or contradictory setting.
void check_settings(const IntegratorSettings& settings);

} // namespace insitu::advect
