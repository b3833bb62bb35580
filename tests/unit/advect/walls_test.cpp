// Boundaries that stop, let slide, reflect or let particles in at the opposite side.
#include <cmath>

#include "effects_test.h"
#include "fixtures/committed.h"
#include "fixtures/earth_meshes.h"

namespace insitu::test {
namespace {

class WallTest : public EffectsTest {
protected:
  void respond(AtBoundary response) {
    effects.boundary.emplace();
    effects.boundary->response = response;
  }
};

TEST_F(WallTest, StoppedParticlesEndOnTheFace) {
  const BoxMesh mesh(5, 0.0, 1.0);
  respond(AtBoundary::stop);
  const std::vector<Vec3d> seeds{{0.5, 0.3, 0.4}, {0.1, 0.1, 0.1}};
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{0.3, 0.1, 0};
      },
      seeds, 2.0);
  EXPECT_EQ(t.particles().endings[0], INSITU_END_STOPPED);
  EXPECT_LT(distance(t.positions()[0], {1.0, 0.3 + 0.5 / 3, 0.4}), 1e-8);
  EXPECT_NEAR(t.particles().times[0], 0.5 / 0.3, 1e-7);
  EXPECT_EQ(t.particles().endings[1], INSITU_END_ALIVE);
}

TEST_F(WallTest, SlidingFollowsTheVelocityAlongTheWall) {
  // On the wall z = 0, x' = x, y' = -y: Heun in steps of a tenth of a cell, error about
  // (0.1 * 0.2)^2.
  const BoxMesh mesh(5, 0.0, 1.0);
  respond(AtBoundary::slide);
  const std::vector<Vec3d> seeds{{0.2, 0.8, 0.05}};
  const Tracer t = run(
      mesh,
      [](const Vec3d& x) {
        return Vec3d{x.x, -x.y, -0.5};
      },
      seeds, 1.0, 2);
  EXPECT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_EQ(t.particles().times[0], 1.0);
  EXPECT_LT(distance(t.positions()[0], {0.2 * M_E, 0.8 / M_E, 0.0}), 3e-4);
  EXPECT_LT(std::abs(t.positions()[0].z), 1e-8);
}

TEST_F(WallTest, SlidingParticlesComeFreeWhereTheFlowTurns) {
  // w = x - 0.5: pressed to the floor until x passes 0.5, then lifted by (x - 0.5)^2 / 2 / u.
  const BoxMesh mesh(5, 0.0, 1.0, 0.0);
  respond(AtBoundary::slide);
  const std::vector<Vec3d> seeds{{0.2, 0.5, 0.01}};
  const Tracer t = run(
      mesh,
      [](const Vec3d& x) {
        return Vec3d{0.1, 0, x.x - 0.5};
      },
      seeds, 6.0, 3);
  EXPECT_NEAR(t.positions()[0].x, 0.8, 1e-6);
  // It comes free at most a contact step (a tenth of a cell) late.
  EXPECT_NEAR(t.positions()[0].z, 0.3 * 0.3 / 0.2, 0.02 * 0.02 / 0.2 + 1e-6);
}

/// Cubes of 0.2, without those below z = 0.2 and west of x = 0.6; its velocity is a constant.
struct Stairs : fixtures::Committed {
  explicit Stairs(const Vec3d& flow) : Committed(cells()) {
    for (std::size_t i = 0; i < arrays.points.size(); i += 3)
      values.insert(values.end(), {flow.x, flow.y, flow.z});
    const insitu_array array =
        insitu_array_of(values.data(), INSITU_FLOAT64, arrays.vertex_count(), 3);
    mesh.mesh().set_field(0, "v", INSITU_VERTEX, &array, 1);
    commit();
    mesh.look_for_folds(threads);
  }
  static TestMesh cells() {
    TestMesh m = fixtures::lattice({.west = 0,
                                    .south = 0,
                                    .east = 1,
                                    .north = 1,
                                    .across = 5,
                                    .along = 5,
                                    .levels = {0, 0.2, 0.4, 0.6, 0.8, 1}});
    std::erase_if(m.cells, [&](const auto& c) {
      const Vec3d& low = m.vertices[std::size_t(c.vertices[0])];
      return low.z < 0.1 && low.x < 0.5;
    });
    return m;
  }
  std::vector<double> values;
};

// A step of a tenth of a cell needs the velocity at two places, and what presses a particle to the
// wall makes it no shorter. Where the wall ends the particle falls.
TEST_F(WallTest, AStepAlongAFlatWallTakesTwoVelocities) {
  const Stairs stairs({0.3, 0.1, -1.0});
  respond(AtBoundary::slide);
  const mesh::FieldView v = stairs.mesh.mesh().field("v");
  const auto run = [&](double end, advect::Advance& a) {
    Tracer tracer(settings, memory);
    tracer.set_effects(effects);
    tracer.seed(std::vector<Vec3d>{{0.05, 0.3, 0.2}}, 0.0);
    a = tracer.advance(stairs.sampler(), v, &v, 0.0, end, threads);
    EXPECT_EQ(a.counts.alive(), 1);
    return tracer.positions()[0];
  };
  advect::Advance a;
  EXPECT_LT(distance(run(1.8, a), {0.59, 0.48, 0.2}), 2e-9);
  // 0.54 in steps of 0.02, and a few that find the wall.
  EXPECT_LE(a.effects.contacts, 27 + 4);
  EXPECT_LE(a.work.evaluations, 2 * 27 + 30);
  // At x = 0.6 it falls by 0.2 within 0.06.
  EXPECT_LT(distance(run(2.3, a), {0.74, 0.53, 0.0}), 2e-9);
  EXPECT_GT(run(1.9, a).z, 0.05);
}

TEST_F(WallTest, SlidingIntoCornersEndsThere) {
  const BoxMesh mesh(5, 0.0, 1.0);
  respond(AtBoundary::slide);
  const auto seeds = random_points(12, 30, 0.05, 0.95);
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{1.0, 0.7, -0.9};
      },
      seeds, 5.0, 2);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
    EXPECT_LT(distance(t.positions()[i], {1.0, 1.0, 0.0}), 1e-6) << i;
  }
}

TEST_F(WallTest, ReflectedParticlesStayInside) {
  const BoxMesh mesh(5, 0.0, 1.0);
  respond(AtBoundary::reflect);
  const auto seeds = random_points(13, 40, 0.05, 0.95);
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{1.0, 0.0, 0.0};
      },
      seeds, 3.0, 2);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
    EXPECT_TRUE(in_cube(t.positions()[i], 0.0, 1.0));
    EXPECT_GT(t.positions()[i].x,
              1.0 - 0.11 * 0.35); // back by a tenth of a (jittered) cell at most
    EXPECT_NEAR(t.positions()[i].y, seeds[i].y, 1e-6);
  }
  EXPECT_GT(work.contacts, 40);
}

TEST_F(WallTest, PeriodicSidesTakeParticlesAcross) {
  const BoxMesh mesh(5, 0.0, 1.0);
  effects.boundary.emplace();
  effects.boundary->periodic[0] = effects.boundary->periodic[1] = true;
  const auto seeds = random_points(14, 40, 0.0, 1.0);
  const Tracer t = run(
      mesh,
      [](const Vec3d&) {
        return Vec3d{0.7, -1.1, 0};
      },
      seeds, 4.0, 4);
  const auto wrapped = [](double x) { return x - std::floor(x); };
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    ASSERT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
    // Six or so crossings, each placed to 1e-9 of a cell.
    EXPECT_NEAR(t.positions()[i].x, wrapped(seeds[i].x + 2.8), 1e-7);
    EXPECT_NEAR(t.positions()[i].y, wrapped(seeds[i].y - 4.4), 1e-7);
  }
  EXPECT_GT(work.contacts, 40 * 5);
}

TEST_F(WallTest, OtherSidesOfAPeriodicBoxHaveTheirOwnResponse) {
  const BoxMesh mesh(5, 0.0, 1.0);
  effects.boundary.emplace();
  effects.boundary->periodic[0] = true;
  const std::vector<Vec3d> seeds{{0.5, 0.5, 0.5}};
  const auto flow = [](const Vec3d&) { return Vec3d{1.0, 0, -0.25}; };
  {
    const Tracer t = run(mesh, flow, seeds, 3.0);
    EXPECT_EQ(t.particles().endings[0], INSITU_END_LEFT);
    EXPECT_NEAR(t.particles().times[0], 2.0, 1e-7);
  }
  effects.boundary->response = AtBoundary::stop;
  EXPECT_EQ(run(mesh, flow, seeds, 3.0).particles().endings[0], INSITU_END_STOPPED);
  effects.boundary->response = AtBoundary::slide;
  const Tracer t = run(mesh, flow, seeds, 3.75);
  EXPECT_EQ(t.particles().endings[0], INSITU_END_ALIVE);
  EXPECT_NEAR(t.positions()[0].x, 0.25, 1e-6);
}

TEST_F(WallTest, TheWalkMeetsWallsAsTheFlowDoes) {
  const BoxMesh mesh(4, 0.0, 1.0);
  effects.diffusion.emplace();
  effects.diffusion->horizontal.constant = effects.diffusion->vertical.constant = 0.02;
  const auto seeds = random_points(15, 100, 0.0, 1.0);
  for (const AtBoundary response : {AtBoundary::leave, AtBoundary::stop, AtBoundary::slide}) {
    respond(response);
    const Tracer t = run(mesh, still, seeds, 1.0);
    std::int64_t ended = 0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      EXPECT_TRUE(in_cube(t.positions()[i], 0.0, 1.0));
      const auto ending = t.particles().endings[i];
      ended += ending != INSITU_END_ALIVE;
      if (ending != INSITU_END_ALIVE) {
        EXPECT_EQ(ending, response == AtBoundary::leave ? INSITU_END_LEFT : INSITU_END_STOPPED);
      }
    }
    if (response == AtBoundary::slide) {
      EXPECT_EQ(ended, 0);
    } else {
      EXPECT_GT(ended, 20);
    }
    EXPECT_EQ(t.counts().sum(), 100);
  }
}

TEST_F(WallTest, HugeCoordinatesKeepParticlesInside) {
  // In geocentric metres, cells of 250 m: a skin of 1e-9 cells is below rounding, so what doubles
  // have is taken.
  const double at = 6.4e6, size = 1000.0;
  const BoxMesh mesh(4, at, at + size);
  for (const AtBoundary response : {AtBoundary::slide, AtBoundary::reflect}) {
    respond(response);
    const auto seeds = random_points(16, 30, at + 0.1 * size, at + 0.9 * size);
    const Tracer t = run(
        mesh,
        [](const Vec3d&) {
          return Vec3d{1e3, 5e2, -2e3};
        },
        seeds, 2.0);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      EXPECT_EQ(t.particles().endings[i], INSITU_END_ALIVE);
      EXPECT_TRUE(bool(mesh.sampler().locate(t.positions()[i])));
    }
  }
}

} // namespace
} // namespace insitu::test
