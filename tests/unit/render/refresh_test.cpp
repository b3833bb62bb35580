// What frames keep from cycle to cycle is given new values in place, and draws to the bit what is
// made anew.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "../query/registered_amr.h"
#include "render_mesh.h"

namespace insitu::test {
namespace {

using render::FrameImages;
using render::FrameSettings;
using render::ScalarField;
using render::Structures;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A twentieth of the values shows.
render::TransferFunction band() {
  return {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0.4, 0.0}, {0.45, 0.4}, {0.5, 0.0}}};
}

void expect_same(const FrameImages& a, const FrameImages& b) {
  EXPECT_EQ(a.color.rgba, b.color.rgba);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.cell, b.cell);
}

/// Draws with structures that live on and with new ones, over cycles of other values.
class Refreshed {
public:
  explicit Refreshed(fixtures::Committed& mesh) : mesh_(mesh), kept_(mesh.memory) {}

  /// frame(structures) gives the settings, and may ask the structures for averages.
  template <class Frame>
  FrameImages cycle(Frame&& frame) {
    ++cycles_;
    trees_ +=
        cycles_ == 1 || tree_ != mesh_.mesh.tree_version(); // queries may pay for a better one
    tree_ = mesh_.mesh.tree_version();
    Structures anew(mesh_.memory);
    const FrameImages images = draw(kept_, frame);
    expect_same(images, draw(anew, frame));
    return images;
  }
  const Structures::Counts& counts() const { return kept_.counts(); }
  /// Expects a kind to be made for the first cycle and for each new tree, and refreshed otherwise.
  void expect_kept(std::int64_t made, std::int64_t refreshed, std::int64_t each = 1) const {
    EXPECT_EQ(made, each * trees_);
    EXPECT_EQ(refreshed, each * (cycles_ - trees_));
    EXPECT_LT(trees_, cycles_);
  }

private:
  template <class Frame>
  FrameImages draw(Structures& structures, Frame&& frame) {
    const commit::CommittedMesh& mesh = mesh_.mesh;
    structures.begin(mesh.sampler(), mesh.tree_version(), mesh.fields_version(), mesh_.threads);
    FrameSettings settings = frame(structures);
    settings.depth = settings.cell = true;
    FrameImages images = render::render_frame(mesh.sampler(), settings, structures, mesh_.threads);
    structures.end();
    return images;
  }

  fixtures::Committed& mesh_;
  Structures kept_;
  std::uint64_t tree_ = 0;
  std::int64_t cycles_ = 0, trees_ = 0;
};

class RefreshedStructures : public testing::TestWithParam<Shape> {};

TEST_P(RefreshedStructures, DrawWhatNewOnesDraw) {
  RenderMesh mesh(8, GetParam(), 0.2);
  const auto blob = [](double x, double width) {
    return [=](const Vec3d& p) {
      const Vec3d d = p - Vec3d{x, 0.5, 0.5};
      return std::exp(-dot(d, d) / width);
    };
  };
  const auto with_hole = [&](const Vec3d& p) { return p.x > 0.6 ? nan : blob(0.5, 0.1)(p); };
  const auto steep = [&](const Vec3d& p) { return 1e300 * (p.x - 0.5) + p.y; };
  const std::function<double(const Vec3d&)> of_cycle[] = {blob(0.4, 0.1),
                                                          blob(0.6, 0.2),
                                                          with_hole,
                                                          blob(0.4, 0.1),
                                                          steep,
                                                          [](const Vec3d&) { return 0.45; },
                                                          [](const Vec3d&) { return nan; },
                                                          blob(0.3, 0.3)};
  Refreshed run(mesh.committed);
  std::vector<FrameImages> all;
  for (const auto& values : of_cycle) {
    SCOPED_TRACE("cycle " + std::to_string(all.size()));
    const ScalarField p = mesh.field("p", INSITU_VERTEX, values),
                      c = mesh.field("c", INSITU_CELL, values);
    all.push_back(run.cycle([&](Structures& structures) {
      FrameSettings s = box_frame(24);
      s.volume = render::VolumeSettings{structures.average(c).field(), band()};
      s.volume->shading = true;
      s.isosurfaces.push_back(
          {p, {0.3, 0.7}, 0.5, render::ColorByField{c, band()}, render::Normals::smooth});
      s.isosurfaces.push_back({c, {0.8}});
      s.lighting.lights = {{render::Light::Kind::directional, {1, 2, 3}}};
      return s;
    }));
  }
  EXPECT_EQ(all[0].color.rgba, all[3].color.rgba) << "the same values again";
  EXPECT_NE(all[0].color.rgba, all[1].color.rgba);
  EXPECT_NE(all[0].color.rgba, all[2].color.rgba);
  const Structures::Counts& n = run.counts();
  run.expect_kept(n.averages, n.averages_refreshed);
  run.expect_kept(n.value_ranges, n.value_ranges_refreshed, 2); // of p and of c's average
  run.expect_kept(n.gradients, n.gradients_refreshed);
  EXPECT_GT(n.macrocells_refreshed, 0); // not wanted where all values show alike
}

INSTANTIATE_TEST_SUITE_P(Shapes, RefreshedStructures,
                         testing::Values(Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                         Shape::pyramid));

TEST(RefreshedStructures, NewValuesInTheSolversArraysAndOtherComponents) {
  RenderMesh mesh(6, Shape::hexahedron, 0.2);
  const std::size_t n = mesh.cells.vertices.size();
  std::vector<double> v(3 * n), w(3 * n);
  mesh::Mesh& solver = mesh.committed.mesh.mesh();
  const auto hand_over = [&](const std::vector<double>& values) {
    const insitu_array a = insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(n), 3);
    solver.set_field(0, "v", INSITU_VERTEX, &a, 1);
  };
  const auto fill = [&](std::vector<double>& values, double at) {
    for (std::size_t i = 0; i < n; ++i)
      for (int a = 0; a < 3; ++a)
        values[3 * i + std::size_t(a)] = std::sin(at + (a + 1) * mesh.cells.vertices[i][a]);
  };
  Refreshed run(mesh.committed);
  const auto draw = [&](int component) {
    return run.cycle([&](Structures&) {
      FrameSettings s = box_frame(16);
      s.isosurfaces.push_back({{solver.field("v"), component},
                               {0.6},
                               1,
                               render::Color{1, 1, 1},
                               render::Normals::smooth});
      return s;
    });
  };
  fill(v, 0);
  hand_over(v);
  mesh.committed.commit(INSITU_CHANGED_FIELDS);
  const FrameImages first = draw(-1);
  fill(v, 0.5); // in place
  mesh.committed.commit(INSITU_CHANGED_FIELDS);
  EXPECT_NE(draw(-1).color.rgba, first.color.rgba);
  fill(w, 0); // elsewhere
  hand_over(w);
  mesh.committed.commit(INSITU_CHANGED_FIELDS);
  EXPECT_EQ(draw(-1).color.rgba, first.color.rgba);
  EXPECT_EQ(run.counts().value_ranges, 1);
  draw(1);
  EXPECT_EQ(run.counts().value_ranges, 2) << "of a component";
  draw(-1);
  EXPECT_EQ(run.counts().value_ranges, 3) << "given back when a cycle drew without";
  // Vertices that move: nothing serves any more.
  const std::int64_t gradients = run.counts().gradients;
  mesh.committed.commit(INSITU_CHANGED_GEOMETRY);
  draw(-1);
  EXPECT_EQ(run.counts().gradients, gradients + 1);
}

TEST(RefreshedStructures, OfAdaptiveMeshes) {
  const auto values = [](double at) {
    return [=](const Vec3d& p) { return 0.5 + 0.5 * std::sin(at + p.x) * std::cos(p.y); };
  };
  RegisteredAmr amr({.seed = 3, .kind = 0, .roots = 3, .levels = 3}, INSITU_DUAL, values(0));
  const mesh::AmrView& view = amr.amr.view();
  Refreshed run(amr.committed);
  std::vector<FrameImages> all;
  for (const double at : {0.0, 0.7, 0.0}) {
    for (std::size_t p = 0; p < amr.values.size(); ++p)
      for (std::size_t c = 0; c < amr.values[p].size(); ++c)
        amr.values[p][c] =
            values(at)(RegisteredAmr::centre_of(view, view.cell(view.pieces[p], std::int64_t(c))));
    amr.committed.commit(INSITU_CHANGED_FIELDS);
    const ScalarField f{amr.committed.mesh.mesh().field("f"), -1};
    all.push_back(run.cycle([&](Structures&) {
      FrameSettings s;
      s.width = s.height = 24;
      const accel::Tree& tree = amr.committed.sampler().tree();
      const Vec3d low = tree.bounds_min(), high = tree.bounds_max();
      s.camera.look_at = 0.5 * (low + high);
      s.camera.position = high + 1.1 * (high - low);
      s.camera.up = {0, 0, 1};
      s.volume = render::VolumeSettings{f, band()};
      s.volume->culling = render::Culling::always;
      s.isosurfaces.push_back({f, {0.7}, 0.5, render::Color{1, 1, 1}, render::Normals::smooth});
      return s;
    }));
  }
  EXPECT_EQ(all[0].color.rgba, all[2].color.rgba);
  EXPECT_NE(all[0].color.rgba, all[1].color.rgba);
  const Structures::Counts& n = run.counts();
  run.expect_kept(n.value_ranges, n.value_ranges_refreshed);
  run.expect_kept(n.gradients, n.gradients_refreshed);
  run.expect_kept(n.primitive_ranges, n.primitive_ranges_refreshed);
}

} // namespace
} // namespace insitu::test
