#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "core/status.h"
#include "output/image/png.h"
#include "unit/output/folder.h"

namespace {

using insitu::core::Error;
using insitu::core::Image;
using insitu::output::decode_srgb;
using insitu::output::encode_srgb;
using insitu::output::PngImage;
using insitu::output::read_png;
using insitu::output::write_png;
using test::content;
using test::Folder;
using test::put;

/// The standard's function, in long double and by its own formula.
int encoded_by_formula(long double c) {
  const long double s = c <= 0.0031308L ? 12.92L * c : 1.055L * std::pow(c, 1.0L / 2.4L) - 0.055L;
  return int(std::floor(255 * s + 0.5L));
}

TEST(Srgb, EveryCodeReadsBack) {
  for (int code = 0; code < 256; ++code) {
    EXPECT_EQ(encode_srgb(decode_srgb(std::uint8_t(code))), code);
  }
  EXPECT_NEAR(decode_srgb(255), 1.0, 1e-7);
  // Half of the light is code 188, the standard's well-known example; 18 % grey is 118.
  EXPECT_EQ(encode_srgb(0.5f), 188);
  EXPECT_EQ(encode_srgb(0.18f), 118);
}

TEST(Srgb, RoundsToTheNearest) {
  int checked = 0;
  float value = 1e-6f;
  while (value < 1.0f) {
    ASSERT_EQ(encode_srgb(value), encoded_by_formula(value)) << value;
    value = std::nextafter(value * 1.00002f, 2.0f);
    ++checked;
  }
  EXPECT_GT(checked, 500000);
}

TEST(Srgb, OutOfRangeIsClamped) {
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(encode_srgb(-1.0f), 0);
  EXPECT_EQ(encode_srgb(-inf), 0);
  EXPECT_EQ(encode_srgb(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(encode_srgb(1.0f), 255);
  EXPECT_EQ(encode_srgb(1e30f), 255);
  EXPECT_EQ(encode_srgb(inf), 255);
}

PngImage noise(int width, int height, int channels) {
  PngImage image{width, height, channels, {}};
  std::mt19937 random(5);
  image.pixels.resize(std::size_t(width) * std::size_t(height) * std::size_t(channels));
  for (std::uint8_t& byte : image.pixels) {
    byte = std::uint8_t(random());
  }
  return image;
}

TEST(Png, RoundTrip) {
  const Folder folder;
  for (const int channels : {3, 4}) {
    const PngImage image = noise(37, 19, channels);
    write_png(folder / "a.png", image);
    const PngImage back = read_png(folder / "a.png");
    EXPECT_EQ(back.width, 37);
    EXPECT_EQ(back.height, 19);
    EXPECT_EQ(back.channels, channels);
    EXPECT_EQ(back.pixels, image.pixels);
  }
}

TEST(Png, SameBytesEveryTimeAndSaysSrgb) {
  const Folder folder;
  write_png(folder / "a.png", noise(64, 64, 4));
  write_png(folder / "b.png", noise(64, 64, 4));
  const std::string bytes = content(folder / "a.png");
  EXPECT_EQ(bytes, content(folder / "b.png"));
  EXPECT_NE(bytes.find("sRGB"), std::string::npos);
  EXPECT_EQ(bytes.find("tIME"), std::string::npos);
}

TEST(Png, LinearImage) {
  const Folder folder;
  Image image(2, 1);
  const float values[8] = {0.5f, 0, 1, 0.25f, -1, 0.18f, 2, 1};
  std::memcpy(image.rgba.data(), values, sizeof values);
  write_png(folder / "rgb.png", image);
  EXPECT_EQ(read_png(folder / "rgb.png").pixels,
            (insitu::core::CountedVector<std::uint8_t>{188, 0, 255, 0, 118, 255}));
  write_png(folder / "rgba.png", image, true);
  EXPECT_EQ(read_png(folder / "rgba.png").pixels,
            (insitu::core::CountedVector<std::uint8_t>{188, 0, 255, 64, 0, 118, 255, 255}));
}

TEST(Png, BadFilesAreNamed) {
  const Folder folder;
  write_png(folder / "good.png", noise(64, 64, 3));
  const std::string good = content(folder / "good.png");
  put(folder / "short.png", good.substr(0, good.size() / 2));
  std::string flipped = good;
  flipped[good.size() / 2] = char(flipped[good.size() / 2] ^ 0x55);
  put(folder / "flipped.png", flipped);
  put(folder / "text.png", "not a picture at all");
  put(folder / "empty.png", "");
  for (const char* name : {"short.png", "flipped.png", "text.png", "empty.png", "absent.png"}) {
    try {
      (void)read_png(folder / name);
      ADD_FAILURE() << name << " was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), INSITU_ERROR_FILE);
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  }
}

TEST(Png, ImpossibleImagesAreRefused) {
  const Folder folder;
  EXPECT_THROW(
      write_png(folder / "a.png", PngImage{2, 2, 3, insitu::core::CountedVector<std::uint8_t>(11)}),
      Error);
  EXPECT_THROW(write_png(folder / "a.png", PngImage{}), Error);
  // Sizes that libpng itself refuses: the jump out of it must leave nothing behind.
  PngImage wide{1100000, 1, 3, insitu::core::CountedVector<std::uint8_t>(3300000)};
  EXPECT_THROW(write_png(folder / "a.png", wide), Error);
  EXPECT_EQ(folder.count(), 0u);
}

} // namespace
