#include "query/batch/query_boxes.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/batch/query_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32

/// BoxRule::box with x, y, z in one register.
void set_boxes_target(const BoxRule& rule, std::span<const math::Vec3d> points, QueryBoxes& boxes) {
  const hn::FixedTag<double, 4> d;
  const hn::FixedTag<float, 4> df;
  const auto xyz = hn::FirstN(d, 3);
  const auto round_up = [&](hn::Vec<decltype(d)> x) HWY_ATTR {
    const auto f = hn::DemoteTo(df, x);
    const auto step = hn::Mul(hn::Abs(f), hn::Set(df, 0x1p-22f));
    return hn::Add(hn::Add(f, step), hn::Set(df, 0x1p-120f));
  };
  const auto origin = hn::MaskedLoad(xyz, d, &rule.origin.x);
  const auto wider = hn::Set(d, rule.wider), relative = hn::Set(d, rule.wider_relative);
  const auto farthest = hn::Set(df, float(BoxRule::farthest));
  const auto none = hn::Set(df, -std::numeric_limits<float>::infinity());
  boxes.count = int(points.size());
  for (std::size_t q = 0; q < points.size(); ++q) {
    const auto p = hn::MaskedLoad(xyz, d, &points[q].x);
    const auto from = hn::Sub(p, origin), w = hn::Add(wider, hn::Mul(relative, hn::Abs(p)));
    // A box that is none along one axis meets nothing.
    const auto finite = hn::Le(hn::Abs(hn::DemoteTo(df, from)), farthest);
    // Down is the other way up.
    const auto lower = hn::IfThenElse(finite, round_up(hn::Sub(w, from)), none);
    const auto upper = hn::IfThenElse(finite, round_up(hn::Add(from, w)), none);
    hn::Store(hn::InterleaveLower(df, upper, lower), df, boxes.bounds[q]);
    hn::Store(hn::InterleaveUpper(df, upper, lower), df, boxes.bounds[q] + 4);
  }
}

#else

void set_boxes_target(const BoxRule& rule, std::span<const math::Vec3d> points, QueryBoxes& boxes) {
  constexpr float none = -std::numeric_limits<float>::infinity();
  boxes.count = int(points.size());
  for (std::size_t q = 0; q < points.size(); ++q) {
    float lower[3], upper[3];
    const bool finite = rule.box(points[q], lower, upper);
    for (int a = 0; a < 3; ++a) {
      float* const b = boxes.bounds[q] + 2 * a;
      b[0] = finite ? upper[a] : none;
      b[1] = finite ? -lower[a] : none;
    }
  }
}

#endif

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(set_boxes_target);

void set_boxes(const BoxRule& rule, std::span<const math::Vec3d> points, QueryBoxes& boxes) {
  HWY_DYNAMIC_DISPATCH(set_boxes_target)(rule, points, boxes);
}

} // namespace insitu::query
#endif
