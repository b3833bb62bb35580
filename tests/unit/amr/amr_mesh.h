// Small adaptive meshes: by hand, random octrees, random layouts of patches.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/random.h"
#include "mesh/adaptive.h"

namespace insitu::test {

using Index = std::array<std::int64_t, 3>;

struct AmrPiece {
  bool is_patch = true;
  int level = 0;
  Index lower{}, size{};
  std::uint8_t ghost_faces = 0;
  std::vector<std::int32_t> levels; ///< leaves
  std::vector<Index> corners;
  std::int64_t cell_count() const {
    return is_patch ? size[0] * size[1] * size[2] : std::int64_t(levels.size());
  }
};

/// Owns what an AmrView refers to.
class AmrMesh {
public:
  mesh::Lattice lattice{{0.3, -1.7, 2.1}, {0.7, 1.1, 0.9}};
  std::vector<int> depth_of{0}; ///< of level
  std::vector<AmrPiece> pieces;

  void add_patch(int level, Index lower, Index size);
  void add_leaf(int level, Index corner); ///< to the last piece, if it is one of leaves
  /// Makes a patch of every leaf, and gives all patches ghost cells.
  void give_ghosts();
  const mesh::AmrView& view();

private:
  std::vector<mesh::AmrPieceView> views_;
  std::vector<std::int64_t> first_;
  mesh::AmrView view_;
};

struct Leaf {
  int depth = 0;
  Index index{};
  std::uint32_t id = 0;
};
/// Every cell; those under finer ones left out, by a plain loop.
std::vector<Leaf> leaves_of(AmrMesh& mesh);

/// One of the random meshes.
struct Recipe {
  std::uint64_t seed = 1;
  int kind = 0; ///< 0: octree, 1: patches of ratio 2, 2: of 4 and 2, 3: with holes, 4: side by side
                ///< in other heights, 5: octrees refined towards some points,
                ///< 6: octrees with leaves left out
  int roots = 2; ///< at most, along an axis
  int levels = 3;
  bool far = false; ///< 6.4e6 from the coordinates' zero, cells 10,000 times as wide as high
  std::string name() const;
};
AmrMesh make_mesh(const Recipe& recipe);
/// Whether the domain is a box.
bool is_box(const Recipe& recipe);

} // namespace insitu::test
