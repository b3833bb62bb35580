// What a commit of moved vertices puts off until a query needs it: the answers are those of a mesh
// on which it was done at once.
#include <latch>
#include <new>
#include <thread>

#include "mesh/piece_borders.h"
#include "query/on_demand.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::all_kinds;
using test::box;
using test::kind_name;
using test::same_bits;

namespace {

/// Moves every vertex a little, some of it a shear, so that the boxes of the step before are wrong.
void move(fixtures::Committed& m, int step) {
  test::Random random(1000 + std::uint64_t(step));
  for (std::size_t v = 0; v < m.arrays.points.size(); v += 3) {
    m.arrays.points[v] += 0.9 + 0.05 * m.arrays.points[v + 2];
    for (int a = 0; a < 3; ++a)
      m.arrays.points[v + std::size_t(a)] += 0.01 * random.uniform(-1.0, 1.0);
  }
  m.commit(INSITU_CHANGED_GEOMETRY);
}

class Throwing final : public query::PutOff {
public:
  Throwing() { set_due(true); }
  mutable int tried = 0;

private:
  void do_it() const override {
    if (++tried < 3)
      throw std::bad_alloc();
  }
};

} // namespace

TEST(PutOff, AnswersAreThoseOfAFitAtOnce) {
  for (const auto kind : all_kinds)
    for (const int threads : {1, 4}) {
      const test::TestMesh from = box(kind, 6);
      constexpr auto morton = accel::Builder::morton; // no other tree meanwhile
      fixtures::Committed at_once(from, threads, morton), later(from, threads, morton);
      for (int step = 0; step < 8; ++step) {
        move(at_once, step);
        move(later, step);
        EXPECT_NE(at_once.mesh.complete(at_once.memory).action, INSITU_KEEP);
        EXPECT_EQ(at_once.mesh.complete(at_once.memory).action, INSITU_KEEP) << "done by now";
        if (step % 4 == 1)
          continue; // a step in which nobody asks
        const mesh::MeshView& view = later.mesh.mesh().view();
        std::vector<Vec3d> points = test::hard_points(view, 300, 5 + std::uint64_t(step));
        for (const Vec3d& p : test::inner_points(view, 300, 6))
          points.push_back(p);
        const query::LocateOptions options{step % 2 ? INSITU_EXACT : INSITU_STANDARD, 1.0};
        std::vector<query::Location> want(points.size()), got(points.size());
        at_once.sampler().locate(at_once.threads, points, want, options);
        // Each step another kind of query is the first.
        if (step % 4 == 0)
          later.sampler().locate(later.threads, points, got, options);
        else if (step % 4 == 2)
          later.sampler().locate_serial(points, got, options);
        else
          for (std::size_t i = 0; i < points.size(); ++i)
            got[i] = later.sampler().locate(points[i], i % 2 ? want[i].cell : -1, options);
        for (std::size_t i = 0; i < points.size(); ++i)
          ASSERT_TRUE(same_bits(got[i], want[i])) << kind_name(kind) << ", step " << step;
      }
      const commit::FitsDone &a = at_once.mesh.fits_done(), &b = later.mesh.fits_done();
      EXPECT_EQ(a.put_off, 8);
      EXPECT_EQ(a.refits, 8);
      EXPECT_EQ(b.put_off, 8);
      EXPECT_EQ(b.refits, 6);
    }
}

TEST(PutOff, ManyThreadsAskFirstAtOnce) {
  for (int round = 0; round < 10; ++round) {
    const test::TestMesh from = box(test::MeshKind::hexahedra, 12);
    fixtures::Committed m(from, 2);
    move(m, round);
    const std::vector<Vec3d> points = test::inner_points(m.mesh.mesh().view(), 64, 3);
    constexpr int count = 8;
    std::vector<std::vector<query::Location>> got(count);
    std::latch start(count);
    {
      std::vector<std::jthread> threads;
      for (int t = 0; t < count; ++t)
        threads.emplace_back([&, t] {
          const query::Sampler sampler = m.sampler();
          start.arrive_and_wait();
          for (const Vec3d& p : points)
            got[std::size_t(t)].push_back(sampler.locate(p));
        });
    }
    EXPECT_EQ(m.mesh.fits_done().refits, 1);
    for (std::size_t i = 0; i < points.size(); ++i)
      for (const auto& g : got) {
        ASSERT_GE(g[i].cell, 0);
        ASSERT_TRUE(same_bits(g[i], got[0][i]));
      }
  }
}

// From within a parallel loop of the session's, whose threads then wait for each other.
TEST(PutOff, TasksOfTheSessionAskFirst) {
  const test::TestMesh from = box(test::MeshKind::hexahedra, 20);
  fixtures::Committed m(from, 4);
  for (int step = 0; step < 10; ++step) {
    move(m, step);
    const std::vector<Vec3d> points = test::inner_points(m.mesh.mesh().view(), 256, 3);
    std::atomic<int> outside{0};
    const query::Sampler sampler = m.sampler();
    m.threads.parallel_for(256, 1, [&](std::int64_t i, std::int64_t) {
      outside += !sampler.locate(points[std::size_t(i)]);
    });
    EXPECT_EQ(outside, 0);
  }
  EXPECT_EQ(m.mesh.fits_done().refits, 10);
}

TEST(PutOff, WhatItThrowsReachesTheCallerAndItIsTriedAgain) {
  const Throwing work;
  EXPECT_THROW(work.complete(), std::bad_alloc);
  EXPECT_TRUE(work.is_due());
  EXPECT_THROW(work.complete(), std::bad_alloc);
  work.complete();
  EXPECT_FALSE(work.is_due());
  work.complete();
  EXPECT_EQ(work.tried, 3);
}

// The step that was kept has a tree of its own, fitted to it, though nobody asked in that step.
TEST(PutOff, AStepThatNobodyAskedIsKeptWhole) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 5));
  std::vector<double> values(std::size_t(m.arrays.vertex_count()), 1.0);
  const insitu_array a = insitu_array_of(values.data(), INSITU_FLOAT64, m.arrays.vertex_count(), 1);
  m.mesh.mesh().set_field(0, "f", INSITU_VERTEX, &a, 1);
  m.commit();
  move(m, 0);
  const std::vector<Vec3d> points = test::inner_points(m.mesh.mesh().view(), 100, 3);
  m.mesh.keep_earlier({{"f"}}, true, m.threads);
  m.commit(INSITU_CHANGED_TOPOLOGY);
  ASSERT_NE(m.mesh.earlier_mesh(), nullptr);
  EXPECT_EQ(m.mesh.fits_done().refits, 0);
  for (const Vec3d& p : points)
    EXPECT_TRUE(same_bits(m.mesh.earlier_mesh()->sampler().locate(p), m.sampler().locate(p)));
}

// A particle whose cell is known to hold it asks for no fit.
TEST(PutOff, AHintThatIsProvenAsksForNoTree) {
  fixtures::Committed m(box(test::MeshKind::hexahedra, 5));
  move(m, 0);
  m.mesh.look_for_folds(m.threads);
  mesh::CellVertices cell;
  mesh::gather(m.mesh.mesh().view(), 7, cell);
  EXPECT_EQ(m.sampler().locate(mesh::middle_of(cell), 7).cell, 7);
  EXPECT_EQ(m.mesh.fits_done().refits, 0);
  EXPECT_EQ(m.sampler().locate(mesh::middle_of(cell)).cell, 7);
  EXPECT_EQ(m.mesh.fits_done().refits, 1);
}
