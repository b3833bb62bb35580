/// Adaptive meshes without what the transfer function makes invisible: the same images, and only
/// what changed is made anew.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>

#include "core/random.h"
#include "query/lattice/dual_places.h"
#include "query/lattice/gridlet_query.h"
#include "render/frame.h"
#include "render_mesh.h"
#include "unit/query/registered_amr.h"

namespace insitu::test {
namespace {

using render::Culling;
using render::FrameSettings;
using render::Structures;
using render::TransferFunction;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double wave(const Vec3d& p) {
  return std::sin(1.3 * p.x) + std::cos(0.9 * p.y + 0.4 * p.z);
}

TransferFunction opacities(std::vector<render::OpacityPoint> points, double of_nan = 0) {
  TransferFunction f(render::ColorMap::built_in("viridis"), -2.0, 2.0, std::move(points));
  f.set_nan_opacity(of_nan);
  return f;
}

/// Thin shells, steps, one side, and everything or nothing.
std::vector<TransferFunction> functions() {
  return {opacities({{0.4, 0}, {0.5, 0.3}, {0.6, 0}}),
          opacities({{-0.5, 0}, {-0.5, 0.2}, {0.25, 0.2}, {0.25, 0}}),
          opacities({{0.7, 0}, {2.0, 0.4}}, 0.1),
          opacities({{0.0, 1e-14}, {1.0, 1e-14}, {1.0, 0.9}}),
          opacities({{0, 0.05}}, 0.05),
          opacities({{0, 0}})};
}

struct Drawn {
  explicit Drawn(const Recipe& recipe, int threads = 0)
      : mesh(recipe, INSITU_DUAL, wave, threads), structures(mesh.committed.memory) {
    begin();
  }
  void begin() {
    const commit::CommittedMesh& m = mesh.committed.mesh;
    structures.begin(sampler(), m.tree_version(), m.fields_version(), mesh.committed.threads);
  }
  query::Sampler sampler() const { return mesh.committed.sampler(); }
  render::ScalarField field() const { return {mesh.committed.mesh.mesh().field("f"), 0}; }
  FrameSettings settings(const TransferFunction& function) const {
    FrameSettings s;
    s.width = s.height = 40;
    s.camera = render::Camera::around(sampler().tree().bounds_min(), sampler().tree().bounds_max(),
                                      33, 21);
    s.volume = render::VolumeSettings{field(), function};
    s.volume->step_factor = 0.23;
    s.depth = s.cell = true;
    return s;
  }
  render::FrameImages draw(const FrameSettings& s) {
    return render_frame(sampler(), s, structures, mesh.committed.threads, &statistics);
  }
  /// To the byte, with the same samples.
  void expect_same(FrameSettings s) {
    s.volume->culling = Culling::never;
    const render::FrameImages all = draw(s);
    const std::int64_t samples = statistics.samples, locations = statistics.paths.locations;
    EXPECT_EQ(statistics.primitives, 0);
    s.volume->culling = Culling::always;
    const render::FrameImages some = draw(s);
    EXPECT_GT(statistics.primitives, 0);
    const auto same = [](const auto& a, const auto& b) {
      return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
    };
    EXPECT_TRUE(same(all.color.rgba, some.color.rgba));
    EXPECT_TRUE(same(all.depth, some.depth));
    EXPECT_TRUE(same(all.cell, some.cell));
    if (statistics.culled < statistics.primitives) {
      EXPECT_EQ(statistics.samples, samples);
    }
    EXPECT_EQ(statistics.paths.locations, locations);
  }

  RegisteredAmr mesh;
  Structures structures;
  render::FrameStatistics statistics;
};

class CullingOf : public testing::TestWithParam<Recipe> {};

TEST_P(CullingOf, FramesAreTheSame) {
  Drawn drawn(GetParam());
  std::int64_t most = 0, total = 0;
  for (const TransferFunction& function : functions())
    for (const bool skip : {false, true}) {
      FrameSettings s = drawn.settings(function);
      s.volume->skip_empty = skip;
      drawn.expect_same(s);
      most = std::max(most, drawn.statistics.culled);
      total = drawn.statistics.primitives;
      FrameSettings other = s;
      other.volume->tolerance = 0.01;
      drawn.expect_same(other);
      other = s;
      other.volume->shading = true;
      drawn.expect_same(other);
      other = s;
      other.path_tracing = render::PathTracingSettings{};
      other.path_tracing->samples = 2;
      other.path_tracing->density = 4;
      other.lighting.lights = {{render::Light::Kind::dome, {}, {1, 1, 1}}};
      drawn.expect_same(other);
      other.path_tracing->locate = render::PathTracingSettings::Locate::last_cell;
      drawn.expect_same(other);
    }
  EXPECT_EQ(most, total); // the function that shows nothing
}

/// NaN, infinite and huge values in some cells, drawn or not.
TEST_P(CullingOf, FramesWithValuesThatAreNoNumbersAreTheSame) {
  Drawn drawn(GetParam());
  std::uint64_t i = 0;
  for (std::vector<double>& piece : drawn.mesh.values)
    for (double& v : piece) {
      const double r = core::random_unit(8, i++, 0);
      v = r < 0.03   ? nan
          : r < 0.04 ? HUGE_VAL
          : r < 0.05 ? 1e300
          : r < 0.06 ? -1e300
          : r < 0.07 ? 1e-300
                     : v;
    }
  drawn.mesh.committed.commit(INSITU_CHANGED_FIELDS);
  drawn.begin();
  for (const TransferFunction& function : functions())
    drawn.expect_same(drawn.settings(function));
}

/// Against each cell's own values: what may show is found as ever, and what is kept may show. Asked
/// for one by one, in batches, in parallel.
TEST_P(CullingOf, KeepsWhatMayShowAndNothingElse) {
  Drawn drawn(GetParam());
  const query::Sampler whole = drawn.sampler();
  const mesh::MeshView& view = whole.mesh();
  const render::ScalarField field = drawn.field();
  std::vector<Vec3d> points;
  const Vec3d low = whole.tree().bounds_min(), extent = whole.tree().bounds_max() - low;
  for (std::uint64_t i = 0; i < 4000; ++i)
    points.push_back({low.x + core::random_unit(9, i, 0) * extent.x,
                      low.y + core::random_unit(9, i, 1) * extent.y,
                      low.z + core::random_unit(9, i, 2) * extent.z});
  for (const TransferFunction& function : functions()) {
    const query::CulledCells* const cells = drawn.structures.culled(field, function);
    ASSERT_NE(cells, nullptr);
    EXPECT_EQ(cells->primitives(), whole.tree().cell_count());
    // By each cell's values alone.
    const auto may_show = [&](std::int64_t flat) {
      mesh::CellVertices cell;
      mesh::gather(view, flat, cell);
      double lower = HUGE_VAL, upper = -HUGE_VAL;
      for (int v = 0; v < cell.count; ++v) {
        lower = std::min(lower, field.load(cell.piece, cell.ids[v]));
        upper = std::max(upper, field.load(cell.piece, cell.ids[v]));
      }
      const double slack = 1e-5 * (upper - lower) + 1e-5;
      const bool sure = function.max_opacity(lower, upper) >= TransferFunction::invisible;
      const bool near =
          function.max_opacity(lower - slack, upper + slack) >= TransferFunction::invisible;
      return std::pair(sure, near);
    };
    std::vector<std::uint8_t> in_tree(std::size_t(view.cell_count()), 0);
    for (std::int64_t i = 0; i < cells->tree().cell_count(); ++i)
      in_tree[cells->tree().cells()[i]] = 1;
    const std::int64_t stitching = view.first_cell[1];
    for (std::int64_t flat = stitching; flat < view.cell_count(); ++flat) {
      const auto [sure, near] = may_show(flat);
      ASSERT_TRUE(!sure || in_tree[std::size_t(flat)]) << flat;
      ASSERT_TRUE(near || !in_tree[std::size_t(flat)]) << flat;
    }
    const mesh::GridletsView& gridlets = *view.pieces[0].gridlets;
    for (std::int64_t g = 0; g < gridlets.count; ++g) {
      bool sure = false;
      const std::int64_t first = g << mesh::Gridlet::cell_bits;
      for (std::int64_t c = first; c < first + mesh::Gridlet::most_cells; ++c)
        sure = sure || (gridlets.is_full(c) && may_show(c).first);
      ASSERT_TRUE(!sure || in_tree[std::size_t(first)]) << g;
      ASSERT_EQ((cells->locator().dual()->shown[g / 64] >> (g % 64)) & 1, in_tree[std::size_t(first)]);
    }
    const query::Sampler some = whole.among(*cells);
    std::vector<query::Location> all(points.size()), serial(points.size()), parallel(points.size());
    whole.locate(drawn.mesh.committed.threads, points, all);
    some.locate_serial(points, serial);
    some.locate(drawn.mesh.committed.threads, points, parallel);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const query::Location one = some.locate(points[i]);
      ASSERT_EQ(one.cell, serial[i].cell);
      ASSERT_EQ(one.cell, parallel[i].cell);
      if (!all[i]) {
        ASSERT_FALSE(one);
        continue;
      }
      const std::int64_t item = all[i].cell < stitching
                                    ? all[i].cell >> mesh::Gridlet::cell_bits
                                                         << mesh::Gridlet::cell_bits
                                    : all[i].cell;
      ASSERT_EQ(bool(one), bool(in_tree[std::size_t(item)])) << i;
      if (one) {
        ASSERT_EQ(one.cell, all[i].cell);
        ASSERT_EQ(std::memcmp(&one.parametric, &all[i].parametric, sizeof one.parametric), 0);
      }
    }
  }
}

std::vector<Recipe> recipes() {
  std::vector<Recipe> all;
  for (int kind = 0; kind < 7; ++kind)
    all.push_back({.seed = std::uint64_t(kind + 1), .kind = kind, .roots = 3, .levels = 3});
  all.push_back({.seed = 8, .kind = 5, .roots = 2, .levels = 7}); // levels differ by up to six
  return all;
}

INSTANTIATE_TEST_SUITE_P(Random, CullingOf, testing::ValuesIn(recipes()), [](const auto& of) {
  return "kind" + std::to_string(of.param.kind) + "_seed" + std::to_string(of.param.seed);
});

const Recipe octree{.seed = 2, .kind = 0, .roots = 3, .levels = 4};

/// Ranges follow values, trees what shows; neither is made unless it is asked for, or stays longer.
TEST(Culling, OnlyWhatChangedIsMadeAnew) {
  Drawn drawn(octree);
  Structures& structures = drawn.structures;
  drawn.mesh.committed.mesh.set_builder(accel::Builder::morton); // the tree stays what it is
  const core::Memory& memory = drawn.mesh.committed.memory;
  FrameSettings s = drawn.settings(opacities({{0.4, 0}, {0.5, 0.3}, {0.6, 0}}));
  const std::int64_t before = memory.current(); // the field is gathered
  s.volume->skip_empty = false;
  s.volume->culling = Culling::never;
  drawn.draw(s);
  EXPECT_EQ(memory.current(), before);
  EXPECT_EQ(structures.counts(), Structures::Counts());
  s.volume->culling = Culling::always;
  Structures::Counts expected;
  const auto cycle = [&] {
    structures.end();
    drawn.begin();
    s.volume->field = drawn.field();
    drawn.draw(s);
    EXPECT_EQ(structures.counts(), expected);
  };
  expected.primitive_ranges = expected.culled = 1;
  cycle();
  const std::int64_t bytes = drawn.statistics.primitives * 9;
  EXPECT_GE(memory.current(INSITU_MEMORY_RANGES), bytes);
  EXPECT_LE(memory.current(INSITU_MEMORY_RANGES), bytes + drawn.statistics.primitives);
  const query::CulledCells& cells = *structures.culled(s.volume->field, s.volume->function);
  EXPECT_EQ(memory.current() - before, bytes + cells.bytes());
  cycle(); // nothing changed
  s.volume->function = {
      render::ColorMap::built_in("inferno"), -3, 4, {{0.4, 0}, {0.5, 0.3}, {0.6, 0}}};
  cycle(); // other colours are no other opacity
  s.volume->function = opacities({{-0.5, 0}, {0.5, 0.3}, {1.2, 0}});
  ++expected.culled;
  const std::int64_t culled = drawn.statistics.culled;
  cycle(); // the function alone: values are not read
  EXPECT_LT(drawn.statistics.culled, culled);
  for (std::vector<double>& piece : drawn.mesh.values)
    for (double& v : piece)
      v = 0.5;
  drawn.mesh.committed.commit(INSITU_CHANGED_FIELDS);
  ++expected.primitive_ranges_refreshed;
  ++expected.culled;
  cycle(); // values
  EXPECT_EQ(drawn.statistics.culled, 0);
  drawn.mesh.committed.commit(INSITU_CHANGED_TOPOLOGY);
  ++expected.primitive_ranges;
  ++expected.culled;
  cycle(); // a regrid
  s.volume->culling = Culling::never;
  cycle();
  structures.end();
  EXPECT_EQ(memory.current(INSITU_MEMORY_RANGES), 0);
}

/// Macrocells beside them: the same counts apart from each other.
TEST(Culling, MacrocellsAreReclassifiedBesideIt) {
  Drawn drawn(octree);
  FrameSettings s = drawn.settings(opacities({{0.4, 0}, {0.5, 0.3}, {0.6, 0}}));
  s.width = s.height = 256; // so many rays that both pay
  s.volume->culling = Culling::always;
  drawn.draw(s);
  Structures::Counts expected;
  expected.macrocells = expected.majorants = expected.primitive_ranges = expected.culled = 1;
  EXPECT_EQ(drawn.structures.counts(), expected);
  s.volume->function = opacities({{0.4, 0}, {0.5, 0.3}, {0.7, 0}});
  drawn.draw(s);
  expected.majorants = expected.culled = 2;
  EXPECT_EQ(drawn.structures.counts(), expected);
  const Structures::Seconds& seconds = drawn.structures.seconds();
  for (const double spent :
       {seconds.macrocells, seconds.majorants, seconds.primitive_ranges, seconds.culled})
    EXPECT_GT(spent, 0.0);
}

TEST(Culling, EverythingAndNothing) {
  Drawn drawn(octree);
  FrameSettings s = drawn.settings(opacities({{0, 0}}));
  s.volume->culling = Culling::always;
  s.volume->skip_empty = false;
  const render::FrameImages none = drawn.draw(s);
  EXPECT_EQ(drawn.statistics.culled, drawn.statistics.primitives);
  EXPECT_EQ(drawn.statistics.samples, 0);
  for (int y = 0; y < s.height; ++y)
    for (int x = 0; x < s.width; ++x)
      for (int c = 0; c < 4; ++c)
        ASSERT_EQ(none.color.pixel(x, y)[c], 1.0f); // the background
  s.volume->function = opacities({{0, 0.1}});
  drawn.draw(s);
  EXPECT_EQ(drawn.statistics.culled, 0);
  EXPECT_GT(drawn.statistics.samples, 0);
  const query::CulledCells& all = *drawn.structures.culled(s.volume->field, s.volume->function);
  EXPECT_EQ(all.tree().cell_count(), drawn.sampler().tree().cell_count());
}

/// However many samples do not show; and then not where integrals need what does not show too.
TEST(Culling, IsDoneOnlyIfAskedFor) {
  Drawn drawn(octree);
  FrameSettings s = drawn.settings(opacities({{0.45, 0}, {0.5, 0.3}, {0.55, 0}}));
  s.width = s.height = 256;
  const auto culls = [&] {
    drawn.draw(s);
    return drawn.statistics.primitives > 0;
  };
  EXPECT_FALSE(culls());
  EXPECT_EQ(drawn.structures.counts().primitive_ranges, 0);
  s.volume->culling = Culling::always;
  EXPECT_TRUE(culls());
  s.volume->preintegrated = true;
  EXPECT_FALSE(culls());
}

/// Nothing to cull: cells as they are, and meshes that are not adaptive.
TEST(Culling, OtherMeshesHaveNone) {
  RegisteredAmr nearest(octree, INSITU_NEAREST, wave);
  RenderMesh plain(4);
  plain.field("f", INSITU_VERTEX, wave);
  for (fixtures::Committed* const committed : {&nearest.committed, &plain.committed}) {
    Structures structures(committed->memory);
    structures.begin(committed->sampler(), 0, 0, committed->threads);
    EXPECT_EQ(structures.culled({committed->mesh.mesh().field("f"), 0}, opacities({{0, 0}})),
              nullptr);
    EXPECT_EQ(structures.counts(), Structures::Counts());
  }
}

} // namespace
} // namespace insitu::test
