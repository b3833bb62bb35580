// Particles that are taken out between any two steps, and go on elsewhere: the same to the bit.
#include <gtest/gtest.h>
#include <string>

#include "box_mesh.h"
#include "lane_runs.h"

namespace insitu::test {
namespace {

/// No cell is this process's: particles leave as often as they can.
class NoHome final : public advect::Homes {
public:
  bool is_own(std::int64_t) const override { return false; }
  mesh::CellName name(std::int64_t cell) const override { return {-1, 1, 0, cell}; }
  std::int64_t find(const mesh::CellName& name) const override { return name.cell; }
};

/// One by one, in a new field after every step. Counts the legs.
Ends by_legs(const query::Sampler& sampler, const Flow& flow, const IntegratorSettings& settings,
             const std::vector<Vec3d>& seeds, double to, const advect::CellsBeyond* beyond,
             bool boundaries, std::int64_t& legs) {
  Ends ends;
  const NoHome nowhere;
  for (const Vec3d& seed : seeds) {
    advect::State p;
    p.x = seed;
    std::optional<advect::WayMark> mark;
    for (;;) {
      advect::MeshVelocity field(sampler, flow.now, flow.earlier, flow.t0, flow.t1,
                                 INSITU_STANDARD);
      field.walk_by(beyond);
      if (boundaries)
        field.take_boundaries();
      field.begin(-1);
      advect::Journey journey(nowhere);
      advect::State state = mark ? mark->p : p;
      advect::Work work;
      if (mark)
        journey.begin(*mark, true, state, work, nullptr);
      else
        journey.begin(state, work, nullptr);
      field.travel_by(&journey);
      const insitu_ending ending =
          advect::integrate(field, settings, to, infinity, state, work, advect::Visitor());
      if (ending != INSITU_END_COUNT) {
        ends.work += work;
        ends.states.push_back(state);
        ends.endings.push_back(ending);
        ends.cells.push_back(field.cell());
        break;
      }
      ++legs;
      mark = journey.mark(); // it has what the particle has done here
      ends.work += mark->work;
    }
  }
  return ends;
}

void expect_the_same(const query::Sampler& sampler, const Flow& flow,
                     const std::vector<Vec3d>& seeds, double to, bool boundaries,
                     const std::string& what) {
  const advect::CellsBeyond beyond(sampler);
  for (const Method method : {Method::euler, Method::rk4, Method::bs32, Method::dopri5})
    for (const bool aware : {false, true}) {
      IntegratorSettings settings;
      settings.method = method;
      settings.face_aware = aware;
      const std::string how =
          what + ", method " + std::to_string(int(method)) + (aware ? ", by faces" : "");
      Ends a;
      {
        advect::MeshVelocity field(sampler, flow.now, flow.earlier, flow.t0, flow.t1,
                                   INSITU_STANDARD);
        field.walk_by(&beyond);
        if (boundaries)
          field.take_boundaries();
        for (const Vec3d& seed : seeds) {
          field.begin(-1);
          const Outcome r = run(field, settings, seed, to);
          a.states.push_back(r.p);
          a.endings.push_back(r.ending);
          a.cells.push_back(field.cell());
          a.work += r.work;
        }
      }
      std::int64_t legs = 0;
      const Ends b = by_legs(sampler, flow, settings, seeds, to, &beyond, boundaries, legs);
      EXPECT_EQ(different(a, b), 0U) << how;
      EXPECT_EQ(a.work.steps, b.work.steps) << how;
      EXPECT_EQ(a.work.evaluations, b.work.evaluations) << how;
      EXPECT_EQ(a.work.rejected, b.work.rejected) << how;
      EXPECT_EQ(a.work.forced, b.work.forced) << how;
      EXPECT_GT(legs, std::int64_t(seeds.size()) / 2) << how;
    }
}

TEST(Journey, SameBitsOnEveryShape) {
  for (const MeshKind kind : all_kinds) {
    Swirling mesh(mesh_of(kind, 5));
    const mesh::FieldView field = mesh.field();
    expect_the_same(mesh.sampler(), {field}, seeds(), 1.0, false,
                    "shape " + std::to_string(int(kind)));
  }
}

TEST(Journey, SameBitsBetweenStepsOfAMovingMesh) {
  BoxMesh box(6, -1.0, 1.0);
  auto before = box.vertex_field(), now = box.vertex_field();
  box.fill(before, swirl);
  box.move([](const Vec3d& p) { return Vec3d{p.x * 1.05, p.y, p.z + 0.04 * std::sin(3 * p.x)}; });
  box.fill(now, [](const Vec3d& p) { return 1.3 * swirl(p); });
  for (const bool boundaries : {false, true})
    expect_the_same(box.sampler(), {now.view, &before.view, 0.0, 0.5}, seeds(), 0.5, boundaries,
                    "moving");
  auto long_before = box.vertex_field(), first = box.vertex_field();
  box.fill(long_before, [](const Vec3d& p) { return 0.9 * swirl(p); });
  box.fill(first, [](const Vec3d& p) { return 0.7 * swirl(p); });
  const std::vector<mesh::FieldView> steps{before.view, long_before.view, first.view};
  const std::vector<double> times{-0.4, -1.0};
  expect_the_same(box.sampler(), {now.view, {steps, times}, 0.0, 0.5}, seeds(), 0.5, true,
                  "four steps");
}

} // namespace
} // namespace insitu::test
