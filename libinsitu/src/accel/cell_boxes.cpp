#include "accel/cell_boxes.h"

#include <algorithm>

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/cell_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::accel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr double largest = 1e37; // coordinates beyond do not fit a float box with its margins

/// Four adjacent numbers as double.
template <class D>
HWY_INLINE hn::Vec<D> load_double(D d, const double* p) {
  return hn::LoadU(d, p);
}
template <class D>
HWY_INLINE hn::Vec<D> load_double(D d, const float* p) {
  return hn::PromoteTo(d, hn::LoadU(hn::Rebind<float, D>(), p));
}

/// Interleaved coordinates: x, y, z and whatever follows in one register (two on SSE2).
template <class Index, class Real, int count>
std::int64_t interleaved_boxes(const CellBoxes::Arrays& m, const std::uint32_t* cells,
                               std::uint32_t n, Box* boxes) {
  const hn::CappedTag<double, 4> d;
  constexpr std::size_t lanes = hn::MaxLanes(d), parts = 4 / lanes;
  const hn::Rebind<float, decltype(d)> df;
  alignas(32) Real padded[4];
  alignas(32) double origin[4] = {m.origin.x, m.origin.y, m.origin.z, 0.0};
  for (int a = 0; a < 4; ++a)
    padded[a] = Real(m.padded[a]);
  const auto id = [&](const std::byte* ids, int v) HWY_ATTR {
    return std::int64_t(mesh::load_as<Index>(ids + v * m.id_stride)) - m.base;
  };
  constexpr std::uint32_t ids_ahead = 32, points_ahead = 12;
  std::int64_t refused = -1;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (i + ids_ahead < n)
      __builtin_prefetch(m.ids + cells[i + ids_ahead] * m.cell_stride);
    if (i + points_ahead < n) {
      const std::byte* ids = m.ids + cells[i + points_ahead] * m.cell_stride;
      for (int v = 0; v < count; v += 2)
        __builtin_prefetch(m.component[0] + id(ids, v) * m.point_stride);
    }
    const std::byte* ids = m.ids + cells[i] * m.cell_stride;
    const auto point = [&](int v) HWY_ATTR {
      const std::int64_t at = id(ids, v);
      return at == m.last ? padded
                          : reinterpret_cast<const Real*>(m.component[0] + at * m.point_stride);
    };
    alignas(16) float lower[4], upper[4];
    bool good = true;
    const Real* p[count];
    for (int v = 0; v < count; ++v)
      p[v] = point(v);
    for (std::size_t part = 0; part < parts; ++part) {
      const std::size_t o = part * lanes;
      auto lo = load_double(d, p[0] + o), hi = lo, sum = lo;
      for (int v = 1; v < count; ++v) {
        const auto x = load_double(d, p[v] + o);
        lo = hn::Min(lo, x);
        hi = hn::Max(hi, x);
        sum = hn::Add(sum, x); // keeps a NaN, which min and max may lose
      }
      const auto from = hn::Load(d, origin + o);
      lo = hn::Sub(lo, from);
      hi = hn::Sub(hi, from);
      const auto fits =
          hn::And(hn::And(hn::Gt(lo, hn::Set(d, -largest)), hn::Lt(hi, hn::Set(d, largest))),
                  hn::Eq(hn::Sub(sum, sum), hn::Zero(d)));
      alignas(32) std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, fits, bits);
      const unsigned wanted = (o + lanes > 3 ? (1u << (3 - o)) : (1u << lanes)) - 1u;
      good &= (unsigned(bits[0]) & wanted) == wanted;
      // accel::round_down and round_up.
      const auto margin = hn::Set(df, 0x1p-22f), least = hn::Set(df, 0x1p-120f);
      const auto l = hn::DemoteTo(df, lo), u = hn::DemoteTo(df, hi);
      hn::StoreU(hn::Sub(hn::Sub(l, hn::Mul(hn::Abs(l), margin)), least), df, lower + o);
      hn::StoreU(hn::Add(hn::Add(u, hn::Mul(hn::Abs(u), margin)), least), df, upper + o);
    }
    if (!good) {
      boxes[i] = Box{};
      refused = refused < 0 || cells[i] < refused ? std::int64_t(cells[i]) : refused;
      continue;
    }
    for (int a = 0; a < 3; ++a) {
      boxes[i].lower[a] = lower[a];
      boxes[i].upper[a] = upper[a];
    }
  }
  return refused;
}

template <class Index, class Real>
CellBoxes::Loop choose_count(int count) {
  switch (count) {
  case 4:
    return &interleaved_boxes<Index, Real, 4>;
  case 5:
    return &interleaved_boxes<Index, Real, 5>;
  case 6:
    return &interleaved_boxes<Index, Real, 6>;
  default:
    return &interleaved_boxes<Index, Real, 8>;
  }
}

CellBoxes::Loop interleaved_loop(bool is_int32, bool is_float32, int count) {
  return is_int32 ? (is_float32 ? choose_count<std::int32_t, float>(count)
                                : choose_count<std::int32_t, double>(count))
                  : (is_float32 ? choose_count<std::int64_t, float>(count)
                                : choose_count<std::int64_t, double>(count));
}

} // namespace insitu::accel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::accel {

namespace {

HWY_EXPORT(interleaved_loop);

constexpr double largest = 1e37;

/// The box of gathered vertices.
class Extent {
public:
  explicit Extent(const math::Vec3d& p) : lo_(p), hi_(p), sum_(p) {}
  void add(const math::Vec3d& p) {
    for (int a = 0; a < 3; ++a) {
      lo_[a] = p[a] < lo_[a] ? p[a] : lo_[a];
      hi_[a] = p[a] > hi_[a] ? p[a] : hi_[a];
    }
    sum_ += p; // keeps a NaN, which the comparisons may lose
  }
  Box box(const math::Vec3d& origin) const {
    Box b;
    for (int a = 0; a < 3; ++a) {
      const double l = lo_[a] - origin[a], u = hi_[a] - origin[a];
      if (!(l > -largest && u < largest && sum_[a] - sum_[a] == 0.0))
        return Box{};
      b.lower[a] = round_down(l);
      b.upper[a] = round_up(u);
    }
    return b;
  }

private:
  math::Vec3d lo_, hi_, sum_;
};

bool is_empty(const Box& b) {
  return !(b.lower[0] <= b.upper[0]);
}

/// Separate coordinate arrays, or records that are too short for the interleaved loop.
template <class Index, class Real>
std::int64_t separate_boxes(const CellBoxes::Arrays& m, const std::uint32_t* cells, std::uint32_t n,
                            Box* boxes) {
  std::int64_t refused = -1;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::byte* ids = m.ids + cells[i] * m.cell_stride;
    const auto point = [&](int v) {
      const std::int64_t o =
          (std::int64_t(mesh::load_as<Index>(ids + v * m.id_stride)) - m.base) * m.point_stride;
      return math::Vec3d{double(mesh::load_as<Real>(m.component[0] + o)),
                         double(mesh::load_as<Real>(m.component[1] + o)),
                         double(mesh::load_as<Real>(m.component[2] + o))};
    };
    Extent extent(point(0));
    for (int v = 1; v < m.count; ++v)
      extent.add(point(v));
    boxes[i] = extent.box(m.origin);
    if (is_empty(boxes[i]))
      refused = refused < 0 || cells[i] < refused ? std::int64_t(cells[i]) : refused;
  }
  return refused;
}

} // namespace

CellBoxes::CellBoxes(const mesh::MeshView& mesh, const math::Vec3d& origin) : mesh_(&mesh) {
  arrays_.origin = origin;
  if (mesh.piece_count != 1)
    return;
  const mesh::PieceView& p = mesh.pieces[0];
  if (p.layout != mesh::CellLayout::uniform || p.implicit_points || !p.points.layout.linear)
    return;
  Arrays& m = arrays_;
  m.ids = p.connectivity.data;
  m.cell_stride = p.connectivity.stride;
  m.id_stride = p.id_stride;
  m.base = p.index_base;
  m.point_stride = p.points.layout.stride[0];
  m.last = p.points.layout.count - 1;
  m.count = mesh::vertex_count(p.uniform_shape);
  for (int a = 0; a < 3; ++a)
    m.component[a] = p.points.component[a];
  const bool is_int32 = p.connectivity.is_int32, is_float32 = p.points.is_float32;
  const std::int64_t size = is_float32 ? 4 : 8;
  const bool interleaved = m.component[1] - m.component[0] == size &&
                           m.component[2] - m.component[1] == size && m.point_stride >= 3 * size &&
                           m.last >= 0;
  if (interleaved) {
    const math::Vec3d x = p.points.load(m.last);
    for (int a = 0; a < 3; ++a)
      m.padded[a] = x[a];
    loop_ = HWY_DYNAMIC_DISPATCH(interleaved_loop)(is_int32, is_float32, m.count);
  } else {
    loop_ = is_int32 ? (is_float32 ? &separate_boxes<std::int32_t, float>
                                   : &separate_boxes<std::int32_t, double>)
                     : (is_float32 ? &separate_boxes<std::int64_t, float>
                                   : &separate_boxes<std::int64_t, double>);
  }
}

std::int64_t CellBoxes::compute(const std::uint32_t* flat_cells, std::uint32_t n,
                                Box* boxes) const {
  if (loop_)
    return loop_(arrays_, flat_cells, n, boxes);
  std::int64_t refused = -1;
  for (std::uint32_t i = 0; i < n; ++i) {
    mesh::CellVertices cell;
    mesh::gather(*mesh_, flat_cells[i], cell);
    Extent extent(cell.x[0]);
    for (int v = 1; v < cell.count; ++v)
      extent.add(cell.x[v]);
    boxes[i] = extent.box(arrays_.origin);
    if (is_empty(boxes[i]))
      refused = refused < 0 || flat_cells[i] < refused ? std::int64_t(flat_cells[i]) : refused;
  }
  return refused;
}

} // namespace insitu::accel
#endif
