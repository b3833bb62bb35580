#pragma once

#include <cstdint>

/// Where the rays of a screen tile meet a level of a field within parts of cells; compiled per SIMD
/// target and dispatched at run time.
///
/// A patch is a cell, or an eighth of one, and so on: eight corners of a unit cube in view space
/// (render/camera/view_space.h), each with the field's value there relative to the level. A ray
/// through the image place (i, j) meets the level in the patch where
///
///     x(r, s, u) - i w(r, s, u) = 0,  y(r, s, u) - j w(r, s, u) = 0,  f(r, s, u) = 0,
///
/// w being z, or 1 for orthographic cameras: three trilinear equations, solved by Newton's method
/// for all pixels that the patch covers. They are multiplied by the inverse of their derivatives in
/// the middle of patch and pixels first. If the derivatives of the product then differ from those
/// of the identity by at most e < 1 in each row, over the whole patch and for all these pixels, a
/// ray meets the level once at most (the mean value theorem over a convex set), and a step by the
/// product alone brings any point of the patch nearer to where that is by a factor of e. So the
/// distance is bounded from a single residual, and what is decided is proven but for rounding.
namespace insitu::render {

/// Pixels of a tile, in blocks of 4 x 4.
struct TileRange {
  static constexpr int side = 64, pixels = side * side;
  int x0, y0, x1, y1;   ///< in the image; the last ones are within
  double column0, row0; ///< image place of the first pixel's centre
  /// [pixels] depths behind which nothing counts, in the order of index().
  const float* farthest;

  /// x and y in the tile.
  static int index(int x, int y) {
    return (((y >> 2) * (side / 4) + (x >> 2)) << 4) + ((y & 3) << 2) + (x & 3);
  }
  static int x_of(int index) { return ((index >> 4) % (side / 4)) * 4 + (index & 3); }
  static int y_of(int index) { return ((index >> 4) / (side / 4)) * 4 + ((index >> 2) & 3); }
};

/// What part of the unit cube a cell is: all of it (hexahedra, pyramids whose upper corners are
/// one), r + s <= 1 (wedges), r + s + u <= 1 (tetrahedra, which are linear).
enum class PatchDomain : std::uint8_t { cube, prism, simplex };

/// Up to eight patches of one domain. Corner c has r = c & 1, s = c >> 1 & 1, u = c >> 2.
struct Patches {
  static constexpr int most = 8;
  alignas(64) double x[8][most], y[8][most], z[8][most], f[8][most];
  /// The lower corner in the cell's parametric coordinates, and the side.
  alignas(64) double lower[3][most];
  double side = 1;
  PatchDomain domain = PatchDomain::cube;
  int count = 0;
};

/// Patches made ready: pixels, proofs, and the products' coefficients.
struct PatchSetup {
  static constexpr int most = Patches::most;
  /// Pixels of the tile that a patch may cover; x0 > x1: none, or the level is not in it.
  std::int32_t x0[most], y0[most], x1[most], y1[most];
  alignas(64) double nearest[most]; ///< least depth
  alignas(64) double error[most];   ///< e; 1e30 where there is no bound
  alignas(64) double noise[most];   ///< what rounding may make of parametric coordinates
  alignas(64) double size[most];    ///< of the terms of the products, for the rounding of floats
  alignas(64) double column[most], row[most]; ///< middle of the pixels, from the tile's first one
  // Coefficients of 1, r, s, u, rs, su, ru, rsu.
  alignas(64) double product[3][8][most]; ///< at the middle pixel
  alignas(64) double w[8][most], depth[8][most];
  /// The product loses (columns from the middle) across w + (rows from the middle) along w.
  alignas(64) double across[3][most], along[3][most];
};

/// What is found of a patch. Pixels are TileRange::index.
struct PatchHits {
  static constexpr int most = TileRange::pixels + 16;
  int count = 0, unsure = 0;
  std::int32_t pixel[most]; ///< hits
  double depth[most];
  double parametric[3][most];      ///< in the cell
  std::int32_t unsure_pixel[most]; ///< where a search by the ray must decide
};

/// A patch with a larger e is split, and so is one where rounding makes more of parametric
/// coordinates in double, or whose terms are larger than floats bear.
constexpr double most_error = 0.45, most_noise = 1e-5, most_size = 1e4;
/// So often.
constexpr int most_splits = 5;
/// Whether a part of a cell, as patch p is, reaches into the cell: prisms and simplices are parts
/// of the cube.
inline bool is_in_domain(const Patches& patches, int p) {
  if (patches.domain == PatchDomain::cube)
    return true;
  const double sum = patches.lower[0][p] + patches.lower[1][p];
  return sum + (patches.domain == PatchDomain::simplex ? patches.lower[2][p] : 0.0) < 1.0;
}

/// What is found of patches that have a ray each, through the image place (0, 0); a bit a patch.
struct PatchRoots {
  unsigned hit = 0, unsure = 0; ///< neither: missed
  unsigned unproven = 0;        ///< the error is larger than most_error: to be split
  alignas(64) double depth[Patches::most];
  alignas(64) double parametric[3][Patches::most]; ///< in the cell
};

void set_up(const Patches& patches, const TileRange& tile, bool orthographic, PatchSetup& setup);
/// The eight parts of patch p.
void split(const Patches& patches, int p, Patches& parts);
/// Whether one of the patch's pixels may show it.
bool is_visible(const PatchSetup& setup, int p, const TileRange& tile);
/// Appends the hits of patch p, whose error is at most most_error, and the pixels that it cannot
/// tell.
void solve(const Patches& patches, const PatchSetup& setup, int p, const TileRange& tile,
           bool orthographic, PatchHits& hits);
/// Solves all patches for their own rays. They are set up as orthographic, for ray_tile().
PatchRoots solve_rays(const Patches& patches, const PatchSetup& setup);
/// A tile of the one pixel at the image place (0, 0).
inline TileRange ray_tile() {
  return {0, 0, 0, 0, 0.0, 0.0, nullptr};
}
/// Appends the pixels whose rays may pass through patch p to the unsure ones.
void mark_unsure(const Patches& patches, const PatchSetup& setup, int p, const TileRange& tile,
                 bool orthographic, PatchHits& hits);

} // namespace insitu::render
