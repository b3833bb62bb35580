#include <algorithm>
#include <cmath>

#include "render/surface/tiles/patches.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/surface/tiles/patch_solve.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/surface/tiles/patch_lanes_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::render::HWY_NAMESPACE {

/// What a residual of floats may be off, in parametric coordinates, of the size of its terms.
constexpr float float_slack = 0x1p-20f;
/// The three products of a patch for rays in the lanes.
template <class D, bool orthographic, bool linear>
struct System {
  using L = Lanes<D>;
  Trilinear<D, linear> product[3], w;
  typename L::Real across[3], along[3];

  HWY_INLINE System(const PatchSetup& s, int p) {
    for (int a = 0; a < 3; ++a) {
      product[a].load(s.product[a], p);
      across[a] = typename L::Real(s.across[a][p]);
      along[a] = typename L::Real(s.along[a][p]);
    }
    w.load(s.w, p);
  }
  /// A pixel's own part of the products.
  HWY_INLINE void turn(L column, L row, L (&t)[3]) const {
    for (int a = 0; a < 3; ++a)
      t[a] = mul_add(L(across[a]), column, L(along[a]) * row);
  }
  HWY_INLINE L w_at(const L (&r)[3]) const {
    if constexpr (orthographic)
      return L(typename L::Real(1));
    return w.at(r);
  }
  HWY_INLINE void residual(const L (&t)[3], const L (&r)[3], L (&g)[3]) const {
    const L depth = w_at(r);
    for (int a = 0; a < 3; ++a)
      g[a] = sub_mul(product[a].at(r), t[a], depth);
  }
  /// The step of Newton's method, to be taken away.
  HWY_INLINE void step(const L (&t)[3], const L (&r)[3], L (&out)[3]) const {
    L slope[3][3], g[3], w_slope[3];
    const L depth = orthographic ? L(typename L::Real(1)) : w.at(r, w_slope);
    for (int a = 0; a < 3; ++a) {
      g[a] = sub_mul(product[a].at(r, slope[a]), t[a], depth);
      if constexpr (!orthographic)
        for (int b = 0; b < 3; ++b)
          slope[a][b] = sub_mul(slope[a][b], t[a], w_slope[b]);
    }
    newton_step(slope, g, out);
  }
};

/// Pixels whose floats are near a hit, until there are enough for a vector of doubles.
struct Waiting {
  static constexpr int most = 16 + 8;
  int count = 0;
  alignas(64) std::int32_t pixel[most];
  alignas(64) float column[most], row[most], r[3][most];
};

template <bool orthographic, PatchDomain domain>
class PatchSolver {
  static constexpr bool linear = domain == PatchDomain::simplex;
  using F = Lanes<Floats>;
  using D = Lanes<Doubles>;

public:
  HWY_INLINE PatchSolver(const Patches& patches, const PatchSetup& s, int p, const TileRange& tile,
                         PatchHits& hits)
      : patches_(patches), s_(s), p_(p), tile_(tile), hits_(hits), floats_(s, p), doubles_(s, p) {
    if constexpr (orthographic)
      depth_.load(s.depth, p);
    else
      depth_.load(s.w, p);
    double extent = 0;
    for (int n = 0; n < 8; ++n) {
      float_depth_.k[n] = float(depth_.k[n]);
      extent += n > 0 ? std::fabs(depth_.k[n]) : 0.0;
    }
    depth_slack_ = 1e-4f * float(extent);
    const float e = float(s.error[p]);
    rounding_ = 1e-5f + float_slack * float(s.size[p]);
    guess_slack_ = 0.5f * e + rounding_;
    contraction_ = e / (1 - e);
    steps_ = linear || e < 0.02f ? 1 : e < 0.2f ? 2 : 3;
    face_slack_ = face_slack + s.noise[p];
  }

  HWY_INLINE void run() {
    const int last = s_.x1[p_] >> 2;
    for (int y = s_.y0[p_] >> 2; y <= s_.y1[p_] >> 2; ++y)
      for (int x = s_.x0[p_] >> 2; x <= last; ++x)
        block(x, y);
    if (waiting_.count > 0)
      polish();
  }

private:
  HWY_INLINE void block(int bx, int by) {
    const Floats d;
    const hn::RebindToSigned<Floats> di;
    constexpr int lanes = int(hn::MaxLanes(d));
    alignas(64) static constexpr float x_in_block[16] = {0, 1, 2, 3, 0, 1, 2, 3,
                                                         0, 1, 2, 3, 0, 1, 2, 3};
    alignas(64) static constexpr float y_in_block[16] = {0, 0, 0, 0, 1, 1, 1, 1,
                                                         2, 2, 2, 2, 3, 3, 3, 3};
    const int first = (by * (TileRange::side / 4) + bx) << 4;
    const F left(float(4 * bx)), top(float(4 * by));
    const F middle_x(float(s_.column[p_])), middle_y(float(s_.row[p_]));
    for (int i = 0; i < 16; i += lanes) {
      const F far(hn::LoadU(d, tile_.farthest + first + i));
      auto open = hn::Ge(far.v, hn::Set(d, float(s_.nearest[p_])));
      if (hn::AllFalse(d, open))
        continue;
      const F column = F(hn::LoadU(d, x_in_block + i)) + left - middle_x;
      const F row = F(hn::LoadU(d, y_in_block + i)) + top - middle_y;
      open = hn::And(open, inside(column, s_.x0[p_], s_.x1[p_], middle_x));
      open = hn::And(open, inside(row, s_.y0[p_], s_.y1[p_], middle_y));
      F t[3], r[3], g[3];
      floats_.turn(column, row, t);
      for (F& q : r)
        q = F(0.5f);
      floats_.residual(t, r, g);
      for (int a = 0; a < 3; ++a)
        r[a] = r[a] - g[a];
      open = hn::And(open, hn::Ge(cube_margin(r).v, hn::Set(d, -guess_slack_)));
      if (hn::AllFalse(d, open))
        continue;
      for (int k = 0; k < steps_; ++k) {
        floats_.step(t, r, g);
        for (int a = 0; a < 3; ++a)
          r[a] = (r[a] - g[a]).within(float(-reach), float(1 + reach));
      }
      // From here a step by the product is a proof: where a hit is, it is as near to that.
      floats_.residual(t, r, g);
      F distance(0.0f);
      for (int a = 0; a < 3; ++a) {
        distance = greatest(distance, size(g[a]));
        r[a] = r[a] - g[a];
      }
      const F slack = mul_add(F(contraction_), distance, F(rounding_));
      open = hn::AndNot(hn::Lt((cube_margin(r) + slack).v, hn::Zero(d)), open);
      if constexpr (domain != PatchDomain::cube) {
        F lower[3];
        for (int a = 0; a < 3; ++a)
          lower[a] = F(float(patches_.lower[a][p_]));
        const F margin = slant_margin<F, domain>(r, lower, F(float(patches_.side)));
        open = hn::AndNot(hn::Lt(mul_add(F(3.0f), slack, margin).v, hn::Zero(d)), open);
      }
      const F depth = float_depth_.at(r);
      const F nearest = depth - mul_add(size(depth), F(1e-6f), F(depth_slack_));
      open = hn::AndNot(hn::And(hn::Gt(nearest.v, far.v), hn::Lt(distance.v, hn::Set(d, 1e-5f))),
                        open);
      if (hn::AllFalse(d, open))
        continue;
      const int at = waiting_.count;
      waiting_.count += int(hn::CompressStore(column.v, open, d, waiting_.column + at));
      hn::CompressStore(row.v, open, d, waiting_.row + at);
      for (int a = 0; a < 3; ++a)
        hn::CompressStore(r[a].v, open, d, waiting_.r[a] + at);
      hn::CompressStore(hn::Iota(di, first + i), hn::RebindMask(di, open), di, waiting_.pixel + at);
      while (waiting_.count >= int(hn::MaxLanes(Doubles())))
        polish();
    }
  }

  HWY_INLINE hn::Mask<Floats> inside(F at, std::int32_t first, std::int32_t last, F middle) const {
    const F from = F(float(first) - 0.25f) - middle, to = F(float(last) + 0.25f) - middle;
    return hn::And(hn::Ge(at.v, from.v), hn::Le(at.v, to.v));
  }

  /// Settles the last pixels that wait, a vector of doubles.
  HWY_INLINE void polish() {
    const Doubles d;
    const hn::Rebind<float, Doubles> df;
    constexpr int lanes = int(hn::MaxLanes(d));
    const int n = std::min(waiting_.count, lanes), from = waiting_.count - n;
    waiting_.count = from;
    const auto load = [&](const float* row)
                          HWY_ATTR { return D(hn::PromoteTo(d, hn::LoadU(df, row + from))); };
    D r[3] = {load(waiting_.r[0]), load(waiting_.r[1]), load(waiting_.r[2])};
    D t[3], g[3];
    doubles_.turn(load(waiting_.column), load(waiting_.row), t);
    const auto idle = hn::Not(hn::FirstN(d, std::size_t(n)));
    auto done = idle; // which keep what they are: a pixel's hit does not hang on the others
    D last(0.0);
    for (int k = 0; k < 2; ++k) {
      doubles_.step(t, r, g);
      D sum(0.0);
      for (int a = 0; a < 3; ++a) {
        sum = sum + size(g[a]); // and not the largest, which forgets what is not a number
        r[a] = D(hn::IfThenElse(done, r[a].v, (r[a] - g[a]).v));
      }
      last = D(hn::IfThenElse(done, last.v, sum.v));
      done = hn::Or(hn::Lt(last.v, hn::Set(d, small_step)), idle);
      if (linear || hn::AllTrue(d, done))
        break;
    }
    D lower[3];
    for (int a = 0; a < 3; ++a)
      lower[a] = D(patches_.lower[a][p_]);
    const D side(patches_.side);
    D margin = cube_margin(r);
    if constexpr (domain != PatchDomain::cube)
      margin = least(margin, slant_margin<D, domain>(r, lower, side));
    const auto settled = linear ? hn::Eq(last.v, last.v) : hn::Lt(last.v, hn::Set(d, small_step));
    const auto in = hn::And(settled, hn::Gt(margin.v, hn::Set(d, face_slack_)));
    const auto out = hn::And(settled, hn::Lt(margin.v, hn::Set(d, -face_slack_)));
    const unsigned hit = bits(in, n), unsure = bits(hn::Not(hn::Or(in, out)), n);
    if (hit == 0 && unsure == 0)
      return;
    alignas(64) double place[3][lanes], depth[lanes];
    hn::Store(depth_.at(r).v, d, depth);
    for (int a = 0; a < 3; ++a)
      hn::Store(mul_add(side, r[a], lower[a]).v, d, place[a]);
    for (int k = 0; k < n; ++k) {
      const std::int32_t pixel = waiting_.pixel[from + k];
      if (unsure >> k & 1)
        hits_.unsure_pixel[hits_.unsure++] = pixel;
      if (!(hit >> k & 1))
        continue;
      const int at = hits_.count++;
      hits_.pixel[at] = pixel;
      hits_.depth[at] = depth[k];
      for (int a = 0; a < 3; ++a)
        hits_.parametric[a][at] = place[a][k];
    }
  }

  static HWY_INLINE unsigned bits(hn::Mask<Doubles> mask, int n) {
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(Doubles(), mask, byte);
    return byte[0] & ((1u << n) - 1);
  }

  const Patches& patches_;
  const PatchSetup& s_;
  const int p_;
  const TileRange& tile_;
  PatchHits& hits_;
  System<Floats, orthographic, linear> floats_;
  System<Doubles, orthographic, linear> doubles_;
  Trilinear<Doubles, linear> depth_;
  Trilinear<Floats, linear> float_depth_;
  float guess_slack_, rounding_, contraction_, depth_slack_;
  double face_slack_;
  int steps_;
  Waiting waiting_;
};

template <bool orthographic>
HWY_INLINE void solve_in_domain(const Patches& patches, const PatchSetup& setup, int p,
                                const TileRange& tile, PatchHits& hits) {
  switch (patches.domain) {
  case PatchDomain::cube:
    return PatchSolver<orthographic, PatchDomain::cube>(patches, setup, p, tile, hits).run();
  case PatchDomain::prism:
    return PatchSolver<orthographic, PatchDomain::prism>(patches, setup, p, tile, hits).run();
  case PatchDomain::simplex:
    return PatchSolver<orthographic, PatchDomain::simplex>(patches, setup, p, tile, hits).run();
  }
}

void solve_target(const Patches& patches, const PatchSetup& setup, int p, const TileRange& tile,
                  bool orthographic, PatchHits& hits) {
  if (orthographic)
    solve_in_domain<true>(patches, setup, p, tile, hits);
  else
    solve_in_domain<false>(patches, setup, p, tile, hits);
}

bool is_visible_target(const PatchSetup& s, int p, const TileRange& tile) {
  const Floats d;
  constexpr int lanes = int(hn::MaxLanes(d));
  const auto nearest = hn::Set(d, float(s.nearest[p]));
  for (int y = s.y0[p] >> 2; y <= s.y1[p] >> 2; ++y)
    for (int x = s.x0[p] >> 2; x <= s.x1[p] >> 2; ++x)
      for (int i = 0; i < 16; i += lanes) {
        const float* const far = tile.farthest + ((y * (TileRange::side / 4) + x) << 4) + i;
        if (!hn::AllFalse(d, hn::Ge(hn::LoadU(d, far), nearest)))
          return true;
      }
  return false;
}

} // namespace insitu::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::render {

HWY_EXPORT(solve_target);
HWY_EXPORT(is_visible_target);

void solve(const Patches& patches, const PatchSetup& setup, int p, const TileRange& tile,
           bool orthographic, PatchHits& hits) {
  HWY_DYNAMIC_DISPATCH(solve_target)(patches, setup, p, tile, orthographic, hits);
}

bool is_visible(const PatchSetup& setup, int p, const TileRange& tile) {
  return HWY_DYNAMIC_DISPATCH(is_visible_target)(setup, p, tile);
}

} // namespace insitu::render
#endif
