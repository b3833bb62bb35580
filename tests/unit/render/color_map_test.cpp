#include <cmath>
#include <cstdio>
#include <fstream>
#include <gtest/gtest.h>

#include "core/status.h"
#include "render/color/color_map.h"
#include "render/color/color_space.h"

namespace insitu::render {
namespace {

std::string message_of(const std::string& text, const std::string& name = {}) {
  try {
    parse_color_map(text, "maps.json", name);
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_SCENE);
    return e.what();
  }
  return "no error";
}

void expect_srgb(const Color& c, double r, double g, double b, double tolerance = 1e-6) {
  EXPECT_NEAR(c.r, linear_of_srgb(r), tolerance);
  EXPECT_NEAR(c.g, linear_of_srgb(g), tolerance);
  EXPECT_NEAR(c.b, linear_of_srgb(b), tolerance);
}

TEST(ColorMap, ReadsParaViewsList) {
  const std::string text = R"([
    {"Name": "categories", "Annotations": ["a", "b"], "IndexedColors": [0, 0, 0]},
    {"Name": "ramp", "ColorSpace": "RGB", "Creator": "someone", "NanColor": [1, 1, 0],
     "RGBPoints": [-1.0, 0.0, 0.0, 0.5,  0.0, 0.2, 0.4, 0.6,  3.0, 1.0, 1.0, 1.0]},
    {"Name": "other", "RGBPoints": [0, 1, 0, 0, 1, 0, 1, 0]}
  ])";
  const ColorMap map = parse_color_map(text, "maps.json");
  EXPECT_EQ(map.name(), "ramp"); // the first with RGBPoints
  expect_srgb(map.at(0), 0, 0, 0.5);
  expect_srgb(map.at(0.25), 0.2, 0.4, 0.6);
  expect_srgb(map.at(0.125), 0.1, 0.2, 0.55);
  expect_srgb(map.at(1), 1, 1, 1);
  expect_srgb(map.at(-5), 0, 0, 0.5);
  expect_srgb(map.at(5), 1, 1, 1);
  expect_srgb(map.nan_color(), 1, 1, 0);
  expect_srgb(map.at(std::nan("")), 1, 1, 0);
  expect_srgb(parse_color_map(text, "maps.json", "other").at(0.5), 0.5, 0.5, 0);
}

TEST(ColorMap, LogarithmicMapsAndColoursBeyondTheRange) {
  const ColorMap map = parse_color_map(
      R"([{"Name": "l", "UseLogScale": 1, "UseBelowRangeColor": 1, "BelowRangeColor": [0, 0, 1],
          "UseAboveRangeColor": 0, "AboveRangeColor": [1, 0, 0], "NanOpacity": 1,
          "RGBPoints": [0.01, 0, 0, 0, 1, 0.5, 0.5, 0.5, 100, 1, 1, 1],
          "Points": [0.01, 0, 0.5, 0, 1, 0.5, 0.5, 0, 10, 1, 0.5, 0]}])",
      "maps.json");
  EXPECT_EQ(map.scale(), Scale::log);
  expect_srgb(map.at(0.25), 0.25, 0.25, 0.25); // a value of 0.1
  expect_srgb(map.at(0.5), 0.5, 0.5, 0.5);
  ASSERT_TRUE(map.below());
  expect_srgb(*map.below(), 0, 0, 1);
  EXPECT_FALSE(map.above());
  ASSERT_EQ(map.opacity().size(), 3u);
  EXPECT_NEAR(map.opacity()[1].u, 0.5, 1e-12);
  EXPECT_NEAR(map.opacity()[2].u, 0.75, 1e-12);
  // As ParaView: points that have no logarithm lie evenly; beyond are black and white by default.
  const ColorMap even = parse_color_map(
      R"({"UseLogScale": true, "UseBelowRangeColor": 1, "UseAboveRangeColor": 1,
          "RGBPoints": [0, 0, 0, 0, 0.5, 0.5, 0.5, 0.5, 1, 1, 1, 1]})",
      "maps.json");
  EXPECT_EQ(even.scale(), Scale::log);
  expect_srgb(even.at(0.25), 0.25, 0.25, 0.25);
  expect_srgb(*even.below(), 0, 0, 0);
  expect_srgb(*even.above(), 1, 1, 1);
  const ColorMap plain = parse_color_map(R"({"RGBPoints": [1, 0, 0, 0, 2, 1, 1, 1]})", "maps.json");
  EXPECT_EQ(plain.scale(), Scale::linear);
  EXPECT_FALSE(plain.below() || plain.above());
  EXPECT_EQ(message_of(R"([{"UseLogScale": 1, "RGBPoints": [1, 0, 0, 0, 2, 1, 1, 1],
                            "Points": [0, 0, 0.5, 0, 1, 1, 0.5, 0]}])"),
            "colour map maps.json: Points[0] is 0.000000; above 0 expected with UseLogScale");
  EXPECT_EQ(message_of(R"([{"UseBelowRangeColor": 1, "BelowRangeColor": [1],
                            "RGBPoints": [1, 0, 0, 0, 2, 1, 1, 1]}])"),
            "colour map maps.json: BelowRangeColor: a list of 3 numbers expected");
}

TEST(ColorMap, CategoriesAreStepsOfEqualWidth) {
  const ColorMap map = parse_color_map(
      R"([{"Name": "c", "Annotations": ["0", "a"], "IndexedColors": [1, 0, 0, 0, 1, 0, 0, 0, 1]}])",
      "maps.json");
  expect_srgb(map.at(0), 1, 0, 0);
  expect_srgb(map.at(0.333), 1, 0, 0);
  expect_srgb(map.at(0.334), 0, 1, 0);
  expect_srgb(map.at(0.666), 0, 1, 0);
  expect_srgb(map.at(0.667), 0, 0, 1);
  expect_srgb(map.at(1), 0, 0, 1);
  EXPECT_EQ(message_of(R"([{"IndexedColors": [0, 1]}])"),
            "colour map maps.json: IndexedColors: a list [r, g, b, ...] expected, 2 numbers given");
}

TEST(ColorMap, OpacitiesComeWithParaViewsFile) {
  const auto opacities = [](const std::string& points) {
    return parse_color_map(R"({"RGBPoints": [-1, 0, 0, 0, 3, 1, 1, 1], "Points": [)" + points +
                               "]}",
                           "maps.json")
        .opacity();
  };
  EXPECT_TRUE(parse_color_map(R"({"RGBPoints": [0, 0, 0, 0]})", "maps.json").opacity().empty());
  // Placed by the range of the colours.
  EXPECT_EQ(opacities("-1, 0, 0.5, 0, 1, 0.25, 0.5, 0, 3, 1, 0.5, 0"),
            (std::vector<MapOpacity>{{0, 0}, {0.5, 0.25}, {1, 1}}));
  // Sharpness 1: a step at the midpoint.
  EXPECT_EQ(opacities("-1, 0.5, 0.25, 1, 3, 1, 0.5, 0"),
            (std::vector<MapOpacity>{{0, 0.5}, {0.25, 0.5}, {0.25, 1}, {1, 1}}));
  // A midpoint aside: half of the rise lies there. Linear on both sides.
  const auto bent = opacities("-1, 0, 0.25, 0, 3, 0.8, 0.5, 0");
  for (const MapOpacity& p : bent)
    EXPECT_NEAR(p.opacity, p.u < 0.25 ? 1.6 * p.u : 0.4 + (p.u - 0.25) * 0.4 / 0.75, 1e-12) << p.u;
  EXPECT_GT(bent.size(), 10u);
  // In between, vtkPiecewiseFunction's curve: it rises, and is odd about the middle.
  const auto curve = opacities("-1, 0, 0.5, 0.5, 3, 1, 0.5, 0");
  for (std::size_t i = 0; i < curve.size(); ++i) {
    EXPECT_NEAR(curve[i].opacity + curve[curve.size() - 1 - i].opacity, 1, 1e-12);
    if (i > 0) {
      EXPECT_GE(curve[i].opacity, curve[i - 1].opacity);
    }
  }
  EXPECT_LT(curve[curve.size() / 4].opacity, 0.05); // flat at first
  EXPECT_EQ(message_of(R"({"RGBPoints": [0, 0, 0, 0], "Points": [0, 2, 0.5, 0]})"),
            "colour map maps.json: Points[1] is 2; 0 to 1 expected");
  EXPECT_EQ(message_of(R"({"RGBPoints": [0, 0, 0, 0], "Points": [1, 0, 0.5, 0, 0, 0, 0.5, 0]})"),
            "colour map maps.json: Points[4] is 0, below the point before it");
  EXPECT_EQ(message_of(R"({"RGBPoints": [0, 0, 0, 0], "Points": 3})"),
            "colour map maps.json: Points: a list [x, opacity, midpoint, sharpness, ...] expected");
}

TEST(ColorMap, ErrorsNameWhatIsWrong) {
  EXPECT_EQ(message_of(R"([{"Name": "m", "ColorSpace": "RGB", "RGBPoints": [0, 0, 0, 0, 1]}])"),
            "colour map maps.json, map 'm': RGBPoints: 4 numbers a point expected (x, r, g, b), 5 "
            "given");
  EXPECT_EQ(message_of(R"([{"Name": "m", "RGBPoints": [0, 0, 2, 0]}])"),
            "colour map maps.json, map 'm': RGBPoints[2] is 2; 0 to 1 expected");
  EXPECT_EQ(message_of(R"([{"Name": "m", "RGBPoints": [1, 0, 0, 0, 0, 1, 1, 1]}])"),
            "colour map maps.json, map 'm': RGBPoints[4] is 0, below the point before it");
  EXPECT_EQ(message_of(R"([{"Name": "m", "RGBPoints": [0, "red", 0, 0]}])"),
            "colour map maps.json, map 'm': RGBPoints[1] is not a number ('red')");
  EXPECT_EQ(
      message_of(R"([{"Name": "m", "ColorSpace": "Divergng", "RGBPoints": [0, 0, 0, 0]}])"),
      "colour map maps.json, map 'm': ColorSpace 'Divergng' is not known (RGB, Lab, Diverging, "
      "HSV, Linear); did you mean 'Diverging'?");
  EXPECT_EQ(message_of(R"([{"Name": "warm", "RGBPoints": [0, 0, 0, 0]}])", "wram"),
            "colour map maps.json: no map is called 'wram'; did you mean 'warm'?");
  EXPECT_EQ(message_of("[]"), "colour map maps.json: the list is empty");
  EXPECT_EQ(message_of("3"),
            "colour map maps.json: a list of maps expected, as ParaView exports it");
  EXPECT_EQ(message_of(R"({"Name": "m"})"),
            "colour map maps.json, map 'm': RGBPoints: a list [x, r, g, b, ...] expected");
  EXPECT_NE(message_of("[{\"Name\": \n\n }").find("line 3"), std::string::npos);
  try {
    ColorMap::built_in("virdis");
    FAIL();
  } catch (const core::Error& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean 'viridis'?"), std::string::npos) << e.what();
  }
  try {
    load_color_map("/nowhere/map.json");
    FAIL();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
    EXPECT_NE(std::string(e.what()).find("/nowhere/map.json"), std::string::npos);
  }
}

TEST(ColorMap, LabRoundTripAndWhite) {
  const math::Vec3d white = lab_of_srgb({1, 1, 1});
  EXPECT_NEAR(white.x, 100, 1e-3);
  EXPECT_NEAR(white.y, 0, 1e-2);
  EXPECT_NEAR(white.z, 0, 1e-2);
  // sRGB red in CIELAB under D65, as colour scientists list it.
  const math::Vec3d red = lab_of_srgb({1, 0, 0});
  EXPECT_NEAR(red.x, 53.24, 0.01);
  EXPECT_NEAR(red.y, 80.09, 0.01);
  EXPECT_NEAR(red.z, 67.20, 0.01);
  for (const double r : {0.0, 0.3, 1.0})
    for (const double g : {0.02, 0.7})
      for (const double b : {0.1, 0.9}) {
        const math::Vec3d back = linear_of_lab(lab_of_srgb({r, g, b}));
        EXPECT_NEAR(back.x, linear_of_srgb(r), 1e-6);
        EXPECT_NEAR(back.y, linear_of_srgb(g), 1e-6);
        EXPECT_NEAR(back.z, linear_of_srgb(b), 1e-6);
      }
}

TEST(ColorMap, SpacesTakeTheirPaths) {
  // Every space keeps the ends.
  for (const ColorSpace space : {ColorSpace::rgb, ColorSpace::hsv, ColorSpace::lab,
                                 ColorSpace::diverging, ColorSpace::linear}) {
    const ColorMap map("m", space, {{0, 0.2, 0.3, 0.8}, {1, 0.7, 0.1, 0.2}});
    expect_srgb(map.at(0), 0.2, 0.3, 0.8, 2e-5);
    expect_srgb(map.at(1), 0.7, 0.1, 0.2, 2e-5);
    expect_srgb(map.at(1e-9), 0.2, 0.3, 0.8, 2e-5);
    expect_srgb(map.at(1 - 1e-9), 0.7, 0.1, 0.2, 2e-5);
  }
  // Hue from blue to red goes the short way, over magenta.
  expect_srgb(ColorMap("m", ColorSpace::hsv, {{0, 0, 0, 1}, {1, 1, 0, 0}}).at(0.5), 1, 0, 1, 1e-5);
  // Grey ramps have their middle where the space says.
  const auto grey = [](ColorSpace space) {
    return ColorMap("m", space, {{0, 0, 0, 0}, {1, 1, 1, 1}}).at(0.5).g;
  };
  EXPECT_NEAR(grey(ColorSpace::linear), 0.5, 1e-6);
  EXPECT_NEAR(grey(ColorSpace::rgb), 0.2140, 1e-4);
  EXPECT_NEAR(grey(ColorSpace::lab), 0.1842, 1e-4); // Y at L* = 50
  // Moreland's diverging path has an unsaturated middle of at least M = 88.
  const Color middle = ColorMap::built_in("cool_warm").at(0.5);
  EXPECT_NEAR(middle.r, middle.g, 0.02);
  EXPECT_NEAR(middle.g, middle.b, 0.02);
  EXPECT_GT(middle.g, 0.65);
}

TEST(ColorMap, PerceptualBuiltInsRiseInLightness) {
  for (const char* name : {"viridis", "inferno", "grey"}) {
    double last = -1;
    for (int i = 0; i <= 64; ++i) {
      const Color c = ColorMap::built_in(name).at(i / 64.0);
      const double luminance = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
      EXPECT_GT(luminance, last) << name << " at " << i;
      last = luminance;
    }
  }
  for (const std::string& name : ColorMap::built_in_names())
    EXPECT_EQ(ColorMap::built_in(name).name(), name);
}

} // namespace
} // namespace insitu::render
