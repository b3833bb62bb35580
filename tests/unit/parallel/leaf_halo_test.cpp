/// Adaptive meshes over processes: what is located and sampled is what one process has, to the bit.
#include <algorithm>
#include <bit>
#include <gtest/gtest.h>

#include "amr_part.h"
#include "commit/halo/everywhere.h"
#include "part_of_mesh.h"
#include "threaded_world.h"

using namespace insitu;
using math::Vec3d;
using test::AmrMesh;
using test::Recipe;

namespace {

/// Corners and middles of leaves, middles of their faces and edges, and points anywhere.
std::vector<Vec3d> hard_points(AmrMesh& mesh, std::size_t most) {
  std::vector<Vec3d> points;
  const std::vector<test::Leaf> leaves = test::leaves_of(mesh);
  const mesh::Lattice& lattice = mesh.lattice;
  const std::size_t skip = 1 + leaves.size() * 27 / most;
  std::size_t n = 0;
  Vec3d low = {1e300, 1e300, 1e300}, high = {-1e300, -1e300, -1e300};
  for (const test::Leaf& leaf : leaves)
    for (int place = 0; place < 27; ++place) {
      const int at[3] = {place % 3, place / 3 % 3, place / 9};
      Vec3d p;
      for (int a = 0; a < 3; ++a) {
        p[a] = lattice.place(a, leaf.depth, 2 * leaf.index[std::size_t(a)] + at[a]);
        low[a] = std::min(low[a], p[a]);
        high[a] = std::max(high[a], p[a]);
      }
      if (n++ % skip == 0)
        points.push_back(p);
    }
  for (std::uint64_t i = 0; i < most; ++i) {
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = low[a] + (high[a] - low[a]) * (1.1 * core::random_unit(5, i, std::uint64_t(a)) - 0.05);
    points.push_back(p);
  }
  return points;
}

struct Answer {
  std::int64_t cell = -1;
  int rank = -1;
  Vec3d parametric;
  double values[4] = {0, 0, 0, 0};
};

struct Process : test::PartOfMesh<test::AmrPart> {
  Process(const AmrMesh& whole, insitu_reconstruction how, const test::Deal& deal,
          parallel::World& world_)
      : PartOfMesh(world_, whole, how, deal) {
    mesh.mesh().set_is_part(world.size() > 1);
    part.give(mesh.mesh());
    commit();
  }
  void commit() {
    mesh.commit(threads, log, memory, false);
    if (mesh.needs_halo(world))
      mesh.update_halo(world, threads, log);
  }
  std::vector<Answer> ask(std::span<const Vec3d> points) {
    std::vector<Answer> answers(points.size());
    commit::Everywhere everywhere(mesh, world);
    const std::vector<std::string> names{"s", "v"};
    everywhere.sample(points, names, {}, threads,
                      [&](std::size_t first, std::span<const commit::OwnerOfAll> owners,
                          std::span<const double> values) {
                        for (std::size_t i = 0; i < owners.size(); ++i) {
                          Answer& a = answers[first + i];
                          if (!owners[i])
                            continue;
                          a.cell = owners[i].cell.global;
                          a.rank = owners[i].cell.rank;
                          a.parametric = owners[i].parametric;
                          std::copy_n(values.begin() + std::ptrdiff_t(4 * i), 4, a.values);
                        }
                      });
    return answers;
  }
};

/// What a process's cells and its halo's say of points, the latter without their owner: whichever
/// process answers, its bits are those of all. Told one by one, as tracers ask, and all together.
std::vector<Answer> answers_here(Process& process, std::span<const Vec3d> points, bool together) {
  const query::Sampler sampler = process.mesh.own_sampler();
  std::vector<query::Location> at(points.size());
  if (together)
    sampler.locate(process.threads, points, at, {}, {});
  else
    for (std::size_t i = 0; i < points.size(); ++i)
      at[i] = sampler.locate(points[i], i > 0 ? at[i - 1].cell : -1);
  std::vector<Answer> answers(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!at[i])
      continue;
    answers[i].cell = at[i].cell;
    answers[i].rank = process.world.rank();
    answers[i].parametric = at[i].parametric;
    const std::vector<mesh::FieldView> fields{process.mesh.mesh().field("s"),
                                              process.mesh.mesh().field("v")};
    sampler.interpolate(fields, at[i], answers[i].values);
  }
  return answers;
}

void expect_same(const std::vector<Answer>& expected, const std::vector<Answer>& found,
                 std::span<const Vec3d> points, const std::string& what) {
  int differ = 0;
  for (std::size_t i = 0; i < expected.size() && differ < 5; ++i) {
    bool same = expected[i].cell == found[i].cell;
    for (int a = 0; a < 3; ++a)
      same &= std::bit_cast<std::uint64_t>(expected[i].parametric[a]) ==
              std::bit_cast<std::uint64_t>(found[i].parametric[a]);
    for (int c = 0; c < 4; ++c)
      same &= std::bit_cast<std::uint64_t>(expected[i].values[c]) ==
              std::bit_cast<std::uint64_t>(found[i].values[c]);
    differ += !same;
    EXPECT_TRUE(same) << what << ": point " << i << " (" << points[i].x << ", " << points[i].y
                      << ", " << points[i].z << "): cell " << expected[i].cell << " and "
                      << found[i].cell << ", value " << expected[i].values[0] << " and "
                      << found[i].values[0] << ", parametric " << expected[i].parametric.x
                      << " and " << found[i].parametric.x;
  }
}

/// Slabs along x, boxes, or at random; `empty` more processes have nothing.
test::Deal deal_of(AmrMesh& whole, int kind, int processes, int empty) {
  const int parts = std::max(1, processes - empty);
  Vec3d low = {1e300, 1e300, 1e300}, high = {-1e300, -1e300, -1e300};
  for (const test::Leaf& leaf : test::leaves_of(whole))
    for (int a = 0; a < 3; ++a) {
      const double size = 1.0 / double(1 << leaf.depth);
      low[a] = std::min(low[a], double(leaf.index[std::size_t(a)]) * size);
      high[a] = std::max(high[a], double(leaf.index[std::size_t(a)] + 1) * size);
    }
  return [=](std::size_t number, const Vec3d& middle) {
    const auto share = [&](int a, int n) {
      return std::min(n - 1, int(double(n) * (middle[a] - low[a]) / (high[a] - low[a])));
    };
    if (kind == 0)
      return empty + share(0, parts);
    if (kind == 1)
      return empty + (share(0, 2) + 2 * share(1, 2) + 4 * share(2, 2)) % parts;
    return empty + int(core::random_unit(9, number, 0) * parts);
  };
}

void check(const Recipe& recipe, insitu_reconstruction how, std::initializer_list<int> processes,
           int deal_kind, int empty = 0) {
  AmrMesh whole = test::make_mesh(recipe);
  const std::vector<Vec3d> points = hard_points(whole, 600);
  std::vector<Answer> expected;
  test::run_processes(1, [&](parallel::World& world) {
    expected = Process(
                   whole, how, [](std::size_t, const Vec3d&) { return 0; }, world)
                   .ask(points);
  });
  EXPECT_GT(std::ranges::count_if(expected, [](const Answer& a) { return a.cell >= 0; }),
            std::ptrdiff_t(expected.size() / 2));
  for (const int n : processes) {
    const test::Deal deal = deal_of(whole, deal_kind, n, n > 1 ? empty : 0);
    std::vector<Answer> found;
    test::run_processes(n, [&](parallel::World& world) {
      Process process(whole, how, deal, world);
      std::vector<Answer> answers = process.ask(points);
      if (world.is_root())
        found = std::move(answers);
    });
    expect_same(expected, found, points,
                recipe.name() + ", deal " + std::to_string(deal_kind) + " on " + std::to_string(n) +
                    (how == INSITU_NEAREST ? ", nearest" : ", dual"));
  }
}

/// Points inside of cells: of those that a halo lacks some may hold points on faces.
void check_halo(const Recipe& recipe, insitu_reconstruction how, int processes, int deal_kind) {
  AmrMesh whole = test::make_mesh(recipe);
  const std::vector<Vec3d> all = hard_points(whole, 2000);
  const std::span<const Vec3d> points = std::span(all).last(2000);
  const auto one = [](std::size_t, const Vec3d&) { return 0; };
  for (const bool together : {false, true}) {
    std::vector<Answer> expected;
    test::run_processes(1, [&](parallel::World& world) {
      Process process(whole, how, one, world);
      expected = answers_here(process, points, together);
    });
    const test::Deal deal = deal_of(whole, deal_kind, processes, 0);
    std::vector<std::vector<Answer>> found(static_cast<std::size_t>(processes));
    test::run_processes(processes, [&](parallel::World& world) {
      Process process(whole, how, deal, world);
      found[std::size_t(world.rank())] = answers_here(process, points, together);
    });
    for (const std::vector<Answer>& here : found) {
      std::vector<Answer> there = expected;
      for (std::size_t i = 0; i < there.size(); ++i)
        if (here[i].cell < 0)
          there[i] = here[i];
        else
          there[i].cell = here[i].cell;
      expect_same(there, here, points,
                  recipe.name() + ", halo, deal " + std::to_string(deal_kind) + " on " +
                      std::to_string(processes) + (together ? ", together" : ", one by one"));
    }
  }
}

TEST(LeafHalo, HaloCellsAnswerAsTheirOwners) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (int deal = 0; deal < 3; ++deal)
      for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
        check_halo({seed, 0, 2, 3}, how, 4, deal);
  for (const int kind : {1, 2, 3, 4, 5})
    check_halo({2, kind, 3, 3}, INSITU_DUAL, 3, 2);
}

TEST(LeafHalo, OctreesAreAsOnOneProcess) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    for (int deal = 0; deal < 3; ++deal)
      for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
        check({seed, 0, 2, 3}, how, {1, 2, 4}, deal, int(seed % 2));
}

TEST(LeafHalo, FoldsAreRepairedAsOnOneProcess) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    check({seed, 5, 2, 5}, INSITU_DUAL, {3}, int(seed % 3));
  check({4, 5, 2, 4}, INSITU_DUAL, {2, 8}, 1);
}

TEST(LeafHalo, PatchesAreAsOnOneProcess) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed)
    for (const int kind : {1, 2, 3, 4})
      for (const insitu_reconstruction how : {INSITU_DUAL, INSITU_NEAREST})
        check({seed, kind, 3, 3}, how, {3}, int(seed % 3));
  check({2, 2, 3, 3}, INSITU_DUAL, {2, 8}, 2);
}

/// The dual of a process's leaves alone is made for who asks before the halo is there, and for
/// nobody else: a regrid builds one.
TEST(LeafHalo, TheDualOfACommitWaits) {
  AmrMesh whole = test::make_mesh({1, 0, 2, 3});
  const test::Deal deal = deal_of(whole, 0, 2, 0);
  test::run_processes(2, [&](parallel::World& world) {
    const core::Threads threads(1);
    const core::Log log;
    core::Memory memory;
    commit::CommittedMesh mesh("part", memory);
    mesh.mesh().set_is_part(true);
    test::AmrPart part(whole, INSITU_DUAL, deal, world.rank());
    part.give(mesh.mesh());
    part.give_fields(mesh.mesh(), 1.0);
    for (int regrid = 0; regrid < 2; ++regrid) {
      const bool asks = world.rank() == regrid;
      mesh.mesh().set_changed(INSITU_CHANGED_ALL);
      mesh.commit(threads, log, memory, false);
      EXPECT_TRUE(mesh.stand_in()->waits());
      if (asks) { // every cell of it lies among own leaves
        const mesh::MeshView& own = mesh.sampler().mesh();
        EXPECT_GT(own.cell_count(), 0);
        EXPECT_GT(mesh.amr_info().cubes + mesh.amr_info().stitching, 0);
      }
      EXPECT_EQ(mesh.stand_in()->waits(), !asks);
      mesh.update_halo(world, threads, log);
      EXPECT_FALSE(mesh.stand_in()->waits());
      mesh.mesh().set_changed(INSITU_CHANGED_FIELDS);
      mesh.commit(threads, log, memory, false);
      EXPECT_FALSE(mesh.stand_in()->waits());
    }
  });
}

/// On all processes alike.
TEST(LeafHalo, OverlapsAndOtherLatticesAreNamed) {
  AmrMesh whole;
  for (std::int64_t i = 0; i < 3; ++i)
    whole.add_leaf(0, {i, 0, 0});
  const auto message = [&](parallel::World& world, const AmrMesh& mine, const test::Deal& deal) {
    try {
      Process process(mine, INSITU_DUAL, deal, world);
    } catch (const core::Error& e) {
      return std::string(e.what());
    }
    return std::string("none");
  };
  test::run_processes(2, [&](parallel::World& world) {
    const std::string overlap = message( // both have the one in the middle
        world, whole, [&](std::size_t number, const Vec3d&) {
          return number == 1 ? world.rank() : number == 0 ? 0 : 1;
        });
    EXPECT_NE(overlap.find("overlap"), std::string::npos) << overlap;
    EXPECT_NE(overlap.find("of process 0"), std::string::npos) << overlap;
    EXPECT_NE(overlap.find("of process 1"), std::string::npos) << overlap;
    AmrMesh mine = whole;
    mine.lattice.origin[1] += 1e-9 * world.rank();
    const std::string other =
        message(world, mine, [](std::size_t number, const Vec3d&) { return int(number % 2); });
    EXPECT_NE(other.find("one mesh has one lattice"), std::string::npos) << other;
    EXPECT_NE(other.find("process 1"), std::string::npos) << other;
  });
}

} // namespace
