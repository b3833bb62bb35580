// EXR files and images of numbers: written, then read back by the libraries themselves.
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <png.h>

#include "core/status.h"
#include "folder.h"
#include "output/image/depth_image.h"
#include "output/image/exr.h"
#include "output/image/png.h"

using namespace insitu;
using namespace insitu::output;

namespace {

struct ReadExr {
  int width = 0, height = 0;
  std::map<std::string, std::vector<float>> floats;
  std::map<std::string, std::vector<std::uint32_t>> ids;
  std::map<std::string, double> numbers;
};

ReadExr read_exr(const std::string& path) {
  ReadExr out;
  Imf::InputFile file(path.c_str(), 0);
  const Imf::Header& header = file.header();
  const auto window = header.dataWindow();
  out.width = window.max.x - window.min.x + 1;
  out.height = window.max.y - window.min.y + 1;
  const auto count = std::size_t(out.width) * std::size_t(out.height);
  Imf::FrameBuffer buffer;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    const bool is_float = it.channel().type == Imf::FLOAT;
    char* data = nullptr;
    if (is_float) {
      out.floats[it.name()].resize(count);
      data = reinterpret_cast<char*>(out.floats[it.name()].data());
    } else {
      out.ids[it.name()].resize(count);
      data = reinterpret_cast<char*>(out.ids[it.name()].data());
    }
    buffer.insert(it.name(), Imf::Slice(it.channel().type, data, 4, 4 * std::size_t(out.width)));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(0, out.height - 1);
  for (auto it = header.begin(); it != header.end(); ++it) {
    if (const auto* number = dynamic_cast<const Imf::DoubleAttribute*>(&it.attribute())) {
      out.numbers[it.name()] = number->value();
    } else if (const auto* whole = dynamic_cast<const Imf::IntAttribute*>(&it.attribute())) {
      out.numbers[it.name()] = whole->value();
    }
  }
  return out;
}

/// A PNG file of 16 bits as it is.
PngValues read_values(const std::string& path) {
  PngValues out;
  std::FILE* file = std::fopen(path.c_str(), "rb");
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_read_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
  out.width = int(png_get_image_width(png, info));
  out.height = int(png_get_image_height(png, info));
  out.channels = int(png_get_channels(png, info));
  EXPECT_EQ(png_get_bit_depth(png, info), 16);
  for (int y = 0; y < out.height; ++y) {
    const png_bytep row = png_get_rows(png, info)[y];
    for (int i = 0; i < out.width * out.channels; ++i) {
      out.values.push_back(std::uint16_t(row[2 * i] << 8 | row[2 * i + 1]));
    }
  }
  png_textp text = nullptr;
  const int texts = png_get_text(png, info, &text, nullptr);
  for (int i = 0; i < texts; ++i) {
    out.text.emplace_back(text[i].key, text[i].text);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  std::fclose(file);
  return out;
}

} // namespace

TEST(Exr, ColoursComeBackBitForBit) {
  test::Folder folder;
  core::Image image(37, 21); // more than one block of 16 lines
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    image.rgba[i] = i % 4 == 3 ? 1.0f : std::ldexp(float(i % 97) / 97.0f, int(i % 40) - 20);
  }
  image.rgba[0] = 1e30f;
  image.rgba[1] = -2.5f;
  image.rgba[2] = 1e-38f;
  const ExrAttribute attributes[] = {{"cycle", std::int64_t(120)}, {"time", 0.1}};
  write_exr(folder / "a.exr", image, false, attributes);
  const ReadExr read = read_exr(folder / "a.exr");
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 21);
  ASSERT_EQ(read.floats.size(), 3u); // no alpha
  const char* names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < 37 * 21; ++i) {
      ASSERT_EQ(read.floats.at(names[c])[i], image.rgba[4 * i + c]) << names[c] << " " << i;
    }
  }
  EXPECT_EQ(read.numbers.at("cycle"), 120);
  EXPECT_EQ(read.numbers.at("time"), 0.1);
  write_exr(folder / "b.exr", image, false, attributes);
  EXPECT_EQ(test::content(folder / "a.exr"), test::content(folder / "b.exr"));
  EXPECT_EQ(folder.count(), 2u); // nothing unfinished
}

TEST(Exr, ColoursAreMultipliedByAlpha) {
  test::Folder folder;
  core::Image image(2, 1);
  image.rgba = {0.5f, 1.0f, 0.25f, 0.25f, 0.0f, 0.0f, 0.0f, 0.0f};
  write_exr(folder / "a.exr", image, true);
  const ReadExr read = read_exr(folder / "a.exr");
  EXPECT_EQ(read.floats.at("R"), (std::vector<float>{0.125f, 0}));
  EXPECT_EQ(read.floats.at("G"), (std::vector<float>{0.25f, 0}));
  EXPECT_EQ(read.floats.at("B"), (std::vector<float>{0.0625f, 0}));
  EXPECT_EQ(read.floats.at("A"), (std::vector<float>{0.25f, 0}));
}

TEST(Exr, RefusesAndReports) {
  test::Folder folder;
  EXPECT_THROW(write_exr(folder / "a.exr", core::Image(), false), core::Error);
  test::put(folder / "file", "");
  try {
    write_exr(folder / "file/a.exr", core::Image(1, 1), false);
    FAIL();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
    EXPECT_NE(std::string(e.what()).find("/file'"), std::string::npos) << e.what();
  }
  const ExrAttribute large[] = {{"cycle", std::int64_t(1) << 40}};
  write_exr(folder / "a.exr", core::Image(1, 1), false, large);
  EXPECT_EQ(read_exr(folder / "a.exr").numbers.at("cycle"), std::ldexp(1.0, 40));
}

TEST(DepthImage, IsScaledToSixteenBitsInPngAndExactInExr) {
  test::Folder folder;
  const float none = HUGE_VALF;
  const std::vector<float> depth{2, 3, none, 4, 2.5f, none};
  const DepthScale scale = depth_scale(depth);
  EXPECT_EQ(scale.low, 2);
  EXPECT_EQ(scale.high, 4);
  write_depth_png(folder / "d.png", 3, 2, depth, scale);
  const PngValues png = read_values(folder / "d.png");
  EXPECT_EQ(png.width, 3);
  EXPECT_EQ(png.channels, 1);
  EXPECT_EQ(png.values, (core::CountedVector<std::uint16_t>{0, 32767, 65535, 65534, 16384, 65535}));
  EXPECT_EQ(png.text, (std::vector<std::pair<std::string, std::string>>{{"depth_low", "2"},
                                                                        {"depth_high", "4"}}));
  write_depth_exr(folder / "d.exr", 3, 2, depth);
  EXPECT_EQ(read_exr(folder / "d.exr").floats.at("Z"), depth);
  // Nothing seen, or all at one distance.
  const std::vector<float> empty{none, std::nanf("")}, flat{7, 7};
  write_depth_png(folder / "e.png", 2, 1, empty, depth_scale(empty));
  EXPECT_EQ(read_values(folder / "e.png").values,
            (core::CountedVector<std::uint16_t>{65535, 65535}));
  write_depth_png(folder / "f.png", 2, 1, flat, depth_scale(flat));
  EXPECT_EQ(read_values(folder / "f.png").values, (core::CountedVector<std::uint16_t>{0, 0}));
  EXPECT_THROW(write_depth_png(folder / "g.png", 3, 1, flat, scale), core::Error);
}

TEST(CellImage, HoldsIdsAndNone) {
  test::Folder folder;
  const std::int64_t large = (std::int64_t(1) << 48) - 2;
  const std::vector<std::int64_t> cells{-1, 0, 65534, 65535, 1'000'000, large};
  write_cell_png(folder / "c.png", 6, 1, cells);
  const PngValues png = read_values(folder / "c.png");
  ASSERT_EQ(png.channels, 3);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::int64_t code = (std::int64_t(png.values[3 * i]) << 32) +
                              (std::int64_t(png.values[3 * i + 1]) << 16) + png.values[3 * i + 2];
    EXPECT_EQ(code - 1, cells[i]);
  }
  const std::vector<std::int64_t> fit{-1, 0, 4294967294};
  write_cell_exr(folder / "c.exr", 3, 1, fit);
  EXPECT_EQ(read_exr(folder / "c.exr").ids.at("cell"),
            (std::vector<std::uint32_t>{0, 1, 4294967295}));
  EXPECT_THROW(write_cell_exr(folder / "d.exr", 6, 1, cells), core::Error);
  const std::vector<std::int64_t> huge{large + 1};
  EXPECT_THROW(write_cell_png(folder / "d.png", 1, 1, huge), core::Error);
}
