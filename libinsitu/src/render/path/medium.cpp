#include "render/path/medium.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"
#include "render/path/path_settings.h"

namespace insitu::render {

Medium::Medium(const query::Sampler& sampler, const ScalarField& field,
               const TransferFunction& function, double density, double unit_distance,
               const Majorants& majorants, const core::Threads& threads, core::Memory& memory)
    : sampler_(sampler.among_images()), field_(field), function_(function),
      scale_(density / unit_distance), grid_(majorants.grid()),
      majorants_(memory, INSITU_MEMORY_FRAME), colors_(function) {
  if (!(density >= 0) || !(unit_distance > 0) || !std::isfinite(scale_))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("volume of '") + field.field.name + "': a density of " +
                          std::to_string(density) + " over a unit distance of " +
                          std::to_string(unit_distance) +
                          "; a density of 0 or more and a distance above 0 expected");
  majorants_.resize_discard(std::size_t(grid_.count()));
  threads.parallel_for(grid_.count(), 16384, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const float opacity = majorants.opacity(i);
      // A little above, for the rounding of values and logarithms; exactly 0 where nothing shows.
      majorants_[std::size_t(i)] =
          opacity > 0
              ? std::nextafter(float(extinction_of_opacity(opacity) * (1 + 1e-9)), HUGE_VALF)
              : 0.0f;
    }
  });
}

double Medium::extinction_of_opacity(double opacity) const {
  return scale_ * -std::log1p(-std::min(opacity, largest_opacity));
}

double Medium::extinction(double value) const {
  const double opacity = function_.opacity(value);
  return opacity >= TransferFunction::invisible ? extinction_of_opacity(opacity) : 0.0;
}

Color Medium::albedo(double value) const {
  return std::isnan(value) ? function_.color(value) : colors_(value);
}

} // namespace insitu::render
