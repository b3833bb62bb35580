#include <cmath>
#include <gtest/gtest.h>

#include "core/random.h"
#include "render/surface/isosurface.h"
#include "render/volume/volume.h"
#include "unit/query/ghosted_amr.h"

/// Surfaces and volumes of adaptive meshes: gridlets and stitching cells side by side.
namespace insitu::test {
namespace {

using math::Vec3d;

Vec3d direction(double u, double v) {
  const double z = 2 * u - 1, s = std::sqrt(std::max(0.0, 1 - z * z)), a = 2 * M_PI * v;
  return {s * std::cos(a), s * std::sin(a), z};
}

/// The mesh's box.
struct Bounds {
  explicit Bounds(const query::Sampler& s)
      : low(s.tree().bounds_min()), high(s.tree().bounds_max()) {
    centre = 0.5 * (low + high);
    size = std::sqrt(dot(high - low, high - low));
  }
  Vec3d low, high, centre;
  double size;
};

class AdaptiveFrames : public testing::TestWithParam<Recipe> {};

double linear(const Vec3d& p) {
  return p.x + 0.3 * p.y - 0.2 * p.z;
}

/// The surface of a linear field is a plane, which every ray across it meets once. Rays that meet
/// it where values are kept up to the boundary are counted, and not looked at.
struct PlaneCrossings {
  int met = 0, where_kept = 0;
};
PlaneCrossings cross_plane(const fixtures::Committed& committed, const Recipe& recipe) {
  PlaneCrossings crossings;
  const query::Sampler sampler = committed.sampler();
  const Bounds box(sampler);
  const double value = linear(box.centre);
  const std::vector<render::IsosurfaceSettings> settings{
      {{committed.mesh.mesh().field("f"), 0}, {value}, 0.5}};
  core::Memory memory;
  render::Structures structures(memory);
  structures.begin(sampler, 0, 0, committed.threads);
  const render::IsosurfaceTracer tracer(sampler, settings, structures);
  const auto distance = [&](const Vec3d& p) { return linear(p) - value; };
  std::vector<render::SurfaceHit> hits;
  render::SurfaceCounts counts;
  for (int i = 0; i < 20000; ++i) {
    const auto r = [&](int c) { return core::random_unit(5, std::uint64_t(i), std::uint64_t(c)); };
    const Vec3d from = box.centre + box.size * direction(r(0), r(1));
    const Vec3d to = box.centre + (0.15 * r(4) * box.size) * direction(r(2), r(3));
    const Vec3d d = to - from;
    const render::Ray ray{from, d / std::sqrt(dot(d, d))};
    tracer.trace(ray, hits, counts);
    const double slope = linear(ray.direction);
    const double t = -distance(from) / slope;
    const Vec3d at = from + t * ray.direction;
    // Where the dual proper is, away from the cells that keep values up to the boundary.
    const query::Location there = sampler.locate(at);
    if (!there || std::fabs(slope) < 0.05)
      continue;
    mesh::CellVertices cell;
    mesh::gather(sampler.mesh(), there.cell, cell);
    bool proper = true;
    for (int v = 0; v < cell.count; ++v)
      proper &=
          std::fabs(settings[0].field.load(cell.piece, cell.ids[v]) - linear(cell.x[v])) < 1e-11;
    ++(proper ? crossings.met : crossings.where_kept);
    if (!proper)
      continue;
    int near = 0;
    for (const render::SurfaceHit& hit : hits)
      near += std::fabs(hit.t - t) < 1e-7 * box.size;
    EXPECT_EQ(near, 1) << recipe.name() << " ray " << i;
    if (near != 1)
      break;
  }
  return crossings;
}

/// No cracks between gridlets and stitching cells, and the depth is right.
TEST_P(AdaptiveFrames, APlaneHasNoCracks) {
  RegisteredAmr mesh(GetParam(), INSITU_DUAL, linear);
  const PlaneCrossings crossings = cross_plane(mesh.committed, GetParam());
  if (mesh.committed.mesh.amr_info().cubes > 100) {
    EXPECT_GT(crossings.met, 500) << GetParam().name();
  }
}

/// With ghost cells it goes on to the boundary.
TEST_P(AdaptiveFrames, APlaneWithGhostsReachesTheBoundary) {
  GhostedAmr mesh(
      GetParam(), [](std::size_t) { return std::uint8_t(63); }, linear);
  const PlaneCrossings crossings = cross_plane(mesh.committed, GetParam());
  EXPECT_EQ(crossings.where_kept, 0);
  EXPECT_GT(crossings.met, 1000) << GetParam().name();
}

/// The surface of the distance from a leaf's centre, where it is exact. A ray from there meets it
/// an odd number of times if it leaves the domain outside of it, else an even one, whichever cells
/// and jumps of level it passes: so none is missed.
TEST_P(AdaptiveFrames, AClosedSurfaceHasNoCracks) {
  if (!is_box(GetParam()))
    return;   // rays leave and come back at holes
  Vec3d from; // of the leaf nearest to the middle
  {
    const RegisteredAmr any(GetParam(), INSITU_DUAL, linear);
    const Vec3d middle = Bounds(any.committed.sampler()).centre;
    AmrMesh layout = make_mesh(GetParam());
    double least = HUGE_VAL;
    for (const Leaf& leaf : leaves_of(layout)) {
      Vec3d p;
      for (int a = 0; a < 3; ++a)
        p[a] = layout.lattice.centre(a, leaf.depth, leaf.index[std::size_t(a)]);
      if (const double d = dot(p - middle, p - middle); d < least) {
        least = d;
        from = p;
      }
    }
  }
  RegisteredAmr mesh(GetParam(), INSITU_DUAL,
                     [&](const Vec3d& p) { return std::sqrt(dot(p - from, p - from)); });
  const query::Sampler sampler = mesh.committed.sampler();
  const Bounds box(sampler);
  double radius = HUGE_VAL;
  for (int a = 0; a < 3; ++a)
    radius = std::min({radius, 0.6 * (from[a] - box.low[a]), 0.6 * (box.high[a] - from[a])});
  ASSERT_GT(radius, 0);
  const render::ScalarField field{mesh.committed.mesh.mesh().field("f"), 0};
  const auto leaves_outside = [&](const Vec3d& way) { // bounds are rounded to float
    double t = HUGE_VAL;
    for (int a = 0; a < 3; ++a)
      if (way[a] != 0)
        t = std::min(t, ((way[a] > 0 ? box.high[a] : box.low[a]) - from[a]) / way[a]);
    const query::Location at = sampler.locate(from + (1 - 1e-6) * t * way);
    return at && field.at(sampler.mesh(), at) > radius;
  };
  for (const auto search :
       {render::RootSearch::cubic, render::RootSearch::exact, render::RootSearch::neubauer}) {
    std::vector<render::IsosurfaceSettings> settings{{field, {radius}, 0.5}};
    settings[0].search = search;
    render::Structures structures(mesh.committed.memory);
    structures.begin(sampler, 0, 0, mesh.committed.threads);
    const render::IsosurfaceTracer tracer(sampler, settings, structures);
    std::vector<render::SurfaceHit> hits;
    render::SurfaceCounts counts;
    std::int64_t in_gridlets = 0, in_stitching = 0, outside = 0;
    for (int i = 0; i < 20000; ++i) {
      const auto r = [&](int c) {
        return core::random_unit(9, std::uint64_t(i), std::uint64_t(c));
      };
      Vec3d way = direction(r(0), r(1));
      if (i % 4 == 0) { // through a vertex: along edges and faces of cells
        const mesh::MeshView& view = sampler.mesh();
        way = view.pieces[1].point(
                  std::int64_t(r(2) * double(view.vertex_count() - view.first_vertex[1]))) -
              from;
      }
      const double length = std::sqrt(dot(way, way));
      if (!(length > 0))
        continue;
      way = way / length;
      const bool leaves = leaves_outside(way);
      outside += leaves;
      tracer.trace({from, way}, hits, counts);
      // Neubauer's two steps find one root of a cell, and may miss pairs.
      if (search == render::RootSearch::neubauer) {
        ASSERT_TRUE(!leaves || !hits.empty()) << "ray " << i;
      } else {
        ASSERT_EQ(hits.size() % 2, std::size_t(leaves))
            << "ray " << i << ", search " << int(search);
      }
      for (const render::SurfaceHit& hit : hits)
        ++(hit.cell < sampler.mesh().first_cell[1] ? in_gridlets : in_stitching);
    }
    EXPECT_GT(outside, 10000);
    EXPECT_GT(in_gridlets + in_stitching, 10000);
    if (mesh.committed.mesh.amr_info().stitching > 1000) {
      EXPECT_GT(in_stitching, 500) << GetParam().name();
    }
  }
}

/// A homogeneous medium absorbs by the length of ray inside, whatever the cells.
TEST_P(AdaptiveFrames, AUniformVolumeIsUniform) {
  RegisteredAmr mesh(GetParam(), INSITU_DUAL, [](const Vec3d&) { return 1.0; });
  if (!is_box(GetParam()))
    return; // rays through holes are another length
  const query::Sampler sampler = mesh.committed.sampler();
  const Bounds box(sampler);
  const render::TransferFunction function(render::ColorMap::built_in("viridis"), 0.0, 2.0,
                                          {{0.0, 0.02}, {2.0, 0.02}});
  render::VolumeSettings settings{{mesh.committed.mesh.mesh().field("f"), 0}, function};
  settings.step = box.size / 500;
  settings.unit_distance = box.size / 100;
  const render::VolumeMarcher marcher(sampler, settings);
  for (int i = 0; i < 50; ++i) {
    const auto r = [&](int c) { return core::random_unit(6, std::uint64_t(i), std::uint64_t(c)); };
    const Vec3d from = box.centre + box.size * direction(r(0), r(1));
    const Vec3d to = box.low + Vec3d{r(2) * (box.high - box.low).x, r(3) * (box.high - box.low).y,
                                     r(4) * (box.high - box.low).z};
    const Vec3d d = to - from;
    render::RayState state;
    state.ray = {from, d / std::sqrt(dot(d, d))};
    double near = 0, far = HUGE_VAL;
    for (int a = 0; a < 3; ++a) {
      const double t0 = (box.low[a] - from[a]) / state.ray.direction[a];
      const double t1 = (box.high[a] - from[a]) / state.ray.direction[a];
      near = std::max(near, std::min(t0, t1));
      far = std::min(far, std::max(t0, t1));
    }
    marcher.start(state);
    marcher.march({&state, 1});
    const double length = (far - near) / settings.unit_distance;
    const double expected = 1.0 - std::pow(1.0 - 0.02, length);
    // The tree's bounds are rounded outwards by 2^-22: 100 unit distances are 2e-5 longer, of which
    // 0.02 each.
    EXPECT_NEAR(double(state.alpha), expected, 2e-6) << GetParam().name() << " ray " << i;
  }
}

std::vector<Recipe> recipes() {
  std::vector<Recipe> all;
  for (int kind = 0; kind < 3; ++kind)
    for (std::uint64_t seed = 1; seed <= 3; ++seed)
      all.push_back({.seed = seed, .kind = kind, .roots = 3, .levels = 3});
  all.push_back({.seed = 1, .kind = 5, .roots = 3, .levels = 7}); // levels differ by up to six
  return all;
}

INSTANTIATE_TEST_SUITE_P(Random, AdaptiveFrames, testing::ValuesIn(recipes()), [](const auto& of) {
  return "kind" + std::to_string(of.param.kind) + "_seed" + std::to_string(of.param.seed);
});

} // namespace
} // namespace insitu::test
