#include "cells/kernels/gather.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cells/kernels/gather.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mesh/offsets_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::cells::HWY_NAMESPACE {

#if HWY_TARGET == HWY_AVX3 && (HWY_TARGETS & HWY_AVX2)

// Registers of four numbers are all that is used.
CellGather::Loop choose_loop(const mesh::CellArrays& arrays) {
  return N_AVX2::choose_loop(arrays);
}

#else

namespace hn = hwy::HWY_NAMESPACE;
namespace mesh_simd = mesh::HWY_NAMESPACE;

// A cell's vertices are asked for so many cells early, and their ids some time before that.
constexpr int ahead = 24, layout_ahead = 64;

template <class Layout, bool interleaved>
HWY_INLINE void ask_ahead(const mesh::CellArrays& m, const std::int64_t* cells, int i, int end) {
  if (i + layout_ahead < end)
    Layout::prefetch(m, cells[i + layout_ahead]);
  if (i + ahead >= end)
    return;
  std::int64_t places[8];
  const int count = mesh_simd::vertex_places<Layout, interleaved>(m, cells[i + ahead], places);
  mesh_simd::prefetch_points<interleaved>(m, places, count);
}

#if HWY_MAX_BYTES >= 32

/// Three doubles, and nothing read past them.
HWY_INLINE hn::Vec<hn::FixedTag<double, 4>> load_three(const double* p) {
  const hn::FixedTag<double, 4> d;
  return hn::MaskedLoad(hn::FirstN(d, 3), d, p);
}
HWY_INLINE hn::Vec<hn::FixedTag<double, 4>> load_three(const float* p) {
  const hn::FixedTag<float, 4> d;
  return hn::PromoteTo(hn::FixedTag<double, 4>(), hn::MaskedLoad(hn::FirstN(d, 3), d, p));
}

/// Interleaved coordinates: x, y, z in one register, four cells transposed at a time.
template <class Layout, class Real>
void interleaved_loop(const mesh::CellArrays& m, const std::int64_t* cells, int n, int more,
                      CellBlock& block) {
  const hn::FixedTag<double, 4> d;
  for (int i = 0; i < n; i += 4) {
    std::int64_t places[4][8];
    int count = 0;
    for (int k = 0; k < 4; ++k) {
      ask_ahead<Layout, true>(m, cells, i + k, n + more);
      count = mesh_simd::vertex_places<Layout, true>(m, cells[std::min(i + k, n - 1)], places[k]);
    }
    if constexpr (Layout::least == Layout::most)
      count = Layout::most;
    for (int v = 0; v < count; ++v) {
      const auto row = [&](int k) HWY_ATTR {
        return load_three(reinterpret_cast<const Real*>(places[k][v]));
      };
      const auto a = row(0), b = row(1), c = row(2), e = row(3);
      const auto xz = hn::InterleaveLower(d, a, b), y_ = hn::InterleaveUpper(d, a, b);
      const auto xz2 = hn::InterleaveLower(d, c, e), y_2 = hn::InterleaveUpper(d, c, e);
      hn::StoreU(hn::ConcatLowerLower(d, xz2, xz), d, block.vertex[v][0] + i);
      hn::StoreU(hn::ConcatLowerLower(d, y_2, y_), d, block.vertex[v][1] + i);
      hn::StoreU(hn::ConcatUpperUpper(d, xz2, xz), d, block.vertex[v][2] + i);
    }
  }
}

#endif

/// Coordinates in arrays of their own, or registers too small for the loop above.
template <class Layout, class Real>
void separate_loop(const mesh::CellArrays& m, const std::int64_t* cells, int n, int more,
                   CellBlock& block) {
  for (int i = 0; i < n; ++i) {
    ask_ahead<Layout, false>(m, cells, i, n + more);
    std::int64_t offsets[8];
    const int count = mesh_simd::vertex_places<Layout, false>(m, cells[i], offsets);
    for (int v = 0; v < count; ++v)
      for (int a = 0; a < 3; ++a)
        block.vertex[v][a][i] = double(mesh::load_as<Real>(m.points.component[a] + offsets[v]));
  }
}

CellGather::Loop choose_loop(const mesh::CellArrays& arrays) {
  return mesh::with_layout(arrays, [&]<class Layout, class Real>() -> CellGather::Loop {
#if HWY_MAX_BYTES >= 32
    if (arrays.interleaved)
      return &interleaved_loop<Layout, Real>;
#endif
    return &separate_loop<Layout, Real>;
  });
}

#endif

} // namespace insitu::cells::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::cells {

HWY_EXPORT(choose_loop);

namespace {
constexpr int most_ahead = 64; ///< cells that are asked for early, as above
} // namespace

CellGather::CellGather(const mesh::MeshView& mesh, double alpha) : mesh_(&mesh), alpha_(alpha) {
  if (mesh.piece_count == 1)
    only_ = 0;
  else if (mesh.piece_count == 2 && mesh.pieces[0].in_runs())
    only_ = 1;
  std::int32_t largest = std::max(only_, 0);
  for (std::int32_t p = largest + 1; p < mesh.piece_count; ++p)
    if (mesh.first_cell[p + 1] - mesh.first_cell[p] >
        mesh.first_cell[largest + 1] - mesh.first_cell[largest])
      largest = p;
  if (mesh.piece_count > 0)
    choose(largest);
}

void CellGather::choose(std::int32_t p) {
  const mesh::PieceView& piece = mesh_->pieces[p];
  one_shape_ = only_ == 0 && (piece.layout == mesh::CellLayout::uniform ||
                              piece.layout == mesh::CellLayout::block);
  // Cells come by flat ids, which ids alone can be made to count by.
  const bool counts_alike = p == 0 || p == only_ || piece.layout == mesh::CellLayout::uniform;
  if (alpha_ != 1.0 || !counts_alike || !mesh::CellArrays::make(piece, arrays_))
    return;
  loop_ = HWY_DYNAMIC_DISPATCH(choose_loop)(arrays_);
  first_ = mesh_->first_cell[p];
  end_ = mesh_->first_cell[p + 1];
  arrays_.ids -= first_ * arrays_.cell_stride;
}

void CellGather::fill(const std::int64_t* cells, int n, int more, CellBlock& block) const {
  if (loop_ && only_ >= 0)
    return loop_(arrays_, cells, n, more, block);
  const auto is_other = [&](std::int64_t cell) { return !in_loop(cell); };
  if (loop_ && std::none_of(cells, cells + n, is_other)) {
    // It reads what it asks for early.
    const std::int64_t* const next = cells + n;
    const std::int64_t* const end = next + std::min(more, most_ahead);
    return loop_(arrays_, cells, n, int(std::find_if(next, end, is_other) - next), block);
  }
  for (int i = 0; i < n; ++i) {
    mesh::CellVertices cell;
    mesh::gather(*mesh_, cells[i], cell, alpha_);
    block.set(cell.count, i, cell.x);
  }
}

} // namespace insitu::cells
#endif
