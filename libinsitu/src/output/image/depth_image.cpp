#include "output/image/depth_image.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"
#include "output/files/csv.h"
#include "output/image/png.h"

namespace insitu::output {

namespace {

void require_pixels(const std::string& path, int width, int height, std::size_t count) {
  if (width < 1 || height < 1 || count != std::size_t(width) * std::size_t(height))
    throw core::Error(INSITU_ERROR_ARGUMENT, "image for '" + path + "': " + std::to_string(width) +
                                                 " x " + std::to_string(height) +
                                                 " pixels do not make " + std::to_string(count) +
                                                 " values");
}

/// The id and 1, or 0 for none.
std::uint64_t code_of(const std::string& path, std::int64_t cell, int bits) {
  const std::uint64_t code = cell < 0 ? 0 : std::uint64_t(cell) + 1;
  if (code >> bits)
    throw core::Error(INSITU_ERROR_ARGUMENT, "image for '" + path + "': cell " +
                                                 std::to_string(cell) + " takes more than " +
                                                 std::to_string(bits) + " bits");
  return code;
}

} // namespace

DepthScale depth_scale(std::span<const float> depth) {
  DepthScale scale{HUGE_VALF, -HUGE_VALF};
  for (const float d : depth)
    if (std::isfinite(d)) {
      scale.low = std::min(scale.low, d);
      scale.high = std::max(scale.high, d);
    }
  return scale.low <= scale.high ? scale : DepthScale{};
}

void write_depth_png(const std::string& path, int width, int height, std::span<const float> depth,
                     const DepthScale& scale, const core::CountedAllocator<char>& counted) {
  require_pixels(path, width, height, depth.size());
  PngValues image{width, height, 1, core::CountedVector<std::uint16_t>(counted), {}};
  image.values.reserve(depth.size());
  const double range = double(scale.high) - double(scale.low);
  for (const float d : depth) {
    const double part = range > 0 ? std::clamp((double(d) - scale.low) / range, 0.0, 1.0) : 0.0;
    image.values.push_back(std::isfinite(d) ? std::uint16_t(std::lround(65534 * part)) : 65535);
  }
  std::string low, high;
  append_number(low, scale.low);
  append_number(high, scale.high);
  image.text = {{"depth_low", low}, {"depth_high", high}};
  write_png(path, image);
}

void write_depth_exr(const std::string& path, int width, int height, std::span<const float> depth,
                     std::span<const ExrAttribute> attributes,
                     const core::CountedAllocator<char>& counted) {
  require_pixels(path, width, height, depth.size());
  const ExrChannel channel{"Z", depth.data()};
  write_exr(path, width, height, {&channel, 1}, attributes, counted);
}

void write_cell_png(const std::string& path, int width, int height,
                    std::span<const std::int64_t> cell,
                    const core::CountedAllocator<char>& counted) {
  require_pixels(path, width, height, cell.size());
  PngValues image{width, height, 3, core::CountedVector<std::uint16_t>(counted), {}};
  image.values.reserve(3 * cell.size());
  for (const std::int64_t id : cell) {
    const std::uint64_t code = code_of(path, id, 48);
    for (int shift = 32; shift >= 0; shift -= 16)
      image.values.push_back(std::uint16_t(code >> shift));
  }
  write_png(path, image);
}

void write_cell_exr(const std::string& path, int width, int height,
                    std::span<const std::int64_t> cell, std::span<const ExrAttribute> attributes,
                    const core::CountedAllocator<char>& counted) {
  require_pixels(path, width, height, cell.size());
  core::CountedVector<std::uint32_t> codes(counted);
  codes.reserve(cell.size());
  for (const std::int64_t id : cell)
    codes.push_back(std::uint32_t(code_of(path, id, 32)));
  const ExrChannel channel{"cell", codes.data()};
  write_exr(path, width, height, {&channel, 1}, attributes, counted);
}

} // namespace insitu::output
