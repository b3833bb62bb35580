#include "amr_mesh.h"

#include <algorithm>
#include <set>
#include <tuple>

namespace insitu::test {

void AmrMesh::add_patch(int level, Index lower, Index size) {
  AmrPiece p;
  p.level = level;
  p.lower = lower;
  p.size = size;
  pieces.push_back(p);
}

void AmrMesh::add_leaf(int level, Index corner) {
  if (pieces.empty() || pieces.back().is_patch) {
    pieces.emplace_back();
    pieces.back().is_patch = false;
  }
  pieces.back().levels.push_back(level);
  pieces.back().corners.push_back(corner);
}

void AmrMesh::give_ghosts() {
  const std::vector<AmrPiece> before = std::move(pieces);
  pieces.clear();
  for (const AmrPiece& p : before) {
    if (p.is_patch)
      pieces.push_back(p);
    for (std::size_t c = 0; c < p.levels.size(); ++c)
      add_patch(p.levels[c], p.corners[c], {1, 1, 1});
  }
  for (AmrPiece& p : pieces)
    p.ghost_faces = 63;
}

const mesh::AmrView& AmrMesh::view() {
  views_.assign(pieces.size(), {});
  first_.assign(1, 0);
  view_ = {};
  for (std::size_t l = 0; l < depth_of.size(); ++l)
    view_.depth_of[l] = std::int8_t(depth_of[l]);
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const AmrPiece& from = pieces[p];
    mesh::AmrPieceView& to = views_[p];
    to.is_patch = from.is_patch;
    to.cell_count = from.cell_count();
    if (from.is_patch) {
      to.depth = depth_of[std::size_t(from.level)];
      to.ghost_faces = from.ghost_faces;
      for (std::size_t a = 0; a < 3; ++a) {
        to.lower[a] = from.lower[a];
        to.size[a] = from.size[a];
      }
    } else {
      to.levels = reinterpret_cast<const std::byte*>(from.levels.data());
      to.levels_stride = 4;
      for (std::size_t a = 0; a < 3; ++a)
        to.corner[a] = reinterpret_cast<const std::byte*>(from.corners.data()) + 8 * a;
      to.corner_stride = 24;
      to.corner_is_int32 = false;
    }
    first_.push_back(first_.back() + to.cell_count);
  }
  view_.lattice = lattice;
  view_.level_count = int(depth_of.size());
  view_.pieces = views_.data();
  view_.first_cell = first_.data();
  view_.piece_count = std::int32_t(pieces.size());
  return view_;
}

std::vector<Leaf> leaves_of(AmrMesh& mesh) {
  const mesh::AmrView& view = mesh.view();
  std::vector<Leaf> all;
  std::set<std::tuple<int, std::int64_t, std::int64_t, std::int64_t>> above;
  for (std::int32_t p = 0; p < view.piece_count; ++p)
    for (std::int64_t c = 0; c < view.pieces[p].cell_count; ++c) {
      const mesh::AmrCell at = view.cell(view.pieces[p], c);
      all.push_back({at.depth,
                     {at.index[0], at.index[1], at.index[2]},
                     std::uint32_t(view.first_cell[p] + c)});
      for (int u = 1; u <= at.depth; ++u)
        above.insert({at.depth - u, at.index[0] >> u, at.index[1] >> u, at.index[2] >> u});
    }
  std::erase_if(all, [&](const Leaf& l) {
    return above.contains({l.depth, l.index[0], l.index[1], l.index[2]});
  });
  return all;
}

std::string Recipe::name() const {
  return "seed " + std::to_string(seed) + ", kind " + std::to_string(kind) + ", roots " +
         std::to_string(roots) + ", levels " + std::to_string(levels) + (far ? ", far away" : "");
}

bool is_box(const Recipe& recipe) {
  return recipe.kind < 3 || recipe.kind == 5;
}

namespace {

class Random {
public:
  explicit Random(std::uint64_t seed) : seed_(seed) {}
  int below(int n) { return int(core::random_unit(seed_, item_++, 0) * n); }
  bool chance(double p) { return core::random_unit(seed_, item_++, 0) < p; }

private:
  std::uint64_t seed_, item_ = 0;
};

/// Refines where chance says, most eagerly near one corner of a cell, so that level differences
/// get large.
void octree(AmrMesh& mesh, Random& random, int level, int levels, Index at, double left_out = 0) {
  if (level + 1 == levels || !random.chance(level == 0 ? 0.7 : 0.35)) {
    if (!random.chance(left_out))
      mesh.add_leaf(level, at);
    return;
  }
  for (int o = 0; o < 8; ++o)
    octree(mesh, random, level + 1, levels,
           {2 * at[0] + (o & 1), 2 * at[1] + (o >> 1 & 1), 2 * at[2] + (o >> 2)}, left_out);
}

/// Refines the cells that touch one of some points, so that depths differ as much as they can.
void towards(AmrMesh& mesh, const std::vector<Index>& points, int level, int levels, Index at) {
  const int shift = levels - 1 - level;
  const bool touched = std::any_of(points.begin(), points.end(), [&](const Index& p) {
    bool in = true;
    for (std::size_t a = 0; a < 3; ++a)
      in &= p[a] >= at[a] << shift && p[a] <= (at[a] + 1) << shift;
    return in;
  });
  if (level + 1 == levels || !touched) {
    mesh.add_leaf(level, at);
    return;
  }
  for (int o = 0; o < 8; ++o)
    towards(mesh, points, level + 1, levels,
            {2 * at[0] + (o & 1), 2 * at[1] + (o >> 1 & 1), 2 * at[2] + (o >> 2)});
}

/// Blocks of `block` cells of a level, some of them refined, level by level; a coarse cell under
/// fine ones stays in its patch.
void refine_blocks(AmrMesh& mesh, Random& random, std::vector<std::pair<Index, Index>> boxes,
                   int levels, int keep_in) {
  for (int l = 0; l + 1 < levels; ++l) {
    const std::int64_t ratio =
        std::int64_t(1) << (mesh.depth_of[std::size_t(l + 1)] - mesh.depth_of[std::size_t(l)]);
    std::vector<std::pair<Index, Index>> finer;
    for (const auto& [lower, size] : boxes) {
      mesh.add_patch(l, lower, size);
      const std::int64_t block = 1 + random.below(3);
      Index at;
      for (at[2] = 0; at[2] < size[2]; at[2] += block)
        for (at[1] = 0; at[1] < size[1]; at[1] += block)
          for (at[0] = 0; at[0] < size[0]; at[0] += block) {
            if (random.below(keep_in) != 0)
              continue;
            Index lo, n;
            for (std::size_t a = 0; a < 3; ++a) {
              lo[a] = (lower[a] + at[a]) * ratio;
              n[a] = std::min(block, size[a] - at[a]) * ratio;
            }
            finer.push_back({lo, n});
          }
    }
    boxes = finer;
  }
  for (const auto& [lower, size] : boxes)
    mesh.add_patch(levels - 1, lower, size);
}

} // namespace

AmrMesh make_mesh(const Recipe& recipe) {
  AmrMesh mesh;
  if (recipe.far)
    mesh.lattice = {{6.4e6, -6.4e6, 6.4e6}, {1.0, 1.0, 1e-4}};
  Random random(recipe.seed);
  mesh.depth_of.clear();
  for (int l = 0, d = 0; l < recipe.levels; ++l) {
    mesh.depth_of.push_back(d);
    d += recipe.kind == 2 ? 2 - random.below(2) : 1;
  }
  Index n, shift;
  for (std::size_t a = 0; a < 3; ++a) {
    n[a] = 1 + random.below(recipe.roots);
    shift[a] = random.below(40) - 20;
  }
  if (recipe.kind == 5) { // points off the coarse lattices for the most part
    std::vector<Index> points(std::size_t(1 + random.below(2)));
    for (Index& p : points)
      for (std::size_t a = 0; a < 3; ++a)
        p[a] = (shift[a] << (recipe.levels - 1)) + random.below(int(n[a] << (recipe.levels - 1)));
    for (std::int64_t k = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i)
          towards(mesh, points, 0, recipe.levels, {shift[0] + i, shift[1] + j, shift[2] + k});
    return mesh;
  }
  if (recipe.kind == 0 || recipe.kind == 3 || recipe.kind == 6) {
    for (std::int64_t k = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i)
          if (recipe.kind != 3 || random.chance(0.7))
            octree(mesh, random, 0, recipe.levels, {shift[0] + i, shift[1] + j, shift[2] + k},
                   recipe.kind == 6 ? 0.3 : 0.0);
    return mesh;
  }
  // Patches side by side along x; of kind 4, each of a height of its own.
  std::vector<std::pair<Index, Index>> boxes;
  std::int64_t x = shift[0];
  for (int b = 0, count = 1 + random.below(3); b < count; ++b) {
    const std::int64_t wide = 1 + random.below(2 * recipe.roots);
    Index size = {wide, 2 * n[1], 2 * n[2]}, lower = {x, shift[1], shift[2]};
    if (recipe.kind == 4) {
      size[1] = 1 + random.below(2 * recipe.roots);
      lower[2] += random.below(2);
    }
    boxes.push_back({lower, size});
    x += wide;
  }
  refine_blocks(mesh, random, boxes, recipe.levels, 3);
  return mesh;
}

} // namespace insitu::test
