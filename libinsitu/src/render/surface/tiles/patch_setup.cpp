#include "render/surface/tiles/patches.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/surface/tiles/patch_setup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "cells/kernels/kernels_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::render::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace simd = cells::HWY_NAMESPACE;
using simd::Pack;
using simd::PackMask;

constexpr double no_bound = 1e30;
/// Pixels whose centres a patch misses by this part of a pixel still count.
constexpr double pixel_slack = 1e-6;

/// The corners of one number of a pack of patches.
struct Corners {
  Pack at[8];

  HWY_INLINE Corners() = default;
  HWY_INLINE Corners(const double (&rows)[8][Patches::most], int i) {
    for (int c = 0; c < 8; ++c)
      at[c] = simd::load_pack(rows[c] + i);
  }
  HWY_INLINE Pack least() const {
    Pack m = at[0];
    for (int c = 1; c < 8; ++c)
      m = smaller(at[c], m);
    return m;
  }
  HWY_INLINE Pack greatest() const {
    Pack m = at[0];
    for (int c = 1; c < 8; ++c)
      m = larger(at[c], m);
    return m;
  }
  /// The mean derivative along an axis.
  HWY_INLINE Pack slope(int axis) const {
    const int b = 1 << axis;
    Pack sum(0.0);
    for (int c = 0; c < 8; ++c)
      if (!(c & b))
        sum = sum + (at[c | b] - at[c]);
    return Pack(0.25) * sum;
  }
  HWY_INLINE void store_coefficients(double (&out)[8][Patches::most], int i) const {
    const simd::PackTag d;
    Pack k[8];
    k[0] = at[0];
    k[1] = at[1] - at[0];
    k[2] = at[2] - at[0];
    k[3] = at[4] - at[0];
    k[4] = at[3] - at[2] - k[1];
    k[5] = at[6] - at[4] - k[2];
    k[6] = at[5] - at[4] - k[1];
    k[7] = (at[7] - at[6]) - (at[5] - at[4]) - k[4];
    for (int n = 0; n < 8; ++n)
      hn::Store(k[n].v, d, out[n] + i);
  }
};

/// The pixels of a pack of patches, in doubles, from the tile's first one: from first to last.
struct Pixels {
  Pack first, last;
  /// low, high: image places.
  HWY_INLINE Pixels(const Pack& low, const Pack& high, double place0, int count) {
    const Pack slack(pixel_slack), end{double(count - 1)};
    first = larger(Pack(hn::Ceil((low - Pack(place0) - slack).v)), Pack(0.0));
    last = smaller(Pack(hn::Floor((high - Pack(place0) + slack).v)), end);
  }
  HWY_INLINE Pack middle() const { return Pack(0.5) * (first + last); }
  HWY_INLINE Pack half() const { return Pack(0.5) * (last - first); }
};

/// The inverse of a matrix whose columns are the derivatives along the axes.
struct Inverse {
  Pack at[3][3];
  HWY_INLINE explicit Inverse(const Pack (&m)[3][3]) {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3, b2 = (b + 2) % 3;
        at[b][a] = m[a1][b1] * m[a2][b2] - m[a1][b2] * m[a2][b1];
      }
    const Pack one = Pack(1.0) / (m[0][0] * at[0][0] + m[0][1] * at[1][0] + m[0][2] * at[2][0]);
    for (auto& row : at)
      for (Pack& e : row)
        e = e * one;
  }
};

/// The largest row sum of |d product / d(r, s, u) - identity| over the patch and its pixels;
/// no_bound where a number is none, as of a product by the inverse of a singular matrix.
HWY_INLINE Pack error_of(const Corners (&product)[3], const Corners& w, const Pack (&turn)[3]) {
  Pack most(0.0), all(0.0); // a largest one forgets what is not a number, a sum does not
  Pack w_slope[3][4];
  for (int axis = 0; axis < 3; ++axis)
    for (int c = 0, n = 0; c < 8; ++c)
      if (const int b = 1 << axis; !(c & b))
        w_slope[axis][n++] = absolute(w.at[c | b] - w.at[c]);
  for (int a = 0; a < 3; ++a) {
    Pack row(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      const int b = 1 << axis;
      Pack worst(0.0);
      for (int c = 0, n = 0; c < 8; ++c)
        if (!(c & b)) {
          const Pack slope = product[a].at[c | b] - product[a].at[c];
          const Pack off = absolute(slope - Pack(axis == a ? 1.0 : 0.0));
          worst = larger(mul_add(turn[a], w_slope[axis][n++], off), worst);
          all = all + off;
        }
      row = row + worst;
    }
    most = larger(row, most);
    all = all + turn[a];
  }
  return select(all < Pack(no_bound), most, Pack(no_bound));
}

/// Masks of patches that lie beside the tile as a whole, for patches that reach behind the eye.
HWY_INLINE PackMask is_beside(const Corners& x, const Corners& w, double low, double high) {
  PackMask left = x.at[0]<Pack(low) * w.at[0], right = x.at[0]> Pack(high) * w.at[0];
  for (int c = 1; c < 8; ++c) {
    left = left & (x.at[c] < Pack(low) * w.at[c]);
    right = right & (x.at[c] > Pack(high) * w.at[c]);
  }
  return left | right;
}

HWY_INLINE void store_pixels(const Pixels& columns, const Pixels& rows, const PackMask& none, int i,
                             PatchSetup& s) {
  const simd::PackTag d;
  const hn::Rebind<std::int32_t, simd::PackTag> di;
  // A patch without pixels has its first one behind its last.
  const Pack first = select(none, Pack(1.0), columns.first);
  const Pack last = select(none, Pack(0.0), columns.last);
  const auto put = [&](const Pack& p, std::int32_t* to) HWY_ATTR {
    const Pack within = smaller(larger(p, Pack(-1.0)), Pack(double(TileRange::side)));
    hn::StoreU(hn::DemoteTo(di, within.v), di, to + i);
  };
  put(first, s.x0);
  put(last, s.x1);
  put(rows.first, s.y0);
  put(rows.last, s.y1);
  hn::Store(columns.middle().v, d, s.column + i);
  hn::Store(rows.middle().v, d, s.row + i);
}

template <bool orthographic>
HWY_INLINE void set_up_pack(const Patches& p, const TileRange& tile, int i, PatchSetup& s) {
  const simd::PackTag d;
  const int width = tile.x1 - tile.x0 + 1, height = tile.y1 - tile.y0 + 1;
  Corners x(p.x, i), y(p.y, i), z(p.z, i), f(p.f, i), w;
  for (int c = 0; c < 8; ++c)
    w.at[c] = orthographic ? Pack(1.0) : z.at[c];
  const Pack near = z.least(), far = z.greatest(), low = f.least(), high = f.greatest();
  hn::Store(near.v, d, s.nearest + i);
  // Where the patch is seen.
  Corners column = x, row = y;
  PackMask crosses = far < near; // none
  PackMask none = (low > Pack(0.0)) | (high < Pack(0.0)) | !(far > Pack(0.0));
  if constexpr (!orthographic) {
    crosses = !(near > Pack(0.0));
    for (int c = 0; c < 8; ++c) {
      const Pack inverse = Pack(1.0) / z.at[c];
      column.at[c] = x.at[c] * inverse;
      row.at[c] = y.at[c] * inverse;
    }
    if (!all_of(!crosses))
      none = none | (crosses & (is_beside(x, w, tile.column0 - 0.5, tile.column0 + width - 0.5) |
                                is_beside(y, w, tile.row0 - 0.5, tile.row0 + height - 0.5)));
  }
  const auto place = [&](const Pack& seen, double all)
                         HWY_ATTR { return select(crosses, Pack(all), seen); };
  const Pixels columns(place(column.least(), tile.column0),
                       place(column.greatest(), tile.column0 + width), tile.column0, width);
  const Pixels rows(place(row.least(), tile.row0), place(row.greatest(), tile.row0 + height),
                    tile.row0, height);
  store_pixels(columns, rows, none, i, s);
  // The equations at the middle pixel. The field is scaled: its values may be as small as can be.
  const Pack x_size = larger(absolute(x.least()), absolute(x.greatest()));
  const Pack y_size = larger(absolute(y.least()), absolute(y.greatest()));
  const Pack middle_x = columns.middle() + Pack(tile.column0);
  const Pack middle_y = rows.middle() + Pack(tile.row0);
  const Pack scale = Pack(1.0) / larger(absolute(low), absolute(high));
  for (int c = 0; c < 8; ++c) {
    x.at[c] = x.at[c] - middle_x * w.at[c];
    y.at[c] = y.at[c] - middle_y * w.at[c];
    f.at[c] = f.at[c] * scale;
  }
  Pack m[3][3];
  for (int axis = 0; axis < 3; ++axis) {
    m[0][axis] = x.slope(axis);
    m[1][axis] = y.slope(axis);
    m[2][axis] = f.slope(axis);
  }
  const Inverse inverse(m);
  Corners product[3];
  const Pack w_size = larger(absolute(w.least()), absolute(w.greatest()));
  Pack turn[3], noise(0.0), size(1.0);
  for (int a = 0; a < 3; ++a) {
    const auto& by = inverse.at[a];
    for (int c = 0; c < 8; ++c)
      product[a].at[c] = mul_add(by[0], x.at[c], mul_add(by[1], y.at[c], by[2] * f.at[c]));
    turn[a] = absolute(by[0]) * columns.half() + absolute(by[1]) * rows.half();
    noise = larger(absolute(by[0]) * x_size + absolute(by[1]) * y_size + absolute(by[2]), noise);
    size = larger(absolute(product[a].at[0]) + turn[a] * w_size, size);
    product[a].store_coefficients(s.product[a], i);
    hn::Store(by[0].v, d, s.across[a] + i);
    hn::Store(by[1].v, d, s.along[a] + i);
  }
  const Pack error = error_of(product, w, turn);
  hn::Store(select(crosses, Pack(no_bound), error).v, d, s.error + i);
  noise = Pack(0x1p-46) * noise;
  hn::Store(select(noise < Pack(no_bound), noise, Pack(no_bound)).v, d, s.noise + i);
  hn::Store(select(size < Pack(no_bound), size, Pack(no_bound)).v, d, s.size + i);
  w.store_coefficients(s.w, i);
  if constexpr (orthographic)
    z.store_coefficients(s.depth, i);
}

void set_up_target(const Patches& patches, const TileRange& tile, bool orthographic,
                   PatchSetup& setup) {
  constexpr int lanes = int(hn::MaxLanes(simd::PackTag()));
  for (int i = 0; i < patches.count; i += lanes)
    if (orthographic)
      set_up_pack<true>(patches, tile, i, setup);
    else
      set_up_pack<false>(patches, tile, i, setup);
}

void split_target(const Patches& patches, int p, Patches& parts) {
  parts.count = 8;
  parts.domain = patches.domain;
  parts.side = 0.5 * patches.side;
  for (int k = 0; k < 8; ++k)
    for (int a = 0; a < 3; ++a)
      parts.lower[a][k] = patches.lower[a][p] + ((k >> a) & 1 ? parts.side : 0.0);
  const auto halve = [&](const double(&from)[8][Patches::most],
                         double(&to)[8][Patches::most]) HWY_ATTR {
    double grid[27]; // i + 3 (j + 3 k)
    for (int c = 0; c < 8; ++c)
      grid[(c & 1) * 2 + (c >> 1 & 1) * 6 + (c >> 2) * 18] = from[c][p];
    const auto middle = [&](int at, int step) { return 0.5 * (grid[at - step] + grid[at + step]); };
    for (int k = 0; k < 3; k += 2)
      for (int j = 0; j < 3; j += 2)
        grid[1 + 3 * j + 9 * k] = middle(1 + 3 * j + 9 * k, 1);
    for (int k = 0; k < 3; k += 2)
      for (int i = 0; i < 3; ++i)
        grid[i + 3 + 9 * k] = middle(i + 3 + 9 * k, 3);
    for (int n = 9; n < 18; ++n)
      grid[n] = middle(n, 9);
    for (int c = 0; c < 8; ++c)
      for (int k = 0; k < 8; ++k)
        to[c][k] =
            grid[(c & 1) + (k & 1) + 3 * ((c >> 1 & 1) + (k >> 1 & 1)) + 9 * ((c >> 2) + (k >> 2))];
  };
  halve(patches.x, parts.x);
  halve(patches.y, parts.y);
  halve(patches.z, parts.z);
  halve(patches.f, parts.f);
}

} // namespace insitu::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::render {

HWY_EXPORT(set_up_target);
HWY_EXPORT(split_target);

void set_up(const Patches& patches, const TileRange& tile, bool orthographic, PatchSetup& setup) {
  HWY_DYNAMIC_DISPATCH(set_up_target)(patches, tile, orthographic, setup);
}

void split(const Patches& patches, int p, Patches& parts) {
  HWY_DYNAMIC_DISPATCH(split_target)(patches, p, parts);
}

} // namespace insitu::render
#endif
