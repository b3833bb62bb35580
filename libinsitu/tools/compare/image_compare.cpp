#include "compare/image_compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "compare/similarity.h"

namespace insitu::compare {

namespace {

using output::PngImage;

struct LinearTable {
  std::array<double, 256> value;
  LinearTable() {
    for (int code = 0; code < 256; ++code)
      value[std::size_t(code)] = output::decode_srgb(std::uint8_t(code));
  }
};

/// The image over a background of one grey, in L*a*b*.
std::vector<Lab> lab_over(const PngImage& image, double background) {
  static const LinearTable linear;
  const std::size_t count = std::size_t(image.width) * std::size_t(image.height);
  std::vector<Lab> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* pixel = &image.pixels[i * std::size_t(image.channels)];
    const double alpha = image.channels == 4 ? pixel[3] / 255.0 : 1.0;
    const auto over = [&](int k) {
      return alpha * linear.value[pixel[k]] + (1 - alpha) * background;
    };
    out[i] = lab_of_linear(over(0), over(1), over(2));
  }
  return out;
}

bool is_opaque(const PngImage& image) {
  for (std::size_t i = 3; image.channels == 4 && i < image.pixels.size(); i += 4)
    if (image.pixels[i] != 255)
      return false;
  return true;
}

Plane lightness(const std::vector<Lab>& lab, const PngImage& image) {
  Plane plane{image.width, image.height, std::vector<double>(lab.size())};
  std::transform(lab.begin(), lab.end(), plane.values.begin(), [](const Lab& c) { return c.l; });
  return plane;
}

/// Red at what is admitted, over yellow to white at ten times that.
void heat(double difference, double admitted, std::uint8_t* rgb) {
  const double scale = std::max(admitted, 0.5);
  const double t = std::clamp(std::log10(std::max(difference / scale, 1e-3)), -1.0, 1.0);
  rgb[0] = std::uint8_t(t < 0 ? 100 + 155 * (t + 1) : 255);
  rgb[1] = std::uint8_t(255 * std::clamp(2 * t, 0.0, 1.0));
  rgb[2] = std::uint8_t(255 * std::clamp(2 * t - 1, 0.0, 1.0));
}

PngImage difference_image(const PngImage& a, const std::vector<double>& moved, double admitted) {
  PngImage out{a.width, a.height, 3, core::CountedVector<std::uint8_t>(moved.size() * 3)};
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const std::uint8_t* from = &a.pixels[i * std::size_t(a.channels)];
    std::uint8_t* to = &out.pixels[3 * i];
    if (moved[i] > 0) {
      heat(moved[i], admitted, to);
    } else {
      const int grey = (54 * from[0] + 183 * from[1] + 19 * from[2]) / 256 / 3;
      std::fill(to, to + 3, std::uint8_t(grey));
    }
  }
  return out;
}

std::string pixel_text(const PngImage& image, int x, int y) {
  const std::uint8_t* pixel = image.pixel(x, y);
  std::string text = "(";
  for (int k = 0; k < image.channels; ++k)
    text += (k > 0 ? ", " : "") + std::to_string(pixel[k]);
  return text + ")";
}

std::string size_text(const PngImage& image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height);
}

std::string digits(const char* format, double value) {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

void measure(const PngImage& a, const PngImage& b, ImageVerdict& verdict,
             std::vector<double>& moved) {
  const bool opaque = is_opaque(a) && is_opaque(b);
  for (const double background : {0.0, 1.0}) {
    if (opaque && background > 0)
      break;
    const std::vector<Lab> in_a = lab_over(a, background), in_b = lab_over(b, background);
    for (std::size_t i = 0; i < in_a.size(); ++i)
      moved[i] = std::max(moved[i], delta_e_2000(in_a[i], in_b[i]));
    const Similarity similarity =
        structural_similarity(lightness(in_a, a), lightness(in_b, b), 100);
    verdict.similarity = std::min(verdict.similarity, similarity.mean);
  }
}

} // namespace

ImageVerdict compare_images(const PngImage& a, const PngImage& b, const ImageOptions& options) {
  ImageVerdict verdict;
  if (a.width != b.width || a.height != b.height) {
    verdict.differ("sizes: " + size_text(a) + " -> " + size_text(b) + " pixels");
    return verdict;
  }
  std::vector<double> moved(std::size_t(a.width) * std::size_t(a.height), 0.0);
  measure(a, b, verdict, moved);
  const std::size_t worst =
      std::size_t(std::max_element(moved.begin(), moved.end()) - moved.begin());
  verdict.worst = moved[worst];
  verdict.worst_x = int(worst % std::size_t(a.width));
  verdict.worst_y = int(worst / std::size_t(a.width));
  verdict.above = std::size_t(std::count_if(moved.begin(), moved.end(), [&](double difference) {
    return difference > options.max_pixel;
  }));
  verdict.difference = difference_image(a, moved, options.max_pixel);

  const double share = double(verdict.above) / double(moved.size());
  if (share > options.max_share) {
    verdict.differ("colour: " + count_text(verdict.above, "pixel") + " of " +
                   std::to_string(moved.size()) + " (" + digits("%.3g", 100 * share) +
                   " %) moved by more than " + digits("%.3g", options.max_pixel) +
                   " (CIEDE2000); at most " + digits("%.3g", 100 * options.max_share) + " % may");
  }
  if (verdict.similarity < options.min_similarity) {
    verdict.differ("structure: similarity " + digits("%.5f", verdict.similarity) + ", at least " +
                   digits("%.5f", options.min_similarity) + " asked");
  }
  if (verdict.worst == 0) {
    verdict.lines.push_back("same: every pixel of " + size_text(a));
    return verdict;
  }
  verdict.lines.push_back(
      (verdict.same ? "same within tolerance: " : "") + std::string("worst pixel (") +
      std::to_string(verdict.worst_x) + ", " + std::to_string(verdict.worst_y) + ") moved by " +
      digits("%.3g", verdict.worst) + ": " + pixel_text(a, verdict.worst_x, verdict.worst_y) +
      " -> " + pixel_text(b, verdict.worst_x, verdict.worst_y) + "; similarity " +
      digits("%.5f", verdict.similarity));
  return verdict;
}

} // namespace insitu::compare
