// What a frame does not ask for is not done: each effect has a count that is zero without it.
#include <gtest/gtest.h>
#include <ostream>

#include "render/structures/structures.h"
#include "unit/render/path_mesh.h"

namespace insitu::test {
namespace {

using render::FrameSettings;
using render::Light;

/// Fields of the mesh: of vertices and of cells, each linear from 0 to 1.
struct Fields {
  render::ScalarField of_vertices, of_cells;
  render::Structures* structures = nullptr;
};

struct Work {
  render::FrameStatistics did;
  render::Structures::Counts made;
  std::size_t depth = 0, cell = 0; ///< pixels of these images
  std::int64_t accumulated = 0;
};

/// Frames that ask for one thing alone.
enum class Base { volume, marched_cells, surface, lit_surface, volume_and_surface, paths };

struct Effect {
  const char* name;
  Base base;
  void (*ask)(FrameSettings&, const Fields&);
  /// Of a frame's work, against that of its bare frame where both do some of it.
  std::int64_t (*count)(const Work&, const Work& bare);
};

std::ostream& operator<<(std::ostream& out, const Effect& e) {
  return out << e.name;
}

const Light sun{Light::Kind::directional, {1, 2, 1}, {1, 1, 1}};

render::BodySettings a_body() {
  auto list = std::make_shared<render::TriangleList>();
  list->source = "a triangle";
  list->corners = {{0, 0, 0.5}, {1, 0, 0.5}, {0, 1, 0.5}};
  return {list};
}

const Effect effects[] = {
    {"isosurfaces", Base::volume,
     [](FrameSettings& s, const Fields& f) {
       s.isosurfaces.push_back({f.of_vertices, {0.5}});
     },
     [](const Work& w, const Work&) {
       return w.did.hits + w.did.evaluations + w.made.value_ranges;
     }},
    {"lighting of surfaces", Base::surface,
     [](FrameSettings& s, const Fields&) { s.lighting.enabled = true; },
     [](const Work& w, const Work&) { return w.did.lit_hits; }},
    {"shadows", Base::lit_surface,
     [](FrameSettings& s, const Fields&) { s.lighting.shadows = true; },
     [](const Work& w, const Work&) { return w.did.shadow_rays; }},
    {"ambient occlusion", Base::lit_surface,
     [](FrameSettings& s, const Fields&) { s.lighting.occlusion_samples = 4; },
     [](const Work& w, const Work&) { return w.did.occlusion_rays; }},
    {"volume shadows", Base::volume_and_surface,
     [](FrameSettings& s, const Fields&) { s.lighting.shadows = s.lighting.volume_shadows = true; },
     [](const Work& w, const Work&) { return w.did.shadow_samples; }},
    {"smooth normals", Base::lit_surface,
     [](FrameSettings& s, const Fields&) { s.isosurfaces[0].normals = render::Normals::smooth; },
     [](const Work& w, const Work&) { return w.made.gradients + w.made.vertex_cells; }},
    {"central normals", Base::lit_surface,
     [](FrameSettings& s, const Fields&) { s.isosurfaces[0].normals = render::Normals::central; },
     [](const Work& w, const Work& bare) { return w.did.evaluations - bare.did.evaluations; }},
    {"boundary", Base::volume, [](FrameSettings& s, const Fields&) { s.boundary.emplace(); },
     [](const Work& w, const Work&) { return w.did.hits + w.made.boundaries; }},
    {"bodies", Base::volume, [](FrameSettings& s, const Fields&) { s.bodies.push_back(a_body()); },
     [](const Work& w, const Work&) { return w.did.hits + w.made.bodies; }},
    {"outline", Base::volume, [](FrameSettings& s, const Fields&) { s.outline.emplace(); },
     [](const Work& w, const Work&) { return w.did.hits; }},
    {"volume", Base::surface,
     [](FrameSettings& s, const Fields& f) {
       s.volume = render::VolumeSettings{f.of_vertices, constant_function(0.3)};
     },
     [](const Work& w, const Work&) { return w.did.samples; }},
    {"volume shading", Base::volume,
     [](FrameSettings& s, const Fields&) { s.volume->shading = true; },
     [](const Work& w, const Work&) { return w.did.lit_samples; }},
    {"shadows on a lit volume", Base::volume_and_surface,
     [](FrameSettings& s, const Fields&) {
       s.volume->shading = true;
       s.lighting.shadows = s.lighting.volume_shadows = true;
       s.isosurfaces[0].values = {2.0}; // none is hit
     },
     [](const Work& w, const Work&) { return w.did.shadow_rays; }},
    {"pre-integration", Base::volume,
     [](FrameSettings& s, const Fields&) { s.volume->preintegrated = true; },
     [](const Work& w, const Work&) { return w.did.integrals; }},
    {"tolerance", Base::volume, [](FrameSettings& s, const Fields&) { s.volume->tolerance = 0.1; },
     [](const Work& w, const Work&) { return w.made.macrocells; }},
    {"skipping", Base::volume,
     [](FrameSettings& s, const Fields&) {
       s.volume->function = {render::ColorMap::built_in("viridis"), 0, 1, {{0.6, 0}, {0.8, 1}}};
     },
     [](const Work& w, const Work&) { return w.did.skipped + w.made.majorants; }},
    {"smooth cell fields", Base::marched_cells,
     [](FrameSettings& s, const Fields& f) {
       s.volume->field = f.structures->average(f.of_cells).field();
     },
     [](const Work& w, const Work&) { return w.made.averages + w.made.vertex_cells; }},
    {"path tracing", Base::volume,
     [](FrameSettings& s, const Fields&) {
       s.path_tracing.emplace().samples = 2;
       s.path_tracing->scattering = render::Scattering::none;
     },
     [](const Work& w, const Work&) {
       return w.did.paths.paths + w.did.paths.locations + w.did.paths.macrocells + w.made.majorants;
     }},
    {"scattering", Base::paths,
     [](FrameSettings& s, const Fields&) {
       s.path_tracing->scattering = render::Scattering::multiple;
     },
     [](const Work& w, const Work&) { return w.did.paths.scatterings; }},
    {"shadow rays of paths", Base::paths,
     [](FrameSettings& s, const Fields&) {
       s.path_tracing->scattering = render::Scattering::single;
       s.lighting.lights = {sun};
     },
     [](const Work& w, const Work&) { return w.did.paths.shadow_rays; }},
    {"accumulation", Base::paths,
     [](FrameSettings& s, const Fields& f) {
       static core::Memory memory;
       static render::PathSums sums(memory);
       (void)f;
       sums.restart();
       s.path_tracing->sums = &sums;
     },
     [](const Work& w, const Work&) { return w.accumulated; }},
    {"clips", Base::volume,
     [](FrameSettings& s, const Fields&) {
       s.clips.push_back({render::Clip::Kind::plane, {0.5, 0, 0}, {1, 0, 0}});
     },
     [](const Work& w, const Work&) { return w.did.clipped; }},
    {"depth", Base::volume, [](FrameSettings& s, const Fields&) { s.depth = true; },
     [](const Work& w, const Work&) { return std::int64_t(w.depth); }},
    {"cells", Base::volume, [](FrameSettings& s, const Fields&) { s.cell = true; },
     [](const Work& w, const Work&) { return std::int64_t(w.cell); }},
};

FrameSettings bare_frame(Base base, const Fields& f) {
  FrameSettings s = box_frame(40);
  s.lighting.enabled = base == Base::lit_surface || base == Base::volume_and_surface;
  s.lighting.lights = {sun};
  if (base == Base::volume || base == Base::volume_and_surface || base == Base::paths) {
    s.volume = render::VolumeSettings{f.of_vertices, constant_function(0.3)};
    s.volume->function.set_nan_opacity(0.3); // all shows: nothing to skip
  }
  if (base == Base::marched_cells) {
    s.volume = render::VolumeSettings{f.of_cells, constant_function(0.3)};
    s.volume->function.set_nan_opacity(0.3);
  }
  if (base == Base::surface || base == Base::lit_surface || base == Base::volume_and_surface)
    s.isosurfaces.push_back({f.of_vertices, {0.5}});
  if (base == Base::paths) {
    s.lighting.lights.clear(); // a dome
    s.path_tracing.emplace().samples = 2;
    s.path_tracing->scattering = render::Scattering::none;
  }
  return s;
}

class EveryEffect : public testing::TestWithParam<Effect> {
protected:
  RenderMesh mesh{8, Shape::hexahedron, 0.2};

  /// effect: null for the bare frame.
  Work work(Base base, const Effect* effect) {
    render::Structures structures(mesh.committed.memory);
    structures.begin(mesh.sampler(), 1, 1, mesh.committed.threads);
    const auto x = [](const Vec3d& p) { return p.x; };
    mesh.field("v", INSITU_VERTEX, x);
    mesh.field("c", INSITU_CELL, x);
    const mesh::Mesh& all = mesh.committed.mesh.mesh();
    const Fields fields{{all.field("v"), -1}, {all.field("c"), -1}, &structures};
    FrameSettings s = bare_frame(base, fields);
    if (effect)
      effect->ask(s, fields);
    Work w;
    const render::FrameImages images =
        render::render_frame(mesh.sampler(), s, structures, mesh.committed.threads, &w.did);
    w.made = structures.counts();
    w.depth = images.depth.size();
    w.cell = images.cell.size();
    if (s.path_tracing && s.path_tracing->sums)
      w.accumulated = s.path_tracing->sums->samples;
    return w;
  }
};

TEST_P(EveryEffect, IsWorkOnlyWhereAskedFor) {
  const Effect& effect = GetParam();
  const Work bare = work(effect.base, nullptr), with = work(effect.base, &effect);
  EXPECT_EQ(effect.count(bare, bare), 0);
  EXPECT_GT(effect.count(with, bare), 0);
}

INSTANTIATE_TEST_SUITE_P(OfAFrame, EveryEffect, testing::ValuesIn(effects));

} // namespace
} // namespace insitu::test
