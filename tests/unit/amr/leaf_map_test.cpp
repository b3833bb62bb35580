// Where leaves lie, against plain loops over all cells.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "amr/leaves/leaf_map.h"
#include "amr_mesh.h"

using namespace insitu;

namespace {

void compare(test::AmrMesh& mesh, const std::string& name) {
  core::Memory memory;
  const mesh::AmrView& view = mesh.view();
  amr::LeafMap map(memory);
  map.build(view, core::Threads(2));
  const std::vector<test::Leaf> leaves = test::leaves_of(mesh);
  ASSERT_EQ(map.leaf_count(), std::int64_t(leaves.size())) << name;
  ASSERT_EQ(map.masked_count(), view.cell_count() - std::int64_t(leaves.size())) << name;
  for (const test::Leaf& l : leaves) {
    ASSERT_EQ(map.at(l.depth, l.index.data()), l.id) << name;
    for (int u = 1; u <= l.depth; ++u) {
      const std::int64_t above[3] = {l.index[0] >> u, l.index[1] >> u, l.index[2] >> u};
      ASSERT_EQ(map.at(l.depth - u, above), amr::LeafMap::refined) << name;
      ASSERT_FALSE(map.cover(l.depth - u, above)) << name;
    }
    const std::int64_t below[3] = {4 * l.index[0] + 3, 4 * l.index[1], 4 * l.index[2] + 2};
    const amr::LeafMap::Leaf cover = map.cover(l.depth + 2, below);
    ASSERT_EQ(cover.id, l.id) << name;
    ASSERT_EQ(cover.cell.depth, l.depth) << name;
  }
  // Points: random ones, and on faces. A cell is closed below and open above.
  const auto owner = [&](const math::Vec3d& p) {
    std::uint32_t open = amr::LeafMap::nothing, closed = amr::LeafMap::nothing;
    for (const test::Leaf& l : leaves) {
      bool in = true, on = true;
      for (int a = 0; a < 3; ++a) {
        const double lo = view.lattice.place(a, l.depth, 2 * l.index[std::size_t(a)]);
        const double hi = view.lattice.place(a, l.depth, 2 * l.index[std::size_t(a)] + 2);
        in &= lo <= p[a] && p[a] < hi;
        on &= lo <= p[a] && p[a] <= hi;
      }
      open = in ? l.id : open;
      closed = on ? l.id : closed;
    }
    return std::pair(open, closed);
  };
  for (std::uint64_t n = 0; n < 200 && !leaves.empty(); ++n) {
    const test::Leaf& l = leaves[std::size_t(core::random_bits(5, n, 0) % leaves.size())];
    math::Vec3d p;
    for (int a = 0; a < 3; ++a) {
      const double r = core::random_unit(5, n, std::uint64_t(1 + a));
      const std::int64_t face = 2 * l.index[std::size_t(a)] + (r < 0.5 ? 0 : 2);
      p[a] = n % 3 == 0 ? view.lattice.place(a, l.depth, face)
                        : view.lattice.centre(a, l.depth, l.index[std::size_t(a)]) +
                              (2 * r - 1) * view.lattice.width(a, l.depth);
    }
    const auto [open, closed] = owner(p);
    const amr::LeafMap::Leaf found = map.find(p);
    if (open != amr::LeafMap::nothing)
      ASSERT_EQ(found.id, open) << name;
    else
      ASSERT_EQ(bool(found), closed != amr::LeafMap::nothing) << name;
  }
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300, -1e18})
    ASSERT_FALSE(map.find({bad, 0.0, 3.0})) << name;
}

} // namespace

TEST(LeafMap, RandomMeshes) {
  for (int kind = 0; kind <= 4; ++kind)
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const test::Recipe recipe{seed, kind, 3, kind == 0 ? 5 : 3};
      test::AmrMesh mesh = test::make_mesh(recipe);
      compare(mesh, recipe.name());
    }
}

TEST(LeafMap, SingleCellsAndFarApart) {
  test::AmrMesh none, one, apart, deep;
  compare(none, "no cell");
  one.add_leaf(0, {0, 0, 0});
  compare(one, "one cell");
  // Too far apart for an array over the bricks' range.
  for (std::int64_t n = 0; n < 40; ++n)
    apart.add_leaf(0, {n * n * 1000, -n * 7777, n * 12345});
  compare(apart, "far apart");
  deep.depth_of = {0, 30};
  deep.add_leaf(1, {1000000000, 5, -1000000000});
  compare(deep, "deep");
}
