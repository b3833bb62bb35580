#include "accel/tree/cell_boxes.h"

#include "accel/tree/extent.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/tree/cell_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mesh/offsets_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::accel::HWY_NAMESPACE {

#if HWY_TARGET == HWY_AVX3 && (HWY_TARGETS & HWY_AVX2)

// Registers of four numbers are all that a cell fills.
CellBoxes::Loop choose_loop(const mesh::CellArrays& arrays) {
  return N_AVX2::choose_loop(arrays);
}

#else

namespace hn = hwy::HWY_NAMESPACE;
namespace mesh_simd = mesh::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR

/// Numbers `first` and on of three, as double; nothing is read past the third.
template <std::size_t first, class D>
HWY_INLINE hn::Vec<D> load_some(D d, const double* p) {
  if constexpr (hn::MaxLanes(d) == 4)
    return hn::MaskedLoad(hn::FirstN(d, 3), d, p);
  else if constexpr (hn::MaxLanes(d) == 2 && first == 0)
    return hn::LoadU(d, p);
  else
    return hn::Set(d, p[first]);
}
template <std::size_t first, class D>
HWY_INLINE hn::Vec<D> load_some(D d, const float* p) {
  const hn::Rebind<float, D> df;
  if constexpr (hn::MaxLanes(d) == 4)
    return hn::PromoteTo(d, hn::MaskedLoad(hn::FirstN(df, 3), df, p));
  else if constexpr (hn::MaxLanes(d) == 2 && first == 0)
    return hn::PromoteTo(d, hn::LoadU(df, p));
  else
    return hn::Set(d, double(p[first]));
}

/// Coordinates `first` and on of a box of interleaved ones, as many as fit a register; false if one
/// is not finite or too large. origin: from coordinate `first` on. lower and upper: four floats.
template <class Layout, class Real, std::size_t first>
HWY_INLINE bool fit_some(const std::int64_t* places, int count, const double* origin, float* lower,
                         float* upper) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  const auto load = [&](int v) HWY_ATTR {
    return load_some<first>(d, reinterpret_cast<const Real*>(places[v]));
  };
  auto lo = load(0), hi = lo, sum = lo;
  const auto add = [&](int v) HWY_ATTR {
    const auto x = load(v);
    lo = hn::Min(lo, x);
    hi = hn::Max(hi, x);
    sum = hn::Add(sum, x); // keeps a NaN, which min and max may lose
  };
  for (int v = 1; v < Layout::least; ++v)
    add(v);
  if constexpr (Layout::most > Layout::least)
    for (int v = Layout::least; v < count; ++v)
      add(v);
  const auto from = hn::Load(d, origin);
  lo = hn::Sub(lo, from);
  hi = hn::Sub(hi, from);
  const auto fits = hn::And(hn::And(hn::Gt(lo, hn::Set(d, -largest_coordinate)),
                                    hn::Lt(hi, hn::Set(d, largest_coordinate))),
                            hn::Eq(hn::Sub(sum, sum), hn::Zero(d)));
  // accel::round_down and round_up.
  const auto margin = hn::Set(df, 0x1p-22f), least = hn::Set(df, 0x1p-120f);
  const auto l = hn::DemoteTo(df, lo), u = hn::DemoteTo(df, hi);
  hn::StoreU(hn::Sub(hn::Sub(l, hn::Mul(hn::Abs(l), margin)), least), df, lower + first);
  hn::StoreU(hn::Add(hn::Add(u, hn::Mul(hn::Abs(u), margin)), least), df, upper + first);
  return hn::AllTrue(d, fits);
}

/// Interleaved coordinates: x, y, z in one register (two on SSE2).
template <class Layout, class Real>
std::int64_t interleaved_boxes(const CellBoxes::Piece& piece, const std::uint32_t* cells,
                               std::uint32_t n, std::uint32_t more, Box* boxes) {
  const math::Vec3d& o = piece.origin;
  alignas(32) const double origins[3][4] = {
      {o.x, o.y, o.z, 0.0}, {o.y, o.z, o.z, 0.0}, {o.z, o.z, o.z, 0.0}};
  std::int64_t refused = -1;
  mesh_simd::PlacesAhead<Layout, true> ahead(piece.arrays, piece.first, cells, n + more);
  for (std::uint32_t i = 0; i < n; ++i) {
    int count;
    const std::int64_t* places = ahead.next(i, count);
    alignas(16) float corners[8];
    const auto fit = [&]<std::size_t first>() HWY_ATTR {
      return fit_some<Layout, Real, first>(places, count, origins[first], corners, corners + 4);
    };
    constexpr std::size_t lanes = hn::MaxLanes(hn::CappedTag<double, 4>());
    bool good = count >= Layout::least && fit.template operator()<0>();
    if constexpr (lanes <= 2)
      good = good && fit.template operator()<2>();
    if (!good) {
      boxes[i] = Box{};
      refused = refused < 0 || cells[i] < refused ? std::int64_t(cells[i]) : refused;
      continue;
    }
    for (int a = 0; a < 3; ++a) {
      boxes[i].lower[a] = corners[a];
      boxes[i].upper[a] = corners[4 + a];
    }
  }
  return refused;
}

#endif

/// Coordinates in arrays of their own, or registers of one number.
template <class Layout, class Real>
std::int64_t separate_boxes(const CellBoxes::Piece& piece, const std::uint32_t* cells,
                            std::uint32_t n, std::uint32_t more, Box* boxes) {
  const mesh::CellArrays& m = piece.arrays;
  std::int64_t refused = -1;
  mesh_simd::PlacesAhead<Layout, false> ahead(m, piece.first, cells, n + more);
  for (std::uint32_t i = 0; i < n; ++i) {
    int count;
    const std::int64_t* offsets = ahead.next(i, count);
    const auto point = [&](int v) {
      return math::Vec3d{double(mesh::load_as<Real>(m.points.component[0] + offsets[v])),
                         double(mesh::load_as<Real>(m.points.component[1] + offsets[v])),
                         double(mesh::load_as<Real>(m.points.component[2] + offsets[v]))};
    };
    boxes[i] = Box{};
    if (count >= Layout::least) {
      Extent extent(point(0));
      for (int v = 1; v < Layout::least; ++v)
        extent.add(point(v));
      for (int v = Layout::least; v < count; ++v)
        extent.add(point(v));
      boxes[i] = extent.box(piece.origin);
    }
    if (is_empty(boxes[i]))
      refused = refused < 0 || cells[i] < refused ? std::int64_t(cells[i]) : refused;
  }
  return refused;
}

CellBoxes::Loop choose_loop(const mesh::CellArrays& arrays) {
  return mesh::with_layout(arrays, [&]<class Layout, class Real>() -> CellBoxes::Loop {
#if HWY_TARGET != HWY_SCALAR
    if (arrays.interleaved)
      return &interleaved_boxes<Layout, Real>;
#endif
    return &separate_boxes<Layout, Real>;
  });
}

#endif

} // namespace insitu::accel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::accel {

namespace {

HWY_EXPORT(choose_loop);

std::int64_t general_boxes(const CellBoxes::Piece& piece, const std::uint32_t* cells,
                           std::uint32_t n, std::uint32_t, Box* boxes) {
  std::int64_t refused = -1;
  for (std::uint32_t i = 0; i < n; ++i) {
    mesh::CellVertices cell;
    mesh::gather(*piece.mesh, cells[i], cell);
    Extent extent(cell.x[0]);
    for (int v = 1; v < cell.count; ++v)
      extent.add(cell.x[v]);
    boxes[i] = extent.box(piece.origin);
    if (is_empty(boxes[i]))
      refused = refused < 0 || cells[i] < refused ? std::int64_t(cells[i]) : refused;
  }
  return refused;
}

std::int64_t gridlet_boxes(const CellBoxes::Piece& piece, const std::uint32_t* cells,
                           std::uint32_t n, std::uint32_t, Box* boxes) {
  const mesh::GridletsView& all = *piece.mesh->pieces[piece.index].gridlets;
  std::int64_t refused = -1;
  for (std::uint32_t i = 0; i < n; ++i) {
    const mesh::Gridlet& g = all.gridlets[(cells[i] - piece.first) >> mesh::Gridlet::cell_bits];
    math::Vec3d low, high;
    for (int a = 0; a < 3; ++a) {
      low[a] = all.coordinate(g, a, 0);
      high[a] = all.coordinate(g, a, g.size[a]);
    }
    Extent extent(low);
    extent.add(high);
    boxes[i] = extent.box(piece.origin);
    if (is_empty(boxes[i]))
      refused = refused < 0 || cells[i] < refused ? std::int64_t(cells[i]) : refused;
  }
  return refused;
}

} // namespace

CellBoxes::CellBoxes(const mesh::MeshView& mesh, const math::Vec3d& origin) : mesh_(&mesh) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    Piece piece;
    piece.first = mesh.first_cell[p];
    piece.origin = origin;
    piece.mesh = &mesh;
    piece.index = p;
    if (mesh.pieces[p].gridlets)
      piece.loop = &gridlet_boxes;
    else if (!mesh::CellArrays::make(mesh.pieces[p], piece.arrays))
      piece.loop = &general_boxes;
    else
      piece.loop = HWY_DYNAMIC_DISPATCH(choose_loop)(piece.arrays);
    pieces_.push_back(piece);
  }
}

std::int64_t CellBoxes::compute(const std::uint32_t* flat_cells, std::uint32_t n,
                                std::uint32_t more, Box* boxes) const {
  if (pieces_.size() == 1)
    return pieces_[0].loop(pieces_[0], flat_cells, n, more, boxes);
  std::int64_t refused = -1;
  for (std::uint32_t begin = 0, end = 0; begin < n; begin = end) {
    const std::int32_t p = mesh_->piece_of(flat_cells[begin]);
    const std::int64_t first = mesh_->first_cell[p], last = mesh_->first_cell[p + 1];
    while (end < n && flat_cells[end] >= first && flat_cells[end] < last)
      ++end;
    const Piece& piece = pieces_[std::size_t(p)];
    const std::int64_t bad = piece.loop(piece, flat_cells + begin, end - begin, 0, boxes + begin);
    if (bad >= 0 && (refused < 0 || bad < refused))
      refused = bad;
  }
  return refused;
}

} // namespace insitu::accel
#endif
