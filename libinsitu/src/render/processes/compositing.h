#pragma once

namespace insitu::render {

/// How a volume of several processes becomes one image.
enum class Compositing {
  /// That of one process, to the bit: each sample goes to the tile's owner.
  exact,
  /// Within 1/255 of that in each channel: each process composites the samples in its own cells, as
  /// far as they follow each other along a ray, and the tile's owner blends what they make.
  standard
};

} // namespace insitu::render
