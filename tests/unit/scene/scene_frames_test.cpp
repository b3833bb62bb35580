// Every key of frames: its value read, its default, its errors.
#include <gtest/gtest.h>

#include "scene_test.h"

using namespace insitu;
using namespace insitu::scene;
using test::error_of;
using test::parse;

namespace {

Frame frame(const std::string& keys) {
  return parse(test::frame(keys)).frames[0];
}
Volume volume(const std::string& keys) {
  return *parse("frames: [{name: f, volume: {field: rho, " + keys + "}}]")
              .frames[0]
              .layers[0]
              .volume;
}
Isosurface isosurface(const std::string& keys) {
  return parse("frames: [{name: f, isosurfaces: [{field: p, values: [1], " + keys + "}]}]")
      .frames[0]
      .layers[0]
      .isosurfaces[0];
}
std::string frame_error(const std::string& keys) {
  return error_of(test::frame(keys));
}
std::string volume_error(const std::string& keys) {
  return error_of("frames: [{name: f, volume: {field: rho, " + keys + "}}]");
}
std::string isosurface_error(const std::string& keys) {
  return error_of("frames: [{name: f, isosurfaces: [{field: p, " + keys + "}]}]");
}

} // namespace

TEST(SceneFrames, Defaults) {
  const Frame f = parse("frames: [{name: f, volume: {field: rho}}]").frames[0];
  EXPECT_EQ(f.name, "f");
  EXPECT_EQ(f.line, 2);
  EXPECT_TRUE(f.layers[0].mesh.empty());
  EXPECT_EQ(f.size, (std::array<int, 2>{1024, 1024}));
  EXPECT_EQ(f.background, render::linear_of_srgb(1, 1, 1));
  EXPECT_FALSE(f.scalar_bar || f.time_label);
  EXPECT_TRUE(f.effects.empty() && f.layers[0].isosurfaces.empty());
  EXPECT_EQ(f.accuracy, INSITU_STANDARD);
  EXPECT_EQ(f.step, 1);
  EXPECT_EQ(f.samples_per_pixel, 1);
  EXPECT_EQ(f.camera.azimuth, 30);
  EXPECT_EQ(f.camera.elevation, 20);
  EXPECT_EQ(f.camera.zoom, 1);
  EXPECT_EQ(f.camera.fov, 30);
  EXPECT_EQ(f.camera.up, (math::Vec3d{0, 0, 1}));
  EXPECT_FALSE(f.camera.position || f.camera.look_at);
  EXPECT_EQ(f.camera.orbit_azimuth_per_frame, 0);
  EXPECT_EQ(f.layers[0].volume->field.text, "rho");
  EXPECT_TRUE(f.layers[0].volume->component.magnitude());
  EXPECT_EQ(f.layers[0].volume->colors.name, "viridis");
  EXPECT_EQ(f.layers[0].volume->colors.path, "");
  EXPECT_FALSE(f.layers[0].volume->colors.range || f.layers[0].volume->unit_distance);
  EXPECT_TRUE(f.layers[0].volume->opacity.empty());
}

TEST(SceneFrames, Keys) {
  const Frame f = frame(
      "mesh: m, size: [1, 16384], background: [0, 0.5, 1], scalar_bar: true, time_label: True, "
      "effects: [lighting], accuracy: fast, step: 0.5");
  EXPECT_EQ(f.layers[0].mesh.text, "m");
  EXPECT_EQ(f.size, (std::array<int, 2>{1, 16384}));
  EXPECT_EQ(f.background, render::linear_of_srgb(0, 0.5, 1));
  EXPECT_TRUE(f.scalar_bar && f.time_label);
  EXPECT_EQ(f.effects, std::vector<FrameEffect>{FrameEffect::lighting});
  EXPECT_EQ(f.accuracy, INSITU_FAST);
  EXPECT_EQ(f.step, 0.5);
  EXPECT_EQ(frame("background: '#ff8000'").background, render::linear_of_srgb(1, 128 / 255.0, 0));
  EXPECT_EQ(frame("background: black").background, render::linear_of_srgb(0, 0, 0));
}

TEST(SceneFrames, Volumes) {
  const Volume v =
      volume("component: 2, colors: maps/blue.json, range: [-1, 6.5], opacity: [[0, 0], [1, 0.5], "
             "[1, 1]], unit_distance: 0.25, smooth: true");
  EXPECT_EQ(v.component.index, 2);
  EXPECT_EQ(v.colors.name, "maps/blue.json");
  EXPECT_EQ(v.colors.path, "/base/maps/blue.json");
  EXPECT_EQ(v.colors.line, 2);
  EXPECT_EQ(v.colors.range->low, -1);
  EXPECT_EQ(v.colors.range->high, 6.5);
  ASSERT_EQ(v.opacity.size(), 3u);
  EXPECT_EQ(v.opacity[1].value, 1);
  EXPECT_EQ(v.opacity[1].opacity, 0.5);
  EXPECT_EQ(v.unit_distance, 0.25);
  EXPECT_TRUE(v.smooth);
  EXPECT_TRUE(volume("component: magnitude").component.magnitude());
  EXPECT_FALSE(volume("range: auto").colors.range);
  EXPECT_EQ(volume("colors: plasma").colors.path, "");
  EXPECT_FALSE(v.preintegrated.has_value() || v.shading || v.tolerance);
  const Volume more = volume("preintegrated: true, shading: true");
  EXPECT_TRUE(more.preintegrated == true && more.shading);
  EXPECT_EQ(volume("preintegrated: false").preintegrated, false);
  EXPECT_EQ(volume("tolerance: 0.01").tolerance, 0.01);
  EXPECT_EQ(v.culling, render::Culling::never);
  EXPECT_EQ(volume("culling: never").culling, render::Culling::never);
  EXPECT_EQ(volume("culling: always").culling, render::Culling::always);
}

TEST(SceneFrames, ScalesAndColoursBeyondTheRange) {
  const Volume v = volume("scale: log, range: [0.1, 2], below: blue, above: [1, 0.5, 0], nan: "
                          "'#ff0000', nan_opacity: 0.3");
  EXPECT_EQ(v.colors.scale, render::Scale::log);
  EXPECT_EQ(v.colors.below, render::linear_of_srgb(0, 0, 1));
  EXPECT_EQ(v.colors.above, render::linear_of_srgb(1, 0.5, 0));
  EXPECT_EQ(v.colors.nan, render::linear_of_srgb(1, 0, 0));
  EXPECT_EQ(v.nan_opacity, 0.3);
  const Volume plain = volume("scale: linear");
  EXPECT_EQ(plain.colors.scale, render::Scale::linear);
  EXPECT_FALSE(plain.colors.below || plain.colors.above || plain.colors.nan);
  EXPECT_EQ(plain.nan_opacity, 0);
  EXPECT_FALSE(volume("smooth: true").colors.scale);
  const auto by = std::get<ColorBy>(
      isosurface("color: {field: t, scale: log, below: red, above: white, nan: black}").color);
  EXPECT_EQ(by.colors.scale, render::Scale::log);
  EXPECT_EQ(by.colors.above, render::linear_of_srgb(1, 1, 1));
  EXPECT_NE(volume_error("scale: log, range: [0, 1]").find("'scale: log' needs a range above 0"),
            std::string::npos);
  EXPECT_NE(volume_error("scale: logarithmic").find("linear"), std::string::npos);
  EXPECT_NE(volume_error("nan_opacity: 2").find("nan_opacity"), std::string::npos);
}

TEST(SceneFrames, VolumeErrors) {
  EXPECT_NE(volume_error("tolerance: 0").find("tolerance"), std::string::npos);
  EXPECT_EQ(volume_error("culling: auto"),
            "s.yaml:2: frames[0].volume.culling: 'auto' is not one of never, always");
  EXPECT_NE(volume_error("preintegrated: true, tolerance: 0.1").find("one of them expected"),
            std::string::npos);
  EXPECT_EQ(volume_error("opactiy: [[0, 0]]"),
            "s.yaml:2: key 'opactiy' is unknown in frames[0].volume; did you mean 'opacity'? "
            "(keys: field, "
            "component, colors, range, scale, below, above, nan, opacity, nan_opacity, "
            "unit_distance, smooth, preintegrated, shading, tolerance, culling)");
  EXPECT_EQ(error_of("frames: [{name: f, volume: {}}]"),
            "s.yaml:2: key 'field' is missing in frames[0].volume");
  EXPECT_EQ(volume_error("component: first"),
            "s.yaml:2: frames[0].volume.component: magnitude or a component's number from 0 "
            "expected, 'first' found");
  EXPECT_NE(volume_error("component: -1").find("an integer from 0 to 1023"), std::string::npos);
  EXPECT_NE(volume_error("range: [2, 2]").find("the first number must be below the second"),
            std::string::npos);
  EXPECT_NE(
      volume_error("range: [1, 2, 3]").find("a list of 2 numbers expected, a list of 3 found"),
      std::string::npos);
  EXPECT_NE(volume_error("range: wide").find("auto or a list of 2 numbers expected, 'wide' found"),
            std::string::npos);
  EXPECT_EQ(volume_error("range: [0, .inf]"),
            "s.yaml:2: frames[0].volume.range[1]: a finite number expected, '.inf' found");
  EXPECT_NE(volume_error("opacity: []").find("at least one [value, opacity]"), std::string::npos);
  EXPECT_NE(
      volume_error("opacity: [[0, 2]]").find("frames[0].volume.opacity[0]: an opacity from 0 to 1"),
      std::string::npos);
  EXPECT_NE(
      volume_error("opacity: [[1, 0], [0, 1]]").find("opacity[1]: the values must not decrease"),
      std::string::npos);
  EXPECT_NE(volume_error("unit_distance: 0").find("a number above 0 expected"), std::string::npos);
  EXPECT_NE(error_of("frames: [{name: f, volume: density}]").find("a map of field, component"),
            std::string::npos);
}

TEST(SceneFrames, Isosurfaces) {
  const Isosurface plain = isosurface("component: magnitude");
  EXPECT_EQ(plain.field.text, "p");
  EXPECT_EQ(plain.values, std::vector<double>{1});
  EXPECT_EQ(plain.opacity, 1);
  EXPECT_EQ(std::get<render::Color>(plain.color), render::linear_of_srgb(0.8, 0.8, 0.8));
  EXPECT_EQ(isosurface("opacity: 0.5").opacity, 0.5);
  EXPECT_EQ(isosurface("component: 1").component.index, 1);
  EXPECT_EQ(std::get<render::Color>(isosurface("color: red").color),
            render::linear_of_srgb(1, 0, 0));
  const auto by = std::get<ColorBy>(
      isosurface("color: {field: t, component: 0, colors: plasma, range: [0, 1]}").color);
  EXPECT_EQ(by.field.text, "t");
  EXPECT_EQ(by.component.index, 0);
  EXPECT_EQ(by.colors.name, "plasma");
  EXPECT_EQ(by.colors.range->high, 1);
}

TEST(SceneFrames, IsosurfaceErrors) {
  EXPECT_EQ(error_of("frames: [{name: f, isosurfaces: [{}]}]"),
            "s.yaml:2: key 'field' is missing in frames[0].isosurfaces[0]\n"
            "s.yaml:2: key 'values' is missing in frames[0].isosurfaces[0]");
  EXPECT_NE(isosurface_error("values: []").find("a list of numbers expected, a list of 0 found"),
            std::string::npos);
  EXPECT_NE(isosurface_error("values: 0.5").find("a list of numbers expected, '0.5' found"),
            std::string::npos);
  EXPECT_NE(isosurface_error("values: [1], opacity: 1.5").find("a number from 0 to 1"),
            std::string::npos);
  EXPECT_NE(isosurface_error("values: [1], color: rde").find("'rde' is not a colour"),
            std::string::npos);
  EXPECT_NE(isosurface_error("values: [1], color: rde").find("did you mean 'red'?"),
            std::string::npos);
  EXPECT_NE(isosurface_error("values: [1], color: '#12345g'").find("'#12345g' is not a colour"),
            std::string::npos);
  EXPECT_NE(isosurface_error("values: [1], color: {colors: plasma}").find("key 'field' is missing"),
            std::string::npos);
  std::string many = "0";
  for (int i = 1; i <= 256; ++i) {
    many += ", " + std::to_string(i);
  }
  EXPECT_NE(isosurface_error("values: [" + many + "]").find("257 isovalues, more than 256"),
            std::string::npos);
}

TEST(SceneFrames, Errors) {
  EXPECT_EQ(frame_error("size: large"), "s.yaml:2: frames[0].size: a list expected, 'large' found");
  EXPECT_EQ(frame_error("size: [1]"), "s.yaml:2: frames[0].size: a list of 2 integers, width and "
                                      "height expected, a list of 1 found");
  EXPECT_EQ(frame_error("size: [0, 16385]"),
            "s.yaml:2: frames[0].size[0]: an integer from 1 to 16384 expected, '0' found\n"
            "s.yaml:2: frames[0].size[1]: an integer from 1 to 16384 expected, '16385' found");
  EXPECT_NE(frame_error("size: [1.5, 2]").find("'1.5' found"), std::string::npos);
  EXPECT_NE(frame_error("size: ['8', 2]").find("the text '8' found"), std::string::npos);
  EXPECT_NE(frame_error("background: [0, 0, 2]").find("background[2]: a number from 0 to 1"),
            std::string::npos);
  // What follows '#' is a comment to YAML.
  EXPECT_NE(error_of("frames:\n- name: f\n  volume: {field: r}\n  background: #ff0000\n")
                .find("within quotes"),
            std::string::npos);
  EXPECT_NE(frame_error("step: 0").find("frames[0].step: a number from 0.01 to 100 expected"),
            std::string::npos);
  EXPECT_EQ(frame_error("accuracy: exat"), "s.yaml:2: frames[0].accuracy: 'exat' is not one of "
                                           "fast, standard, exact; did you mean 'exact'?");
  EXPECT_EQ(error_of("frames: [{name: f}]"),
            "s.yaml:2: frames[0]: the frame draws nothing; give it a 'volume', 'isosurfaces', "
            "'boundary', 'bodies' or 'outline'");
  EXPECT_NE(error_of("frames: [{name: f, isosurfaces: []}]").find("draws nothing"),
            std::string::npos);
  EXPECT_NE(
      frame_error("iso: 1").find("key 'iso' is unknown in frames[0]; did you mean 'isosurfaces'?"),
      std::string::npos);
}

TEST(SceneFrames, Compositing) {
  EXPECT_EQ(frame("").compositing, render::Compositing::exact);
  EXPECT_EQ(frame("compositing: exact").compositing, render::Compositing::exact);
  EXPECT_EQ(frame("compositing: standard").compositing, render::Compositing::standard);
  EXPECT_NE(frame_error("compositing: fast").find("frames[0].compositing: "), std::string::npos);
}

TEST(SceneFrames, SamplesOfPixels) {
  EXPECT_EQ(frame("samples_per_pixel: 9").samples_per_pixel, 9);
  EXPECT_EQ(frame("samples_per_pixel: 4, path_tracing: {samples: 4}").samples_per_pixel, 4);
  EXPECT_EQ(frame_error("samples_per_pixel: 0"),
            "s.yaml:2: frames[0].samples_per_pixel: an integer from 1 to 256 expected, '0' found");
  EXPECT_EQ(frame_error("samples_per_pixel: 5, path_tracing: {samples: 4}"),
            "s.yaml:2: frames[0].samples_per_pixel: at most as many as the 4 'samples' of "
            "'path_tracing' expected, which are spread over them, 5 found");
  EXPECT_EQ(frame_error("samples_per_pixel: 5, geocentric: {graticule: 10}"),
            "s.yaml:2: frames[0].samples_per_pixel: a frame with a 'globe' or a 'graticule' has "
            "one sample a pixel");
}

TEST(SceneFrames, Labels) {
  EXPECT_EQ((*frame("time_label: true").time_label)(0.25, 120), "cycle 120  time 0.25");
  EXPECT_EQ((*frame("time_label: 't = {time:.3f} s'").time_label)(0.25, 120), "t = 0.250 s");
  EXPECT_FALSE(frame("time_label: FALSE").time_label);
  const Frame bar = frame("scalar_bar: {title: density, unit: 'kg/m\u00b3'}");
  EXPECT_EQ(bar.scalar_bar->title, "density");
  EXPECT_EQ(bar.scalar_bar->unit, "kg/m\u00b3");
  EXPECT_EQ(frame("scalar_bar: true").scalar_bar->title, "");
  EXPECT_TRUE(frame("scalar_bar: {}").scalar_bar);
  EXPECT_FALSE(frame("scalar_bar: false").scalar_bar);

  const std::string at = "s.yaml:2: frames[0].";
  const std::string no_label =
      at + "time_label: true or false, or a text within quotes with {time} or {cycle}, expected, ";
  EXPECT_EQ(frame_error("time_label: 1"), no_label + "'1' found");
  EXPECT_EQ(frame_error("time_label: yes"), no_label + "'yes' found");
  EXPECT_EQ(frame_error("time_label: {time: 1}"), no_label + "a map found");
  EXPECT_EQ(frame_error("time_label: '{tiem}'"),
            at + "time_label: '{tiem}' is neither {time} nor {cycle}, alone or as in {time:.3f}, "
                 "{time:.2e}, {time:.4g}, {cycle:6} or {cycle:06}; a brace itself is {{ or }}");
  EXPECT_EQ(frame_error("time_label: '{time'"),
            at + "time_label: '{' without '}'; a brace itself is {{ or }}");
  EXPECT_EQ(frame_error("time_label: '{time} \u03b8'"),
            at + "time_label: the character '\u03b8' cannot be drawn; ASCII, signs of units and "
                 "superscripts can");
  EXPECT_EQ(frame_error("scalar_bar: yes"),
            at +
                "scalar_bar: true or false, or a map of 'title' and 'unit', expected, 'yes' found");
  EXPECT_EQ(frame_error("scalar_bar: {title: ''}"),
            at + "scalar_bar.title: a text expected, the text '' found");
  EXPECT_EQ(frame_error("scalar_bar: {unit: \u03a9}"),
            at + "scalar_bar.unit: the character '\u03a9' cannot be drawn; ASCII, signs of units "
                 "and superscripts can");
  EXPECT_NE(frame_error("scalar_bar: {titel: a}").find("did you mean 'title'?"), std::string::npos);
}

TEST(SceneFrames, Effects) {
  EXPECT_EQ(frame("effects: [shadows, lighting]").effects,
            (std::vector{FrameEffect::shadows, FrameEffect::lighting}));
  EXPECT_EQ(frame("effects: [ambient_occlusion]").occlusion.samples, 16);
  const Frame occluded = frame("effects: [{ambient_occlusion: {samples: 4, distance: 0.5}}]");
  EXPECT_EQ(occluded.effects, std::vector{FrameEffect::ambient_occlusion});
  EXPECT_EQ(occluded.occlusion.samples, 4);
  EXPECT_EQ(occluded.occlusion.distance, 0.5);
  EXPECT_EQ(frame_error("effects: [{ambient_occlusion: {samples: 0}}]"),
            "s.yaml:2: frames[0].effects[0].ambient_occlusion.samples: an integer from 1 to 65536 "
            "expected, '0' found");
  EXPECT_EQ(frame_error("effects: [lightning]"),
            "s.yaml:2: frames[0].effects[0]: effect 'lightning' is unknown; did you mean "
            "'lighting'? (effects: "
            "lighting, shadows, volume_shadows, ambient_occlusion, single_scattering, "
            "multiple_scattering)");
  EXPECT_NE(frame_error("effects: [lighting, lighting]")
                .find("effects[1]: effect 'lighting' is given twice"),
            std::string::npos);
  EXPECT_NE(frame_error("effects: [{lighting: 3}]").find("effect 'lighting' has no options"),
            std::string::npos);
  EXPECT_NE(frame_error("effects: [[1]]").find("an effect's name"), std::string::npos);
  EXPECT_NE(frame_error("effects: lighting").find("a list expected"), std::string::npos);
}

TEST(SceneFrames, PathTracing) {
  EXPECT_FALSE(frame("size: [1, 1]").path_tracing);
  const PathTracing defaults = *frame("effects: [multiple_scattering]").path_tracing;
  EXPECT_EQ(defaults.samples, 64);
  EXPECT_EQ(defaults.density, 1);
  EXPECT_EQ(defaults.anisotropy, 0);
  EXPECT_EQ(defaults.max_bounces, 4096);
  EXPECT_EQ(defaults.cells_per_macrocell, 4);
  EXPECT_EQ(defaults.seed, 0u);
  EXPECT_FALSE(defaults.shows_dome || defaults.accumulate);
  EXPECT_TRUE(frame("path_tracing: {}").path_tracing);
  const Frame all = frame("effects: [lighting, single_scattering], path_tracing: {samples: 7, "
                          "density: 2.5, anisotropy: -0.5, max_bounces: 9, cells_per_macrocell: 8, "
                          "seed: 12, dome_visible: true, accumulate: true}");
  EXPECT_EQ(all.effects, (std::vector{FrameEffect::lighting, FrameEffect::single_scattering}));
  EXPECT_EQ(all.path_tracing->samples, 7);
  EXPECT_EQ(all.path_tracing->density, 2.5);
  EXPECT_EQ(all.path_tracing->anisotropy, -0.5);
  EXPECT_EQ(all.path_tracing->max_bounces, 9);
  EXPECT_EQ(all.path_tracing->cells_per_macrocell, 8);
  EXPECT_EQ(all.path_tracing->seed, 12u);
  EXPECT_TRUE(all.path_tracing->shows_dome && all.path_tracing->accumulate);
  EXPECT_NE(frame_error("path_tracing: {samples: 0}").find("path_tracing.samples"),
            std::string::npos);
  EXPECT_NE(frame_error("path_tracing: {anisotropy: 1}").find("path_tracing.anisotropy"),
            std::string::npos);
  EXPECT_NE(frame_error("effects: [single_scattering, multiple_scattering]").find("give one"),
            std::string::npos);
  for (const char* keys : {"path_tracing: {}", "effects: [multiple_scattering]"}) {
    EXPECT_NE(error_of("frames: [{name: f, isosurfaces: [{field: p, values: [1]}], " +
                       std::string(keys) + "}]")
                  .find("path tracing needs a 'volume'"),
              std::string::npos);
  }
}
