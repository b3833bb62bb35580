// Particles in a box that nothing flows out of, seeded on its walls, edges and corners too: none is
// lost and none comes out, by all methods, in all cells, with all effects; and on walls along the
// axes they stay to the bit.
#include <cstdlib>
#include <gtest/gtest.h>

#include "../advect/box_mesh.h"
#include "../advect/lane_runs.h"
#include "closed_box.h"

namespace insitu::test {
namespace {

using advect::AtBoundary;
using advect::Effects;

constexpr Method all_methods[] = {Method::euler, Method::rk4, Method::bs32, Method::dopri5};

/// What is tried of a particle: a few steps, or as many as the soak asks for.
std::int64_t steps_wanted() {
  const char* const asked = std::getenv("INSITU_WALL_STEPS");
  return asked ? std::atoll(asked) : 0;
}

struct Trip {
  advect::TracerSettings settings;
  Effects effects;
  bool drifts = false; ///< by a part of the flow itself
  bool stays = true;   ///< what is on a wall along an axis goes along it
  int cycles = 4;
  double cycle = 0.6; ///< time
};

/// Particles from all seeds that the box holds. Says what went wrong, if something did.
std::string travel(ClosedBox& box, Trip trip) {
  core::Memory memory;
  box.flow(0.0);
  std::vector<Vec3d> first;
  for (const Vec3d& seed : box.seeds())
    if (box.sampler().locate(seed))
      first.push_back(seed);
  if (first.size() < (box.slants ? 8U : 64U))
    return "only " + std::to_string(first.size()) + " seeds are inside";
  advect::Tracer tracer(trip.settings, memory);
  tracer.seed(first, 0.0);
  std::int64_t steps = 0;
  const std::int64_t wanted = steps_wanted() * std::int64_t(first.size());
  for (int c = 0; c < trip.cycles || steps < wanted; ++c) {
    const double t0 = c * trip.cycle, t1 = (c + 1) * trip.cycle;
    if (box.moves)
      box.move(t1);
    box.flow(t1);
    const mesh::FieldView v = box.field();
    if (trip.drifts) {
      advect::Drift drift;
      drift.field = advect::FieldInTime{v, {}};
      drift.factor = 0.3;
      trip.effects.drifts = {drift};
    }
    tracer.set_effects(trip.effects);
    steps += tracer.advance(box.sampler(), v, &v, t0, t1, box.threads).work.steps;
    for (std::size_t i = 0; i < first.size(); ++i) {
      const Vec3d x = tracer.positions()[i];
      const std::string where = "particle " + std::to_string(i) + " in cycle " +
                                std::to_string(c) + " at " + std::to_string(x.x) + " " +
                                std::to_string(x.y) + " " + std::to_string(x.z);
      if (tracer.particles().endings[i] != INSITU_END_ALIVE)
        return where + ": " +
               advect::ending_name(insitu_ending(tracer.particles().endings[i]));
      if (!box.sampler().locate(x))
        return where + ": outside";
      for (int a = 0; a < 3; ++a)
        if (trip.stays && !box.slants && !box.moves &&
            (first[i][a] == 0.0 || first[i][a] == box.high[a]) && x[a] != first[i][a])
          return where + ": off its wall";
    }
    if (tracer.counts().alive() != std::int64_t(first.size()))
      return "some are missing";
  }
  return "";
}

struct Kind {
  std::string name;
  std::function<void(ClosedBox&)> give;
  bool may_slant = true;
};

std::vector<Kind> all_boxes() {
  std::vector<Kind> all;
  const char* const names[] = {"hexahedra", "voxels", "wedges", "pyramids", "tetrahedra", "mixed"};
  int at = 0;
  for (const MeshKind kind : all_kinds)
    all.push_back({names[at++], [kind](ClosedBox& box) { box.give_cells(kind, 3); },
                   kind != MeshKind::voxels});
  all.push_back({"uniform block",
                 [](ClosedBox& box) { box.give_block(INSITU_BLOCK_UNIFORM, 5); }, false});
  all.push_back({"rectilinear block",
                 [](ClosedBox& box) { box.give_block(INSITU_BLOCK_RECTILINEAR, 5); }, false});
  all.push_back({"curvilinear block",
                 [](ClosedBox& box) { box.give_block(INSITU_BLOCK_CURVILINEAR, 5); }});
  all.push_back({"patches, dual", [](ClosedBox& box) { box.give_patches(INSITU_DUAL); }, false});
  all.push_back(
      {"patches, nearest", [](ClosedBox& box) { box.give_patches(INSITU_NEAREST); }, false});
  return all;
}

TEST(ClosedBox, KeepsItsParticlesByAllMethods) {
  for (const Kind& kind : all_boxes())
    for (const bool slants : {false, true})
      for (const Method method : all_methods)
        for (const bool face_aware : {false, true}) {
          if (slants && !kind.may_slant)
            continue;
          ClosedBox box;
          box.slants = slants;
          kind.give(box);
          Trip trip;
          trip.settings.integrator.method = method;
          trip.settings.integrator.face_aware = face_aware;
          EXPECT_EQ(travel(box, trip), "") << kind.name << (slants ? ", slanted" : "")
                                           << ", method " << int(method)
                                           << (face_aware ? ", face-aware" : "");
        }
}

/// Of effects.
struct Effect {
  const char* name;
  std::function<void(Trip&)> give;
};
std::vector<Effect> all_effects() {
  std::vector<Effect> all;
  const auto at_boundary = [&](const char* name, AtBoundary response) {
    all.push_back({name, [response](Trip& trip) {
                     trip.effects.boundary.emplace();
                     trip.effects.boundary->response = response;
                   }});
  };
  at_boundary("leave", AtBoundary::leave);
  at_boundary("stop", AtBoundary::stop);
  at_boundary("slide", AtBoundary::slide);
  at_boundary("reflect", AtBoundary::reflect);
  at_boundary("put back", AtBoundary::put_back);
  all.push_back({"drift", [](Trip& trip) { trip.drifts = true; }});
  all.push_back({"random walk", [](Trip& trip) {
                   trip.stays = false;
                   trip.effects.diffusion.emplace();
                   trip.effects.diffusion->horizontal.constant = 0.01;
                   trip.effects.diffusion->vertical.constant = 0.01;
                 }});
  all.push_back({"inertia", [](Trip& trip) {
                   trip.stays = false; // the others meet the walls
                   trip.effects.boundary.emplace();
                   trip.effects.boundary->response = AtBoundary::reflect;
                   trip.effects.inertia.emplace();
                   trip.effects.inertia->response_time = 0.05;
                 }});
  return all;
}

TEST(ClosedBox, KeepsItsParticlesUnderAllEffects) {
  for (const Kind& kind : all_boxes())
    for (const bool slants : {false, true})
      for (const Effect& effect : all_effects()) {
        if (slants && !kind.may_slant)
          continue;
        ClosedBox box;
        box.slants = slants;
        kind.give(box);
        Trip trip;
        trip.cycles = 2;
        effect.give(trip);
        EXPECT_EQ(travel(box, trip), "")
            << kind.name << (slants ? ", slanted" : "") << ", " << effect.name;
      }
}

TEST(ClosedBox, KeepsItsParticlesWhileItMoves) {
  // Inner vertices go to and fro; those on walls, along these.
  const auto sloshing = [](const Vec3d& p, double time) {
    Vec3d x = p;
    for (int a = 0; a < 3; ++a) {
      const double other = p[(a + 1) % 3] / box_edge;
      if (p[a] != 0.0 && p[a] != box_edge)
        x[a] += 0.05 * std::sin(1.3 * time + 5.0 * other);
    }
    return x;
  };
  for (const Kind& kind : all_boxes())
    for (const bool slants : {false, true})
      for (const Method method : all_methods) {
        ClosedBox box;
        box.moves = sloshing;
        box.slants = slants;
        if (!kind.may_slant)
          continue;
        kind.give(box);
        Trip trip;
        trip.settings.integrator.method = method;
        EXPECT_EQ(travel(box, trip), "")
            << kind.name << (slants ? ", slanted" : "") << ", method " << int(method);
      }
}

TEST(ClosedBox, LanesGoWhereParticlesGoOneByOne) {
  for (const Kind& kind : all_boxes())
    for (const bool slants : {false, true})
      for (const bool face_aware : {false, true}) {
        if (slants && !kind.may_slant)
          continue;
        ClosedBox box;
        box.slants = slants;
        kind.give(box);
        box.flow(0.3);
        const mesh::FieldView v = box.field();
        IntegratorSettings settings;
        settings.face_aware = face_aware;
        const Flow flow{v, nullptr, 0.0, 2.0};
        const Ends one = one_by_one(box.sampler(), flow, settings, box.seeds(), 2.0, nullptr);
        const Ends many = in_lanes(box.sampler(), flow, settings, box.seeds(), 2.0, nullptr);
        EXPECT_EQ(different(one, many), 0U) << kind.name << (slants ? ", slanted" : "");
      }
}

} // namespace
} // namespace insitu::test
