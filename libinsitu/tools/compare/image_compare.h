#pragma once

#include "compare/verdict.h"
#include "output/image/png.h"

namespace insitu::compare {

struct ImageOptions {
  /// The colour difference (CIEDE2000) that a pixel may have.
  double max_pixel = 1.0;
  /// The share of the pixels that may have more, from 0 to 1.
  double max_share = 0;
  /// The least mean structural similarity of the lightness.
  double min_similarity = 0.95;
};

/// What was measured. With alpha, each pixel is judged over black and over white, by the larger
/// difference; the similarity is the lower of the two.
struct ImageVerdict : Verdict {
  double worst = 0; ///< largest colour difference
  int worst_x = 0, worst_y = 0;
  std::size_t above = 0; ///< pixels over max_pixel
  double similarity = 1;
  /// The first image in dim grey; on it, in red to yellow to white, the pixels that moved, pixels
  /// over max_pixel at least bright red. Empty if the sizes differ.
  output::PngImage difference;
};

ImageVerdict compare_images(const output::PngImage& a, const output::PngImage& b,
                            const ImageOptions& options);

} // namespace insitu::compare
