#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "advect/effects/effects.h"
#include "advect/exits.h"
#include "advect/integrate/settings.h"
#include "advect/lines/polylines.h"
#include "advect/particles.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::advect {

enum class Direction : std::uint8_t { forward, backward, both };

struct StreamlineSettings {
  IntegratorSettings integrator; ///< ends_at_rest counts as true
  insitu_accuracy accuracy = INSITU_STANDARD;
  Direction direction = Direction::forward;
  double duration = std::numeric_limits<double>::infinity(); ///< then the line has expired
  double length = std::numeric_limits<double>::infinity();   ///< the same
  /// Vertices are recorded when the line has gone this far from the one before, in cells; the first
  /// and the last always.
  double spacing = 0.05;
  /// If one of them is above 0: vertices are instead exactly so far apart from the seed on, in time
  /// or along the curve, and the last one is at the end of the line, where it takes the place of
  /// one that is nearer to it than a thousandth of that. At most EvenSpacing::most and the end.
  double even_time = 0.0, even_length = 0.0;
  /// On a particle that the velocity as it is now would carry for ever: see check_line_effects().
  /// `removes` is asked all along the line, with |s| as age. Walls meet the velocity of the line's
  /// direction. Fields are those of now.
  Effects effects;
  Exits* exits = nullptr; ///< who tells apart how lines left, or null
};

struct Streamlines {
  Polylines lines; ///< line l: seed l (both: seed l / 2, forward for even l, backward for odd l)
  Counts counts;   ///< a line is a particle
  Work work;
  EffectWork effects;
};

/// Lines from the seeds through the velocity as it is now: dx/ds = v(x), with s = 0 at the seed
/// (`times` holds s, negative backwards; `particles` the seed's number). velocity has three
/// components, else Error(INSITU_ERROR_FIELD). Throws for effects as Tracer::set_effects() does,
/// and Error(INSITU_ERROR_ARGUMENT) for those that lines have not. The answer does not depend on
/// the thread count.
Streamlines trace_streamlines(const query::Sampler& sampler, const mesh::FieldView& velocity,
                              std::span<const math::Vec3d> seeds,
                              const StreamlineSettings& settings, const core::Threads& threads,
                              core::Memory& memory);

} // namespace insitu::advect
