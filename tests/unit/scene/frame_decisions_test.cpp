// What a frame decides from its description and a few facts of its mesh, case by case.
#include <array>
#include <gtest/gtest.h>
#include <map>

#include "core/status.h"
#include "scene/frames/frame_decisions.h"
#include "scene_test.h"

namespace insitu::scene::test {
namespace {

/// A mesh that has 'p' at its vertices, 'c' in its cells, and the vectors 'u' and 'w' likewise.
FrameFacts plain_mesh() {
  FrameFacts facts;
  facts.scalar = [](const Name& name, const Component& component) {
    static const std::map<std::string, mesh::FieldView> fields{{"p", {"p", INSITU_VERTEX, 1}},
                                                               {"c", {"c", INSITU_CELL, 1}},
                                                               {"u", {"u", INSITU_VERTEX, 3}},
                                                               {"w", {"w", INSITU_CELL, 3}}};
    const auto found = fields.find(name.text);
    if (found == fields.end())
      throw core::Error(INSITU_ERROR_FIELD, "no field '" + name.text + "'");
    return render::ScalarField{found->second, component.index};
  };
  return facts;
}

FrameFacts dual_mesh() {
  FrameFacts facts = plain_mesh();
  facts.has_stand_in = facts.has_primitives = true;
  return facts;
}

/// The frame that decided is kept, because the decisions point into it.
struct Decided {
  explicit Decided(const std::string& keys, const FrameFacts& facts = plain_mesh())
      : frame(parse("frames: [{name: f, " + keys + "}]").frames.at(0)),
        decisions(decide_frame(frame, std::array{std::optional(facts)})) {}
  const FrameDecisions* operator->() const { return &decisions; }

  Frame frame;
  FrameDecisions decisions;
};

void expect(const Decision& decision, bool made, const std::string& why) {
  EXPECT_EQ(decision.made, made) << why;
  EXPECT_EQ(decision.why, why);
}

TEST(DecideFrame, ImagesBesideThatOfColour) {
  const std::string all = "boundary: {}, images: [color, depth, cell]";
  const std::string cell = "boundary: {}, images: [cell]";
  const std::string globe = "boundary: {}, geocentric: {graticule: 10}";
  const std::string not_asked = "not among the frame's images";
  const Decided none("boundary: {}");
  expect(none->samples, false, "one sample a pixel");
  expect(Decided("boundary: {}, samples_per_pixel: 5")->samples, true,
         "several samples a pixel, one after the other");
  expect(none->depth, false, not_asked);
  expect(none->cell, false, not_asked);
  expect(none->globe, false, "neither globe nor graticule is asked for");
  expect(Decided(all)->depth, true, "while it is drawn");
  expect(Decided(all)->cell, true, "while it is drawn");
  expect(Decided(all, dual_mesh())->depth, true, "while it is drawn");
  expect(Decided(cell)->depth, false, not_asked);
  EXPECT_FALSE(Decided(cell)->own_cells);
  const Decided told(cell, dual_mesh());
  EXPECT_TRUE(told->own_cells);
  expect(told->depth, true,
         "while it is drawn: it tells the solver's cells from those in their place");
  EXPECT_FALSE(Decided("boundary: {}", dual_mesh())->own_cells);
  expect(Decided(globe)->depth, true, "while it is drawn: what the globe hides");
  expect(Decided(globe)->globe, true, "while it is drawn, some rows at a time");
  expect(Decided("boundary: {}, geocentric: {}")->depth, false, not_asked);
}

/// Shadows, those of volumes and occlusion light what is drawn, whether lighting is asked for or
/// not; and shadows of volumes are shadows.
TEST(DecideFrame, Lighting) {
  struct Case {
    const char* effect;
    bool lit, shadows, volume_shadows, occlusion;
  };
  for (const Case& c : {Case{"", false, false, false, false},
                        {"lighting", true, false, false, false},
                        {"shadows", true, true, false, false},
                        {"volume_shadows", true, true, true, false},
                        {"ambient_occlusion", true, false, false, true}}) {
    SCOPED_TRACE(c.effect);
    const Decided d("boundary: {}, effects: [" + std::string(c.effect) + "]");
    EXPECT_EQ(d->lit, c.lit);
    EXPECT_EQ(d->surface_lighting.made, c.lit);
    EXPECT_EQ(d->shadows.made, c.shadows);
    EXPECT_EQ(d->volume_shadows.made, c.volume_shadows);
    EXPECT_EQ(d->occlusion.made, c.occlusion);
  }
  // Isosurfaces are lit where the frame has no word about effects.
  const std::string isosurface = "isosurfaces: [{field: p, values: [1]}]";
  const std::string listed = "isosurfaces, and no effects are listed";
  expect(Decided(isosurface)->surface_lighting, true, listed);
  expect(Decided(isosurface + ", boundary: {}")->surface_lighting, true, listed);
  expect(Decided(isosurface + ", volume: {field: p}, lights: [{dome: true}]")->surface_lighting,
         true, listed);
  EXPECT_TRUE(Decided(isosurface)->lit);
  for (const char* effects : {"", "single_scattering"}) {
    const Decided bare(isosurface + ", volume: {field: p}, effects: [" + effects + "]");
    EXPECT_FALSE(bare->lit) << effects;
    expect(bare->surface_lighting, false, "not among the frame's effects");
  }
  EXPECT_FALSE(Decided("volume: {field: p}, lights: [{dome: true}]")->lit);
  EXPECT_FALSE(Decided(isosurface)->shadows || Decided(isosurface)->occlusion);
  expect(Decided("volume: {field: p}, effects: [lighting]")->surface_lighting, false,
         "there is none");
  expect(Decided("boundary: {}, effects: [volume_shadows]")->shadows, true, "with volume shadows");
}

/// Of a boundary and of bodies of one colour only light shows the shape.
TEST(DecideFrame, SurfacesOfOneColourAreLitWithoutAWordAboutEffects) {
  const std::string file = "bodies: [{file: wing.stl}]";
  const std::string colored = "boundary: {color: {field: p}}";
  const std::string one = "a boundary of one colour, and no effects are listed";
  const std::string bodies = "bodies, and no effects are listed";
  for (const char* keys :
       {"boundary: {}", "boundary: {color: blue, opacity: 0.5}, volume: {field: p}",
        "boundary: {}, lights: [{dome: true}]"})
    expect(Decided(keys)->surface_lighting, true, one);
  for (const std::string& keys : {file, file + ", boundary: {}", file + ", " + colored})
    expect(Decided(keys)->surface_lighting, true, bodies);
  expect(Decided("isosurfaces: [{field: p, values: [1]}], boundary: {}, " + file)->surface_lighting,
         true, "isosurfaces, and no effects are listed");
  for (const std::string& keys :
       {colored, std::string("boundary: {}, effects: []"), file + ", effects: []",
        std::string("boundary: {}, volume: {field: p}, effects: [single_scattering]")}) {
    const Decided bare(keys);
    EXPECT_FALSE(bare->lit) << keys;
    expect(bare->surface_lighting, false, "not among the frame's effects");
  }
}

TEST(DecideFrame, WhatIsDrawnOfAVolume) {
  const auto volume = [](const std::string& keys, const std::string& frame = {}) {
    return *Decided("volume: {" + keys + "}" + frame)->layers[0].volume;
  };
  const std::string flat = "the volume shows one value a cell";
  const std::string keys = ", shading: true, preintegrated: true";
  const VolumeDecisions vertex = volume("field: p" + keys);
  EXPECT_FALSE(vertex.flat || vertex.path_traced || vertex.culling.has_value());
  expect(vertex.average, false, "a vertex field");
  EXPECT_TRUE(vertex.shading && vertex.preintegration);
  expect(vertex.step_levels, false, "not asked for");
  expect(volume("field: p, smooth: true").average, false, "a vertex field");

  const VolumeDecisions cells = volume("field: c" + keys);
  EXPECT_TRUE(cells.flat);
  for (const Decision& one : {cells.average, cells.shading, cells.preintegration})
    expect(one, false, flat);
  EXPECT_TRUE(volume("field: c, tolerance: 0.1").step_levels);

  const VolumeDecisions smooth = volume("field: c, smooth: true" + keys);
  EXPECT_FALSE(smooth.flat);
  EXPECT_TRUE(smooth.average && smooth.shading && smooth.preintegration);

  const std::string paths = ", effects: [single_scattering]";
  EXPECT_TRUE(volume("field: p", paths).path_traced);
  for (const Decision& one :
       {volume("field: p" + keys, paths).shading, volume("field: p" + keys, paths).preintegration,
        volume("field: c, tolerance: 0.1", paths).step_levels})
    expect(one, false, "the volume is path traced");
  expect(volume("field: p", paths).shading, false, "not asked for");
}

/// Rings are kept out by default, and only where a word about it or about effects stands as it is.
TEST(DecideFrame, IntegralsOfAVolumeWithoutAWordAboutThem) {
  const auto integrals = [](const std::string& keys, const std::string& frame = {}) {
    return Decided("volume: {" + keys + "}" + frame)->layers[0].volume->preintegration;
  };
  const std::string made = "against rings, by default: tables of integrals, while it is drawn";
  expect(integrals("field: p"), true, made);
  expect(integrals("field: c, smooth: true"), true, made);
  expect(integrals("field: p", ", accuracy: exact"), true, made);
  expect(integrals("field: c"), false, "the volume shows one value a cell");
  expect(integrals("field: p, preintegrated: false"), false, "the volume says no");
  for (const char* effects : {"", "lighting", "single_scattering"})
    expect(integrals("field: p", ", effects: [" + std::string(effects) + "]"), false,
           "the frame lists its effects");
  expect(integrals("field: p, tolerance: 0.1"), false, "a tolerance makes steps uneven");
  expect(integrals("field: p, culling: always"), false, "culling leaves out what does not show");
  expect(integrals("field: p", ", accuracy: fast"), false, "the frame's accuracy is fast");
}

/// Only meshes with primitives can be culled, and not where values that do not show count.
TEST(DecideFrame, Culling) {
  const auto culling = [](const std::string& keys, const FrameFacts& facts = dual_mesh()) {
    return Decided(keys, facts)->layers[0].volume->culling;
  };
  EXPECT_FALSE(culling("volume: {field: p, culling: always}", plain_mesh()).has_value());
  EXPECT_FALSE(culling("volume: {field: c, culling: always}").has_value());
  expect(*culling("volume: {field: c, smooth: true, culling: always}"), true, "culling");
  expect(*culling("volume: {field: p}"), false, "culling is not asked for");
  expect(*culling("volume: {field: p, culling: always}"), true, "culling");
  const std::string integrated = "volume: {field: p, culling: always, preintegrated: true}";
  expect(*culling(integrated), false, "pre-integration needs what does not show too");
  expect(*culling(integrated + ", effects: [single_scattering]"), true, "culling");
}

TEST(DecideFrame, Isosurfaces) {
  const auto surface = [](const std::string& keys, const std::string& effect = {}) {
    return Decided("isosurfaces: [{values: [1], " + keys + "}], effects: [" + effect + "]")
        ->layers[0]
        .isosurfaces.at(0);
  };
  const IsosurfaceDecisions plain = surface("field: p");
  EXPECT_FALSE(plain.averages || plain.coloring.has_value());
  expect(plain.gradients, false, "normals are the cells' own gradients");
  EXPECT_TRUE(surface("field: w, component: 2").averages);
  EXPECT_EQ(surface("field: w, component: 2").field.component, 2);
  expect(surface("field: p, normals: central", "lighting").gradients, false,
         "normals are central differences");
  const IsosurfaceDecisions lit = surface("field: p, normals: smooth", "shadows");
  EXPECT_EQ(lit.normals, render::Normals::smooth);
  EXPECT_TRUE(lit.gradients);
  const IsosurfaceDecisions unlit = surface("field: p, normals: smooth");
  EXPECT_EQ(unlit.normals, render::Normals::cell);
  expect(unlit.gradients, false, "nothing is lit");
}

/// A pass over the values finds the range where none is given.
TEST(DecideFrame, Colours) {
  const Decided d("volume: {field: p, range: [0, 1]}, boundary: {color: {field: u, component: 1}}, "
                  "isosurfaces: [{field: p, values: [1], color: {field: c}}], scalar_bar: true");
  expect(d->layers[0].volume->coloring.pass, false, "the range is given");
  expect(d->layers[0].isosurfaces[0].coloring->pass, true, "the range of the colours is automatic");
  EXPECT_EQ(d->layers[0].isosurfaces[0].coloring->field.field.association, INSITU_CELL);
  EXPECT_EQ(d->layers[0].boundary->field.component, 1);
  const std::vector<const ColorBy*> by = colorings_of(d.frame);
  ASSERT_EQ(by.size(), 3u);
  EXPECT_EQ(by[0], d->layers[0].volume->coloring.by);
  EXPECT_EQ(by[1], d->layers[0].isosurfaces[0].coloring->by);
  EXPECT_EQ(by[2], d->layers[0].boundary->by);
  expect(d->scalar_bar, true, "drawn over the image");
  expect(Decided("boundary: {}, scalar_bar: true")->scalar_bar, false,
         "nothing is coloured by a field");
  expect(Decided("volume: {field: p}")->scalar_bar, false, "not asked for");
  EXPECT_FALSE(Decided("boundary: {}")->layers[0].boundary.has_value());
}

TEST(DecideFrame, WhatSumsOverCells) {
  const auto sums = [](const std::string& keys) {
    return Decided(keys)->layers[0].vertex_cells.made;
  };
  EXPECT_FALSE(sums("volume: {field: c}, boundary: {color: {field: c}}"));
  EXPECT_TRUE(sums("volume: {field: c, smooth: true}"));
  EXPECT_TRUE(sums("isosurfaces: [{field: c, values: [1]}]"));
  EXPECT_FALSE(sums("isosurfaces: [{field: p, values: [1], normals: smooth}], effects: []"));
  EXPECT_TRUE(sums("isosurfaces: [{field: p, values: [1], normals: smooth}]"));
  EXPECT_TRUE(sums("isosurfaces: [{field: p, values: [1], normals: smooth}], effects: [lighting]"));
}

TEST(DecideFrame, FieldsThatAreMissing) {
  for (const char* keys : {"volume: {field: nix}", "isosurfaces: [{field: nix, values: [1]}]",
                           "isosurfaces: [{field: p, values: [1], color: {field: nix}}]",
                           "boundary: {color: {field: nix}}"})
    EXPECT_THROW(Decided d(keys), core::Error) << keys;
}

} // namespace
} // namespace insitu::scene::test
