#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "output/image/exr.h"

/// Images of numbers, row 0 at the top: how far away something is seen, and in which cell. What is
/// held while they are written counts as `counted` says.
namespace insitu::output {

/// The least and the greatest finite depth; both 0 where nothing is seen.
struct DepthScale {
  float low = 0, high = 0;
};
DepthScale depth_scale(std::span<const float> depth);

/// Grey of 16 bits: 0 at the scale's low end to 65534 at its high end, rounded to the nearest;
/// 65535 where the depth is not finite. The ends stand in the file's text, `depth_low` and
/// `depth_high`. Errors as write_png's.
void write_depth_png(const std::string& path, int width, int height, std::span<const float> depth,
                     const DepthScale& scale, const core::CountedAllocator<char>& counted = {});
/// Channel Z, in single precision, infinite where nothing is seen.
void write_depth_exr(const std::string& path, int width, int height, std::span<const float> depth,
                     std::span<const ExrAttribute> attributes = {},
                     const core::CountedAllocator<char>& counted = {});

/// RGB of 16 bits: the cell's id and 1, the highest 16 of its 48 bits in red and the lowest in
/// blue; 0 (black) for ids below 0. Throws INSITU_ERROR_ARGUMENT for an id of more bits.
void write_cell_png(const std::string& path, int width, int height,
                    std::span<const std::int64_t> cell,
                    const core::CountedAllocator<char>& counted = {});
/// Channel `cell`, unsigned: the id and 1; 0 for ids below 0. Throws INSITU_ERROR_ARGUMENT for an
/// id of 2^32 - 1 or more.
void write_cell_exr(const std::string& path, int width, int height,
                    std::span<const std::int64_t> cell,
                    std::span<const ExrAttribute> attributes = {},
                    const core::CountedAllocator<char>& counted = {});

} // namespace insitu::output
