// The store of particles and the record of their tracks.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <string>

#include "advect/lines/tracks.h"
#include "advect/particles.h"
#include "core/status.h"

namespace insitu::test {
namespace {

using advect::Particles;
using math::Vec3d;

std::vector<Vec3d> row(int n) {
  std::vector<Vec3d> points;
  for (int i = 0; i < n; ++i)
    points.push_back({double(i), 0, 0});
  return points;
}

TEST(Particles, IdsAreNeverUsedAgain) {
  core::Memory memory;
  Particles p(memory);
  p.seed(row(4), 0.0);
  p.endings[1] = INSITU_END_LEFT;
  p.endings[3] = INSITU_END_EXPIRED;
  p.drop_ended();
  ASSERT_EQ(p.size(), 2u);
  EXPECT_EQ(p.ids[0], 0);
  EXPECT_EQ(p.ids[1], 2);
  EXPECT_EQ(p.positions[1], (Vec3d{2, 0, 0}));
  p.seed(row(1), 5.0);
  EXPECT_EQ(p.ids[2], 4);
  EXPECT_EQ(p.times[2], 5.0);
  EXPECT_EQ(p.cells[2], -1);
  const advect::Counts c = p.counts();
  EXPECT_EQ(c.seeded, 5);
  EXPECT_EQ(c.alive(), 3);
  EXPECT_EQ(c.by_ending[INSITU_END_LEFT], 1);
  EXPECT_EQ(c.by_ending[INSITU_END_EXPIRED], 1);
  EXPECT_EQ(c.sum(), 5);
}

TEST(Particles, AMissingParticleIsAnError) {
  core::Memory memory;
  Particles p(memory);
  p.seed(row(4), 0.0);
  p.endings.resize(3);
  try {
    p.counts();
    FAIL();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_INTERNAL);
    EXPECT_STREQ(e.what(), "tracer: 4 particles were seeded, but 3 are accounted for");
  }
  p.endings.resize(4);
  p.endings[3] = 99;
  EXPECT_THROW(p.counts(), core::Error);
}

TEST(Particles, MemoryIsCounted) {
  core::Memory memory;
  {
    Particles p(memory);
    p.seed(row(1000), 0.0);
    EXPECT_GE(memory.current(INSITU_MEMORY_TRACER), 1000 * (3 + 6) * 8);
    EXPECT_EQ(memory.current(), memory.current(INSITU_MEMORY_TRACER));
  }
  EXPECT_EQ(memory.current(), 0);
}

TEST(Particles, EveryEndingHasAName) {
  for (int e = 0; e < INSITU_END_COUNT; ++e) {
    EXPECT_STRNE(advect::ending_name(insitu_ending(e)), "unknown");
    for (int f = 0; f < e; ++f)
      EXPECT_STRNE(advect::ending_name(insitu_ending(e)), advect::ending_name(insitu_ending(f)));
  }
  EXPECT_STREQ(advect::ending_name(INSITU_END_COUNT), "unknown");
}

/// All particles that live go on by one in x and time.
void go_on(Particles& p) {
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p.endings[i] == INSITU_END_ALIVE) {
      p.fresh[i] = 0;
      p.positions[i].x += 1.0;
      p.times[i] += 1.0;
      p.cells[i] = std::int64_t(10 * p.ids[i] + std::int64_t(p.times[i]));
    }
}

TEST(Tracks, OneLinePerParticleInOrder) {
  core::Memory memory;
  Particles p(memory);
  advect::Tracks tracks(memory);
  p.seed(row(3), 0.0);
  EXPECT_EQ(tracks.record(p), 0u);
  EXPECT_EQ(tracks.size(), 0u) << "not found inside yet";
  go_on(p);
  p.endings[2] = INSITU_END_SEED_OUTSIDE;
  p.fresh[2] = 1;
  EXPECT_EQ(tracks.record(p), 0u);
  go_on(p);
  p.endings[0] = INSITU_END_LEFT; // ended in this step: its last vertex is still recorded
  EXPECT_EQ(tracks.record(p), 2u);
  EXPECT_EQ(tracks.record(p), 4u) << "nothing moved, nothing is added";
  p.drop_ended();
  p.seed(row(1), 2.0);
  go_on(p);
  tracks.record(p);

  core::Buffer<std::int64_t> order(memory, INSITU_MEMORY_TRACER);
  const advect::Polylines lines = tracks.lines(&order);
  ASSERT_EQ(lines.line_count(), 3u);
  const std::int64_t ids[] = {0, 1, 3};
  const std::size_t counts[] = {2, 3, 1};
  for (std::size_t l = 0; l < 3; ++l) {
    EXPECT_EQ(lines.particles[l], ids[l]);
    const std::size_t first = std::size_t(lines.offsets[l]);
    ASSERT_EQ(std::size_t(lines.offsets[l + 1]) - first, counts[l]);
    const double start = l == 2 ? 3.0 : 1.0;
    for (std::size_t v = 0; v < counts[l]; ++v) {
      EXPECT_EQ(lines.times[first + v], start + double(v));
      EXPECT_EQ(lines.cells[first + v], 10 * ids[l] + std::int64_t(start) + std::int64_t(v));
      EXPECT_EQ(tracks.points()[std::size_t(order[first + v])], lines.points[first + v]);
    }
  }
  EXPECT_EQ(lines.endings[0], INSITU_END_LEFT);
  EXPECT_EQ(lines.endings[1], INSITU_END_ALIVE);
  EXPECT_EQ(lines.vertex_count(), tracks.size());
}

TEST(Tracks, NothingRecorded) {
  core::Memory memory;
  const advect::Tracks tracks(memory);
  const advect::Polylines lines = tracks.lines();
  EXPECT_EQ(lines.line_count(), 0u);
  EXPECT_EQ(lines.offsets.size(), 1u);
}

} // namespace
} // namespace insitu::test
