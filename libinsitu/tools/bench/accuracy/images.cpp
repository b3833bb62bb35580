#include "accuracy/images.h"

#include <cmath>

#include "compare/similarity.h"

namespace insitu::bench::accuracy {

double rms_error(const core::Image& a, const core::Image& b) {
  double sum = 0.0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double d = double(a.pixel(x, y)[c]) - double(b.pixel(x, y)[c]);
        sum += d * d;
      }
  return std::sqrt(sum / (3.0 * a.width * a.height));
}

double dissimilarity(const core::Image& a, const core::Image& b) {
  const auto luminance = [](const core::Image& image) {
    compare::Plane plane{image.width, image.height, {}};
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const float* p = image.pixel(x, y);
        plane.values.push_back(0.2126 * double(p[0]) + 0.7152 * double(p[1]) +
                               0.0722 * double(p[2]));
      }
    return plane;
  };
  return 1.0 - compare::structural_similarity(luminance(a), luminance(b), 1.0).mean;
}

} // namespace insitu::bench::accuracy
