#pragma once

#include "advect/effects.h"
#include "advect/settings.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::advect {

/// Throws Error(INSITU_ERROR_FIELD) unless the field has three components.
void check_velocity(const mesh::FieldView& velocity);

/// The settings for this velocity. A cell field jumps at every face, and is itself no better than a
/// cell: unless the smallest step was given, it is a hundredth of a cell.
IntegratorSettings settings_for(const mesh::FieldView& velocity, IntegratorSettings settings);

/// Throws Error(INSITU_ERROR_ARGUMENT) for a negative, NaN or contradictory setting.
void check_settings(const IntegratorSettings& settings);

/// Throws Error(INSITU_ERROR_UNSUPPORTED) for effects that no geodetic mesh has.
void check_chart_effects(const Effects& effects);

} // namespace insitu::advect
