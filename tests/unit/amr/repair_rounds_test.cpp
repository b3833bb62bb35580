// Dual meshes whose repair takes rounds, against those enumerated at once from what the last round
// left.
#include <algorithm>
#include <array>
#include <bit>
#include <gtest/gtest.h>
#include <numeric>
#include <tuple>
#include <vector>

#include "amr/dual/dual_parts.h"
#include "amr/leaves/balance.h"
#include "amr/leaves/leaf_map.h"
#include "amr_mesh.h"

using namespace insitu;

namespace {

using Vertex = std::array<std::uint64_t, 4>; ///< moves, and the leaf or where a mean lies
using Cell = std::pair<int, std::vector<Vertex>>;

/// The cells of parts in an order that does not depend on these.
std::vector<Cell> cells_of(const std::vector<amr::DualPart>& parts) {
  std::vector<Cell> out;
  for (const amr::DualPart& part : parts)
    for (const amr::DualCell& c : part.cells) {
      Cell cell{int(c.shape), {}};
      for (int v = 0; v < mesh::vertex_count(c.shape); ++v) {
        const amr::VertexKey key = c.vertex(v);
        Vertex vertex = {key.moves, key.leaf, 0, 0};
        if (key.moves == amr::mean_moves) {
          const amr::MeanVertex& mean = part.means[key.leaf];
          for (std::size_t a = 0; a < 3; ++a)
            vertex[a + 1] = std::bit_cast<std::uint64_t>(mean.x[int(a)]);
          std::vector<std::uint32_t> leaves(mean.leaves, mean.leaves + mean.count);
          std::sort(leaves.begin(), leaves.end());
          for (const std::uint32_t leaf : leaves)
            vertex[1] = vertex[1] * 0x9e3779b97f4a7c15u + leaf;
        }
        cell.second.push_back(vertex);
      }
      out.push_back(std::move(cell));
    }
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<std::vector<std::uint32_t>> gridlets_of(const std::vector<amr::DualPart>& parts) {
  std::vector<std::vector<std::uint32_t>> out;
  for (const amr::DualPart& part : parts)
    for (const mesh::Gridlet& g : part.gridlets)
      out.emplace_back(part.leaves.begin() + g.first,
                       part.leaves.begin() + g.first + g.vertex_count());
  std::sort(out.begin(), out.end());
  return out;
}

amr::DualPart enumerate_all(const amr::BrickStore& store, const mesh::Lattice& lattice,
                            std::int64_t real) {
  std::vector<std::uint32_t> bricks(std::size_t(store.brick_count()));
  std::iota(bricks.begin(), bricks.end(), 0u);
  amr::DualPart part;
  amr::enumerate(store, lattice, bricks, real, false, part);
  return part;
}

struct Rounds {
  amr::VirtualLeaves made;
  int count = 0;
  std::size_t folded_later = 0; ///< corners, by a round's splits
};

/// The repair by enumerating everything in every round.
Rounds repair_in_full(const amr::BrickStore& store, const mesh::Lattice& lattice, std::int64_t real,
                      core::Memory& memory, const core::Threads& threads) {
  Rounds out;
  std::vector<amr::SteepCorner> corners;
  amr::BrickStore split(memory);
  amr::DualPart all = enumerate_all(store, lattice, real);
  while (all.folded > 0 && out.count < 7) {
    std::copy_if(all.steep.begin(), all.steep.end(), std::back_inserter(corners),
                 [](const amr::SteepCorner& c) { return c.folded; });
    out.made = amr::balance(store, corners, real);
    amr::overlay(store, out.made, split, threads);
    all = enumerate_all(split, lattice, real);
    out.folded_later += std::size_t(all.folded);
    ++out.count;
  }
  EXPECT_EQ(all.folded, 0);
  return out;
}

TEST(RepairRounds, LookOnlyAtCornersThatSplitsTouch) {
  int most = 0;
  std::size_t folded_later = 0;
  for (const int kind : {0, 5, 6})
    for (std::uint64_t seed = 11; seed <= 50; ++seed) {
      const test::Recipe recipe{
          .seed = seed, .kind = kind, .roots = kind == 5 ? 3 : 4, .levels = kind == 5 ? 7 : 5};
      test::AmrMesh mesh = test::make_mesh(recipe);
      const std::int64_t real = mesh.view().cell_count();
      core::Memory memory;
      const core::Threads threads(2);
      amr::LeafMap map(memory);
      map.build(mesh.view(), threads);
      const Rounds rounds = repair_in_full(map.store(), map.lattice(), real, memory, threads);
      const amr::DualParts dual =
          amr::make_dual_parts(map.store(), map.lattice(), real, memory, threads);
      ASSERT_EQ(dual.made.split.size(), rounds.made.split.size()) << recipe.name();
      for (std::size_t i = 0; i < dual.made.split.size(); ++i) {
        const mesh::AmrCell &a = dual.made.split[i], &b = rounds.made.split[i];
        ASSERT_EQ(a.depth, b.depth) << recipe.name();
        ASSERT_TRUE(std::equal(a.index, a.index + 3, b.index)) << recipe.name();
      }
      most = std::max(most, rounds.count);
      folded_later += rounds.folded_later;
    }
  EXPECT_GT(most, 2); // or little is shown
  EXPECT_GT(folded_later, 30u);
  std::printf("at most %d rounds; %zu corners folded after the first\n", most, folded_later);
}

TEST(RepairRounds, KeepWhatNoSplitTouches) {
  int several_rounds = 0;
  std::int64_t bricks = 0;
  for (const int kind : {0, 5, 6})
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const test::Recipe recipe{
          .seed = seed, .kind = kind, .roots = kind == 5 ? 3 : 4, .levels = kind == 5 ? 7 : 5};
      test::AmrMesh mesh = test::make_mesh(recipe);
      const mesh::AmrView& view = mesh.view();
      const std::int64_t real = view.cell_count();
      core::Memory memory;
      const core::Threads threads(2);
      amr::LeafMap map(memory);
      map.build(view, threads);
      const amr::DualParts dual =
          amr::make_dual_parts(map.store(), map.lattice(), real, memory, threads);
      EXPECT_EQ(dual.still_folded, 0) << recipe.name();
      amr::BrickStore split(memory);
      amr::overlay(map.store(), dual.made, split, threads);
      std::vector<amr::DualPart> once(1);
      once[0] = enumerate_all(split, map.lattice(), real);
      EXPECT_EQ(cells_of(dual.parts), cells_of(once)) << recipe.name();
      EXPECT_EQ(gridlets_of(dual.parts), gridlets_of(once)) << recipe.name();

      const amr::DualPart unrepaired = enumerate_all(map.store(), map.lattice(), real);
      EXPECT_EQ(dual.folded, unrepaired.folded) << recipe.name();
      std::vector<amr::SteepCorner> folded;
      std::copy_if(unrepaired.steep.begin(), unrepaired.steep.end(), std::back_inserter(folded),
                   [](const amr::SteepCorner& c) { return c.folded; });
      if (!folded.empty())
        several_rounds +=
            amr::balance(map.store(), folded, real).split.size() < dual.made.split.size();
      bricks = std::max(bricks, split.brick_count());
    }
  EXPECT_GT(several_rounds, 3); // or nothing is shown
  EXPECT_GT(bricks, 100);
  std::printf("%d of 18 meshes took more than one round; at most %lld bricks\n", several_rounds,
              static_cast<long long>(bricks));
}

} // namespace
