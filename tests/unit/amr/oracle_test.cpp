// The dual's cells against those of a plain construction: a cell at each corner that all around are
// leaves of, its vertices the leaves that touch the corner there (Zellmann 2023, section 4.1).
#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "amr/dual/dual_mesh.h"
#include "amr_mesh.h"

namespace insitu::test {
namespace {

using Ids = std::vector<std::uint32_t>; ///< of leaves, each once, ascending
/// How many cells have these vertices.
using Cells = std::map<Ids, int>;

void add_cell(Cells& cells, Ids ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  ++cells[std::move(ids)];
}

/// Looks leaves up by depth and index, one depth after the other.
class Leaves {
public:
  explicit Leaves(AmrMesh& mesh) : leaves_(leaves_of(mesh)) {
    for (const Leaf& leaf : leaves_) {
      by_place_[{leaf.depth, leaf.index}] = &leaf;
      deepest_ = std::max(deepest_, leaf.depth);
    }
  }
  const std::vector<Leaf>& all() const { return leaves_; }
  int deepest() const { return deepest_; }
  /// That covers a cell of the deepest depth, or null.
  const Leaf* covering(Index cell) const {
    for (int depth = deepest_; depth >= 0; --depth) {
      if (const auto found = by_place_.find({depth, cell}); found != by_place_.end())
        return found->second;
      for (std::int64_t& i : cell)
        i >>= 1;
    }
    return nullptr;
  }

private:
  std::vector<Leaf> leaves_;
  std::map<std::pair<int, Index>, const Leaf*> by_place_;
  int deepest_ = 0;
};

Cells plain_dual(const Leaves& leaves) {
  // Corners on the deepest lattice, each once.
  std::set<Index> corners;
  for (const Leaf& leaf : leaves.all())
    for (int c = 0; c < 8; ++c) {
      Index corner;
      for (int a = 0; a < 3; ++a)
        corner[std::size_t(a)] = (leaf.index[std::size_t(a)] + (c >> a & 1))
                                 << (leaves.deepest() - leaf.depth);
      corners.insert(corner);
    }
  Cells cells;
  for (const Index& corner : corners) {
    Ids ids;
    bool inside = true;
    for (int c = 0; inside && c < 8; ++c) {
      Index cell = corner;
      for (int a = 0; a < 3; ++a)
        cell[std::size_t(a)] -= (c >> a & 1);
      const Leaf* const leaf = leaves.covering(cell);
      inside = leaf != nullptr;
      if (leaf)
        ids.push_back(leaf->id);
    }
    if (inside)
      add_cell(cells, std::move(ids));
  }
  return cells;
}

/// Those of the library's cells all of whose vertices are leaves' centres: none on the domain's
/// boundary, none of a leaf that was split.
Cells cells_among_centres(AmrMesh& mesh, const amr::DualMesh& dual, const Leaves& leaves) {
  std::map<std::tuple<double, double, double>, std::uint32_t> centres;
  for (const Leaf& leaf : leaves.all()) {
    double at[3];
    for (int a = 0; a < 3; ++a)
      at[a] = mesh.lattice.centre(a, leaf.depth, leaf.index[std::size_t(a)]);
    centres[{at[0], at[1], at[2]}] = leaf.id;
  }
  Cells cells;
  const mesh::MeshView& view = dual.view();
  for (std::int32_t p = 0; p < view.piece_count; ++p) {
    const mesh::PieceView& piece = view.pieces[p];
    for (std::int64_t c = 0; c < piece.cell_count; ++c) {
      if (!piece.owns(c))
        continue;
      std::int64_t vertices[8];
      const int n = piece.vertex_ids(c, vertices);
      Ids ids;
      bool among = true;
      for (int v = 0; among && v < n; ++v) {
        const math::Vec3d x = piece.point(vertices[v]);
        const auto found = centres.find({x.x, x.y, x.z});
        among = found != centres.end();
        if (among)
          ids.push_back(found->second);
      }
      if (among)
        add_cell(cells, std::move(ids));
    }
  }
  return cells;
}

/// The first cell that is not found as often among the others, by its leaves; empty: none.
std::string missing(const Cells& cells, const Cells& among) {
  for (const auto& [ids, count] : cells) {
    const auto found = among.find(ids);
    if (found != among.end() && found->second == count)
      continue;
    std::string text = std::to_string(count) + " cells of leaves";
    for (const std::uint32_t id : ids)
      text += " " + std::to_string(id);
    return text + ", " + std::to_string(found == among.end() ? 0 : found->second) + " found";
  }
  return {};
}

/// Returns how many leaves were split; then cells of these are others.
std::int64_t compare(const Recipe& recipe, std::size_t& compared) {
  AmrMesh mesh = make_mesh(recipe);
  core::Memory memory;
  amr::DualMesh dual(memory);
  dual.build(mesh.view(), core::Threads(2));
  const Leaves leaves(mesh);
  const Cells expected = plain_dual(leaves), found = cells_among_centres(mesh, dual, leaves);
  EXPECT_EQ(missing(found, expected), "") << recipe.name();
  if (dual.counts().repaired == 0) {
    EXPECT_EQ(missing(expected, found), "") << recipe.name();
  }
  compared += found.size();
  return dual.counts().repaired;
}

TEST(PlainDual, OctreesAndPatches) {
  std::size_t compared = 0;
  int whole = 0;
  for (const int kind : {0, 1, 2, 3, 4, 6})
    for (int levels = 2; levels <= (kind == 2 ? 3 : 4); ++levels) // ratio 4 makes many leaves
      for (std::uint64_t seed = 1; seed <= 8; ++seed)
        whole += compare({.seed = seed, .kind = kind, .roots = 3, .levels = levels}, compared) == 0;
  EXPECT_GT(whole, 40); // all of their cells are the same
  EXPECT_GT(compared, 20000u);
}

TEST(PlainDual, LevelDifferencesUpToSix) {
  std::size_t compared = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    compare({.seed = seed, .kind = 5, .roots = 2, .levels = 7}, compared);
  EXPECT_GT(compared, 500u);
}

} // namespace
} // namespace insitu::test
