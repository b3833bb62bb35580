#pragma once

#include <fstream>
#include <string>

#include "output/image/png.h"
#include "part_session.h"

namespace insitu::test {

/// What a PNG file holds.
inline output::PngImage image_of(const std::string& bytes) {
  const OwnFolder folder;
  const std::string path = folder / "image.png";
  std::ofstream(path, std::ios::binary) << bytes;
  return output::read_png(path);
}

} // namespace insitu::test
