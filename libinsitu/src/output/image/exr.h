#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/image.h"

namespace insitu::output {

/// One channel of an OpenEXR file: width * height values, row 0 at the top, each `stride` values
/// after the one before.
struct ExrChannel {
  std::string name;
  std::variant<const float*, const std::uint32_t*> values;
  std::size_t stride = 1;
};

struct ExrAttribute {
  std::string name;
  std::variant<std::int64_t, double, std::string> value;
};

/// Writes an OpenEXR file of scan lines, each channel as it is in 32 bits, compressed without loss
/// (ZIP), atomically; with no time stamp, so that equal values give equal bytes with the same
/// versions of OpenEXR and zlib. Channels are stored in the order of their names. An integer
/// attribute beyond 32 bits becomes a number in double precision. Throws core::Error:
/// INSITU_ERROR_ARGUMENT if the size is none, INSITU_ERROR_FILE if the file cannot be written.
/// What it holds meanwhile counts as `counted` says.
void write_exr(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
               std::span<const ExrAttribute> attributes = {},
               const core::CountedAllocator<char>& counted = {});

/// Channels R, G, B and A, as linear light; colours are multiplied by alpha, as the format wants
/// them. Without alpha: R, G and B as they are.
void write_exr(const std::string& path, const core::Image& image, bool keep_alpha,
               std::span<const ExrAttribute> attributes = {});

} // namespace insitu::output
