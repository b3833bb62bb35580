#pragma once

#include "advect/effects/effects.h"
#include "advect/integrate/settings.h"
#include "advect/lines/streamlines.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::advect {

/// Throws Error(INSITU_ERROR_FIELD) unless the field has three components, or two on a flat mesh.
void check_velocity(const mesh::FieldView& velocity, const mesh::MeshView& mesh);

/// The settings for this velocity. A cell field jumps at every face, and is itself no better than a
/// cell: unless the smallest step was given, it is a hundredth of a cell.
IntegratorSettings settings_for(const mesh::FieldView& velocity, IntegratorSettings settings);

/// Throws Error(INSITU_ERROR_ARGUMENT) for a negative, NaN or contradictory setting.
void check_settings(const IntegratorSettings& settings);

/// Throws as Tracer::set_effects(), and Error(INSITU_ERROR_ARGUMENT) for effects that lines of a
/// steady velocity have not: a random walk, which has no velocity and one way of many; walls that
/// throw a line to and fro before them (reflect without inertia) or to its beginning (put_back);
/// inertia backwards, where drag makes every error grow as exp(t / response_time), or without an
/// end in time.
void check_line_effects(const StreamlineSettings& settings);

} // namespace insitu::advect
