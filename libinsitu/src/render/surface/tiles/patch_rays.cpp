#include <algorithm>
#include <cmath>

#include "render/surface/tiles/patches.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/surface/tiles/patch_rays.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/surface/tiles/patch_lanes_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::render::HWY_NAMESPACE {

/// The three products of a pack of patches, each for its own ray.
template <bool linear>
struct RaySystem {
  using L = Lanes<Doubles>;
  const PatchSetup& s;
  int i;

  HWY_INLINE L value(const double (&rows)[8][Patches::most], const L (&r)[3], L (&slope)[3]) const {
    return evaluate<linear>([&](int n) HWY_ATTR { return L(hn::Load(Doubles(), rows[n] + i)); }, r,
                            slope);
  }
  /// The products, and the step of Newton's method, to be taken away.
  HWY_INLINE void step(const L (&r)[3], L (&g)[3], L (&out)[3]) const {
    L slope[3][3];
    for (int a = 0; a < 3; ++a)
      g[a] = value(s.product[a], r, slope[a]);
    newton_step(slope, g, out);
  }
};

template <PatchDomain domain>
HWY_INLINE void solve_pack(const Patches& patches, const PatchSetup& s, int i, PatchRoots& roots) {
  using L = Lanes<Doubles>;
  const Doubles d;
  const RaySystem<domain == PatchDomain::simplex> system{s, i};
  const L error(hn::Load(d, s.error + i)), noise(hn::Load(d, s.noise + i)), one(1.0);
  const auto used = hn::FirstN(d, std::size_t(patches.count - i)); // of the others nothing is set
  const auto proven = hn::And(used, hn::And(hn::Le(error.v, hn::Set(d, most_error)),
                                            hn::Lt(noise.v, hn::Set(d, most_noise))));
  const L e = least(error, L(most_error)), contraction = e / (one - e);
  L r[3] = {L(0.5), L(0.5), L(0.5)}, g[3], step[3];
  system.step(r, g, step);
  for (int a = 0; a < 3; ++a)
    r[a] = r[a] - g[a];
  auto open = hn::Ge((cube_margin(r) + L(0.5) * e + L(1e-6)).v, hn::Zero(d));
  if (!hn::AllFalse(d, hn::And(open, proven)))
    for (int k = 0; k < 4; ++k) {
      system.step(r, g, step);
      for (int a = 0; a < 3; ++a)
        r[a] = (r[a] - step[a]).within(-reach, 1 + reach);
    }
  // From here a step by the product is a proof; see PatchSolver.
  system.step(r, g, step);
  L distance(0.0), last(0.0), near[3], lower[3];
  for (int a = 0; a < 3; ++a) {
    distance = greatest(distance, size(g[a]));
    last = last + size(step[a]);
    near[a] = r[a] - g[a];
    r[a] = r[a] - step[a];
    lower[a] = L(hn::Load(d, patches.lower[a] + i));
  }
  const L slack = mul_add(contraction, distance, noise + L(1e-9)), side(patches.side);
  L margin = cube_margin(r);
  open = hn::AndNot(hn::Lt((cube_margin(near) + slack).v, hn::Zero(d)), open);
  if constexpr (domain != PatchDomain::cube) {
    const L slant = slant_margin<L, domain>(near, lower, side);
    open = hn::AndNot(hn::Lt(mul_add(L(3.0), slack, slant).v, hn::Zero(d)), open);
    margin = least(margin, slant_margin<L, domain>(r, lower, side));
  }
  const L near_face = noise + L(face_slack);
  const auto settled = hn::Lt(last.v, hn::Set(d, small_step));
  const auto in = hn::And(settled, hn::Gt(margin.v, near_face.v));
  const auto out = hn::And(settled, hn::Lt(margin.v, hn::Neg(near_face.v)));
  const auto bits = [&](auto mask) HWY_ATTR {
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(d, mask, byte);
    return (unsigned(byte[0]) & ((1u << hn::MaxLanes(d)) - 1)) << i;
  };
  open = hn::And(open, proven);
  roots.hit |= bits(hn::And(open, in));
  roots.unsure |= bits(hn::AndNot(hn::Or(in, out), open));
  roots.unproven |= bits(hn::Not(proven));
  L slope[3];
  hn::Store(system.value(s.depth, r, slope).v, d, roots.depth + i);
  for (int a = 0; a < 3; ++a)
    hn::Store(mul_add(side, r[a], lower[a]).v, d, roots.parametric[a] + i);
}

void solve_rays_target(const Patches& patches, const PatchSetup& setup, PatchRoots& roots) {
  for (int i = 0; i < patches.count; i += int(hn::MaxLanes(Doubles())))
    switch (patches.domain) {
    case PatchDomain::cube:
      solve_pack<PatchDomain::cube>(patches, setup, i, roots);
      break;
    case PatchDomain::prism:
      solve_pack<PatchDomain::prism>(patches, setup, i, roots);
      break;
    case PatchDomain::simplex:
      solve_pack<PatchDomain::simplex>(patches, setup, i, roots);
      break;
    }
}

void mark_target(const Patches& patches, const PatchSetup& s, int p, const TileRange& tile,
                 bool orthographic, PatchHits& hits) {
  const Doubles d;
  constexpr int lanes = int(hn::MaxLanes(d));
  double size = 0;
  for (int c = 0; c < 8; ++c)
    size = std::max(
        {size, std::fabs(patches.x[c][p]), std::fabs(patches.y[c][p]), std::fabs(patches.z[c][p])});
  const auto slack = hn::Set(d, 0x1p-40 * size);
  for (int y = s.y0[p]; y <= s.y1[p]; ++y)
    for (int x = s.x0[p]; x <= s.x1[p]; x += lanes) {
      const auto column = hn::Add(hn::Iota(d, double(x)), hn::Set(d, tile.column0));
      const auto row = hn::Set(d, y + tile.row0);
      auto left = hn::Set(d, 1e300), right = hn::Neg(left), up = left, down = right;
      for (int c = 0; c < 8; ++c) {
        const auto w = hn::Set(d, orthographic ? 1.0 : patches.z[c][p]);
        const auto across = hn::NegMulAdd(column, w, hn::Set(d, patches.x[c][p]));
        const auto along = hn::NegMulAdd(row, w, hn::Set(d, patches.y[c][p]));
        left = hn::Min(left, across);
        right = hn::Max(right, across);
        up = hn::Min(up, along);
        down = hn::Max(down, along);
      }
      const auto meets = hn::And(hn::And(hn::Le(left, slack), hn::Ge(right, hn::Neg(slack))),
                                 hn::And(hn::Le(up, slack), hn::Ge(down, hn::Neg(slack))));
      std::uint8_t byte[8] = {};
      hn::StoreMaskBits(d, meets, byte);
      for (int k = 0; k < lanes && x + k <= s.x1[p]; ++k) {
        const int pixel = TileRange::index(x + k, y);
        if ((byte[0] >> k & 1) && tile.farthest[pixel] >= float(s.nearest[p]))
          hits.unsure_pixel[hits.unsure++] = pixel;
      }
    }
}

} // namespace insitu::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::render {

HWY_EXPORT(solve_rays_target);
HWY_EXPORT(mark_target);

PatchRoots solve_rays(const Patches& patches, const PatchSetup& setup) {
  PatchRoots roots;
  HWY_DYNAMIC_DISPATCH(solve_rays_target)(patches, setup, roots);
  unsigned seen = 0; // the others are beside the ray, or hold no level
  for (int p = 0; p < patches.count; ++p)
    seen |= unsigned(setup.x0[p] <= setup.x1[p] && setup.y0[p] <= setup.y1[p]) << p;
  roots.hit &= seen;
  roots.unsure &= seen;
  roots.unproven &= seen;
  return roots;
}

void mark_unsure(const Patches& patches, const PatchSetup& setup, int p, const TileRange& tile,
                 bool orthographic, PatchHits& hits) {
  HWY_DYNAMIC_DISPATCH(mark_target)(patches, setup, p, tile, orthographic, hits);
}

} // namespace insitu::render
#endif
