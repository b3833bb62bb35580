#include <cmath>
#include <gtest/gtest.h>

#include "compare/image_compare.h"
#include "compare/similarity.h"

namespace {

using namespace insitu::compare;
using insitu::output::PngImage;

PngImage gradient(int width, int height, int channels) {
  PngImage image{width, height, channels, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.pixels.push_back(std::uint8_t(255 * x / width));
      image.pixels.push_back(std::uint8_t(255 * y / height));
      image.pixels.push_back(std::uint8_t(128 + 60 * ((x / 8 + y / 8) % 2)));
      if (channels == 4) {
        image.pixels.push_back(std::uint8_t(x < width / 2 ? 255 : 128));
      }
    }
  }
  return image;
}

std::uint8_t& channel(PngImage& image, int x, int y, int k) {
  return image.pixels[std::size_t((y * image.width + x) * image.channels + k)];
}

TEST(ColourDifference, PublishedPairs) {
  // Sharma, Wu, Dalal (2005), table 1: blue where the rotation acts, greys, hues across 0 degrees,
  // large and small differences.
  struct Pair {
    Lab x, y;
    double difference;
  };
  const Pair pairs[] = {
      {{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
      {{50, 3.1571, -77.2803}, {50, 0, -82.7485}, 2.8615},
      {{50, 2.8361, -74.0200}, {50, 0, -82.7485}, 3.4412},
      {{50, -1.3802, -84.2814}, {50, 0, -82.7485}, 1.0000},
      {{50, 0, 0}, {50, -1, 2}, 2.3669},
      {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0009}, 7.1792},
      {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0011}, 7.2195},
      {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
      {{50, 2.5, 0}, {61, -5, 29}, 22.8977},
      {{50, 2.5, 0}, {56, -27, -3}, 31.9030},
      {{50, 2.5, 0}, {58, 24, 15}, 19.4535},
      {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
      {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082},
  };
  for (const Pair& pair : pairs) {
    EXPECT_NEAR(delta_e_2000(pair.x, pair.y), pair.difference, 5e-5);
    EXPECT_NEAR(delta_e_2000(pair.y, pair.x), pair.difference, 5e-5);
    EXPECT_EQ(delta_e_2000(pair.x, pair.x), 0);
  }
}

TEST(ColourDifference, WhiteGreyAndBlack) {
  const Lab white = lab_of_linear(1, 1, 1),
            grey = lab_of_linear(0.18418651851244416, 0.18418651851244416, 0.18418651851244416);
  EXPECT_NEAR(white.l, 100, 1e-12);
  EXPECT_NEAR(white.a, 0, 1e-9);
  EXPECT_NEAR(white.b, 0, 1e-9);
  EXPECT_NEAR(grey.l, 50, 1e-9); // L* = 50 is Y = (66 / 116)^3
  EXPECT_NEAR(lab_of_linear(0, 0, 0).l, 0, 1e-12);
}

TEST(Similarity, AgreesWithTheDefinition) {
  // One window that covers all of a small image: the means are those of a Gaussian, summed
  // directly.
  const int n = 5;
  Plane a{n, n, {}}, b{n, n, {}};
  for (int i = 0; i < n * n; ++i) {
    a.values.push_back(20 + 3.0 * ((i * 7) % 11));
    b.values.push_back(25 + 2.0 * ((i * 5) % 13));
  }
  double sum = 0;
  double lowest = 2;
  for (int cy = 0; cy < n; ++cy) {
    for (int cx = 0; cx < n; ++cx) {
      double w = 0, ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
      for (int pass = 0; pass < 2; ++pass) {
        for (int y = 0; y < n; ++y) {
          for (int x = 0; x < n; ++x) {
            const double g = std::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / 4.5);
            const double p = a.values[std::size_t(y * n + x)], q = b.values[std::size_t(y * n + x)];
            if (pass == 0) {
              w += g;
              ma += g * p;
              mb += g * q;
            } else {
              va += g * (p - ma) * (p - ma) / w;
              vb += g * (q - mb) * (q - mb) / w;
              cov += g * (p - ma) * (q - mb) / w;
            }
          }
        }
        if (pass == 0) {
          ma /= w;
          mb /= w;
        }
      }
      const double c1 = 1, c2 = 9; // (0.01 * 100)^2, (0.03 * 100)^2
      const double s =
          (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
      sum += s;
      lowest = std::min(lowest, s);
    }
  }
  const Similarity got = structural_similarity(a, b, 100);
  EXPECT_NEAR(got.mean, sum / (n * n), 1e-10);
  EXPECT_NEAR(got.lowest, lowest, 1e-10);
  EXPECT_EQ(structural_similarity(a, a, 100).mean, 1.0);
}

TEST(Images, EqualOnesAreSame) {
  for (const int channels : {3, 4}) {
    const PngImage image = gradient(50, 40, channels);
    const ImageVerdict verdict = compare_images(image, image, {});
    EXPECT_TRUE(verdict.same);
    EXPECT_EQ(verdict.worst, 0);
    EXPECT_EQ(verdict.similarity, 1);
  }
  // An opaque image with and without its alpha is the same picture.
  PngImage rgba = gradient(16, 16, 4);
  for (std::size_t i = 3; i < rgba.pixels.size(); i += 4) {
    rgba.pixels[i] = 255;
  }
  EXPECT_TRUE(compare_images(rgba, gradient(16, 16, 3), {}).same);
}

TEST(Images, OnePixelIsFoundAndShown) {
  const PngImage a = gradient(60, 50, 3);
  PngImage b = a;
  channel(b, 41, 17, 1) = std::uint8_t(channel(b, 41, 17, 1) + 90);
  const ImageVerdict verdict = compare_images(a, b, {});
  EXPECT_FALSE(verdict.same);
  EXPECT_EQ(verdict.worst_x, 41);
  EXPECT_EQ(verdict.worst_y, 17);
  EXPECT_EQ(verdict.above, 1u);
  ASSERT_EQ(verdict.difference.width, 60);
  EXPECT_EQ(verdict.difference.pixel(41, 17)[0], 255);
  for (int x = 0; x < 60; ++x) {
    const std::uint8_t* pixel = verdict.difference.pixel(x, 18);
    EXPECT_EQ(pixel[0], pixel[2]) << "grey where nothing moved";
  }
  ImageOptions one_of_them;
  one_of_them.max_share = 1.0 / 3000;
  EXPECT_TRUE(compare_images(a, b, one_of_them).same);
  ImageOptions wide;
  wide.max_pixel = verdict.worst;
  EXPECT_TRUE(compare_images(a, b, wide).same);
}

TEST(Images, OneCodeStepPassesAndStructureIsSeen) {
  const PngImage a = gradient(64, 64, 3);
  PngImage step = a;
  for (std::uint8_t& code : step.pixels) {
    code = std::uint8_t(code < 255 ? code + 1 : 255);
  }
  ImageOptions tolerant;
  tolerant.max_pixel = 2; // a dark pixel moves by more than 1 for one code
  const ImageVerdict stepped = compare_images(a, step, tolerant);
  EXPECT_TRUE(stepped.same) << stepped.lines[0];
  EXPECT_GT(stepped.worst, 0);

  // A checkerboard moved by one cell: half of the pixels move, and the structure with them.
  PngImage board = a, moved = a;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      for (int k = 0; k < 3; ++k) {
        channel(board, x, y, k) = std::uint8_t((x / 4 + y / 4) % 2 * 200);
        channel(moved, x, y, k) = std::uint8_t((x / 4 + y / 4 + 1) % 2 * 200);
      }
    }
  }
  ImageOptions only_structure;
  only_structure.max_share = 1;
  const ImageVerdict flipped = compare_images(board, moved, only_structure);
  EXPECT_FALSE(flipped.same);
  EXPECT_LT(flipped.similarity, 0);
}

TEST(Images, AlphaCounts) {
  const PngImage a = gradient(20, 20, 4);
  PngImage b = a;
  channel(b, 15, 5, 3) = 60;
  const ImageVerdict verdict = compare_images(a, b, {});
  EXPECT_FALSE(verdict.same);
  EXPECT_EQ(verdict.worst_x, 15);
  // What cannot be seen does not count.
  PngImage clear = a, other = a;
  channel(clear, 3, 3, 3) = channel(other, 3, 3, 3) = 0;
  channel(other, 3, 3, 0) = 200;
  EXPECT_TRUE(compare_images(clear, other, {}).same);
}

TEST(Images, OtherSizesAreDifferent) {
  const ImageVerdict verdict = compare_images(gradient(8, 9, 3), gradient(9, 8, 3), {});
  EXPECT_FALSE(verdict.same);
  EXPECT_NE(verdict.lines.at(0).find("8 x 9 -> 9 x 8"), std::string::npos);
}

} // namespace
