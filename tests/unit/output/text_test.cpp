#include <gtest/gtest.h>
#include <set>

#include "output/files/text.h"

namespace {

using insitu::core::Image;
using insitu::output::draw_text;
using insitu::output::text_middle;
using insitu::output::text_width;
using insitu::output::TextStyle;

Image black(int width, int height) {
  Image image(width, height);
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    image.rgba[i] = 1;
  }
  return image;
}

float ink(const Image& image) {
  float sum = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    sum += image.rgba[i];
  }
  return sum;
}

TEST(Text, EveryGlyphHasInkInsideItsBoxAndNoTwoAreAlike) {
  for (const int height : {10, 13, 20, 40}) {
    std::set<insitu::core::CountedVector<float>> seen;
    for (char c = '!'; c <= '~'; ++c) {
      const std::string text(1, c);
      const int width = text_width(text, height);
      ASSERT_GT(width, 0);
      ASSERT_LT(width, height + 2) << c;
      Image image = black(3 * height, 2 * height);
      const int x = height, y = height / 2;
      TextStyle style;
      style.height = height;
      draw_text(image, x, y, text, style);
      EXPECT_GT(ink(image), 1.0f) << c << " at " << height;
      for (int row = 0; row < image.height; ++row) {
        for (int column = 0; column < image.width; ++column) {
          const bool inside =
              column >= x - 1 && column <= x + width && row >= y && row < y + height;
          if (!inside) {
            ASSERT_EQ(*image.pixel(column, row), 0) << c << " at " << height;
          }
        }
      }
      EXPECT_TRUE(seen.insert(image.rgba).second) << c << " looks like another, at " << height;
    }
  }
}

TEST(Text, StemsAreCrisp) {
  // The fitted stem of an I is full ink on whole pixels, with no more than one soft column a side.
  for (const int height : {10, 14, 16, 22, 40}) {
    Image image = black(height, height);
    TextStyle style;
    style.height = height;
    draw_text(image, 2, 0, "I", style);
    const int row = int(text_middle(height));
    EXPECT_GT(*image.pixel(2, row), 0.99f) << height;
    EXPECT_LT(*image.pixel(1, row), 0.01f) << height;
  }
}

TEST(Text, WidthAddsUpAndDigitsAreEqual) {
  for (const int height : {10, 16, 33}) {
    for (char c = '0'; c <= '9'; ++c) {
      EXPECT_EQ(text_width(std::string(1, c), height), text_width("0", height));
    }
    EXPECT_EQ(text_width("", height), 0);
    EXPECT_GT(text_width("i i", height), text_width("ii", height));
    EXPECT_EQ(text_width("abc", height) - text_width("ab", height),
              text_width("xyc", height) - text_width("xy", height));
  }
}

TEST(Text, ClipsAtTheImage) {
  Image image = black(20, 10);
  TextStyle style;
  style.height = 16;
  for (const int x : {-1000, -8, 15, 1000}) {
    for (const int y : {-1000, -8, 5, 1000}) {
      draw_text(image, x, y, "clip", style);
    }
  }
  EXPECT_GT(ink(image), 0.0f);
}

TEST(Text, Utf8UnitsAndUnknownCharacters) {
  const auto drawn = [](std::string_view text) {
    Image image = black(60, 30);
    TextStyle style;
    style.height = 20;
    draw_text(image, 4, 4, text, style);
    return image.rgba;
  };
  const insitu::core::CountedVector<float> unknown = drawn("\xe4\xb8\xad"); // outside the font
  for (const char* text :
       {"\u00b0", "\u00b5", "\u00b2", "\u00b3", "\u00b9", "\u207b", "\u00d7", "\u00b1", "\u2212"}) {
    EXPECT_NE(drawn(text), unknown) << text;
  }
  EXPECT_EQ(drawn("\xff"), unknown);               // no UTF-8
  EXPECT_EQ(drawn("\xe4\xb8"), drawn("\xff\xff")); // cut short: each byte is unknown
}

TEST(Text, BlendsOverWhatIsThere) {
  Image image(30, 30); // transparent
  TextStyle style;
  style.height = 20;
  style.color = {0.2f, 0.4f, 0.6f, 0.5f};
  draw_text(image, 5, 5, "I", style);
  const float* pixel = image.pixel(5, 5 + int(text_middle(20)));
  EXPECT_NEAR(pixel[0], 0.2f, 1e-6f);
  EXPECT_NEAR(pixel[3], 0.5f, 1e-6f);
  Image rim = black(40, 40);
  style.halo_width = 2;
  style.halo_color = {0, 1, 0, 1};
  draw_text(rim, 10, 10, "I", style);
  EXPECT_GT(rim.pixel(9, 10 + int(text_middle(20)))[1], 0.9f);
  EXPECT_EQ(rim.pixel(5, 10 + int(text_middle(20)))[1], 0.0f);
}

} // namespace
