#include "query/gather.h"

#include <algorithm>

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/gather.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int ahead = 24; // a cell's vertices are asked for so many cells early

template <class Index>
HWY_INLINE std::int64_t id_of(const CellGather::Arrays& m, const std::byte* ids, int v) {
  return std::int64_t(mesh::load_as<Index>(ids + v * m.id_stride)) - m.base;
}

/// Vertices 2 v and 2 v + 1 are neighbours in many meshes: the first one's beginning and the second
/// one's end are the lines that both lie in.
template <class Index, int count>
HWY_INLINE void prefetch_points(const CellGather::Arrays& m, std::int64_t cell) {
  const std::byte* ids = m.ids + cell * m.cell_stride;
  for (int v = 0; v < count; ++v)
    __builtin_prefetch(m.component[v & 1 ? 2 : 0] + id_of<Index>(m, ids, v) * m.point_stride);
}

#if HWY_MAX_BYTES >= 32

HWY_INLINE hn::Vec<hn::FixedTag<double, 4>> load_four(const double* p) {
  return hn::LoadU(hn::FixedTag<double, 4>(), p);
}
HWY_INLINE hn::Vec<hn::FixedTag<double, 4>> load_four(const float* p) {
  return hn::PromoteTo(hn::FixedTag<double, 4>(), hn::LoadU(hn::FixedTag<float, 4>(), p));
}

/// Interleaved coordinates: x, y, z and whatever follows in one register, four cells transposed at
/// a time.
template <class Index, class Real, int count>
void interleaved_loop(const CellGather::Arrays& m, const std::int64_t* cells, int n, int more,
                      PairBlock& block) {
  const hn::FixedTag<double, 4> d;
  Real padded[4];
  for (int a = 0; a < 4; ++a)
    padded[a] = Real(m.padded[a]);
  for (int i = 0; i < n; i += 4) {
    const std::byte* ids[4];
    for (int k = 0; k < 4; ++k) {
      if (i + k + ahead < n + more)
        prefetch_points<Index, count>(m, cells[i + k + ahead]);
      ids[k] = m.ids + cells[std::min(i + k, n - 1)] * m.cell_stride;
    }
    const auto row = [&](int k, int v) HWY_ATTR {
      const std::int64_t at = id_of<Index>(m, ids[k], v);
      return load_four(at == m.last
                           ? padded
                           : reinterpret_cast<const Real*>(m.component[0] + at * m.point_stride));
    };
    for (int v = 0; v < count; ++v) {
      const auto a = row(0, v), b = row(1, v), c = row(2, v), e = row(3, v);
      const auto xz = hn::InterleaveLower(d, a, b), y_ = hn::InterleaveUpper(d, a, b);
      const auto xz2 = hn::InterleaveLower(d, c, e), y_2 = hn::InterleaveUpper(d, c, e);
      hn::StoreU(hn::ConcatLowerLower(d, xz2, xz), d, block.vertex[v][0] + i);
      hn::StoreU(hn::ConcatLowerLower(d, y_2, y_), d, block.vertex[v][1] + i);
      hn::StoreU(hn::ConcatUpperUpper(d, xz2, xz), d, block.vertex[v][2] + i);
    }
  }
}

#endif

/// Separate coordinate arrays, or records too short or registers too small for the loop above.
template <class Index, class Real, int count>
void separate_loop(const CellGather::Arrays& m, const std::int64_t* cells, int n, int more,
                   PairBlock& block) {
  for (int i = 0; i < n; ++i) {
    if (i + ahead < n + more) {
      const std::byte* ids = m.ids + cells[i + ahead] * m.cell_stride;
      for (int v = 0; v < count; v += count == 4 ? 1 : 2)
        for (int a = 0; a < 3; ++a)
          __builtin_prefetch(m.component[a] + id_of<Index>(m, ids, v) * m.point_stride);
    }
    const std::byte* ids = m.ids + cells[i] * m.cell_stride;
    for (int v = 0; v < count; ++v) {
      const std::int64_t at = id_of<Index>(m, ids, v) * m.point_stride;
      for (int a = 0; a < 3; ++a)
        block.vertex[v][a][i] = double(mesh::load_as<Real>(m.component[a] + at));
    }
  }
}

template <class Index, class Real, int count>
CellGather::Loop choose_layout(bool interleaved) {
#if HWY_MAX_BYTES >= 32
  if (interleaved)
    return &interleaved_loop<Index, Real, count>;
#endif
  (void)interleaved;
  return &separate_loop<Index, Real, count>;
}

template <class Index, class Real>
CellGather::Loop choose_count(int count, bool interleaved) {
  switch (count) {
  case 4:
    return choose_layout<Index, Real, 4>(interleaved);
  case 5:
    return choose_layout<Index, Real, 5>(interleaved);
  case 6:
    return choose_layout<Index, Real, 6>(interleaved);
  default:
    return choose_layout<Index, Real, 8>(interleaved);
  }
}

CellGather::Loop choose_loop(bool is_int32, bool is_float32, int count, bool interleaved) {
  if (is_int32)
    return is_float32 ? choose_count<std::int32_t, float>(count, interleaved)
                      : choose_count<std::int32_t, double>(count, interleaved);
  return is_float32 ? choose_count<std::int64_t, float>(count, interleaved)
                    : choose_count<std::int64_t, double>(count, interleaved);
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace insitu::query {

HWY_EXPORT(choose_loop);

CellGather::CellGather(const mesh::MeshView& mesh, double alpha) : mesh_(&mesh), alpha_(alpha) {
  if (mesh.piece_count != 1 || alpha != 1.0)
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
  for (int a = 0; a < 3; ++a)
    m.component[a] = p.points.component[a];
  const std::int64_t size = p.points.is_float32 ? 4 : 8;
  const bool interleaved = m.component[1] - m.component[0] == size &&
                           m.component[2] - m.component[1] == size && m.point_stride >= 3 * size &&
                           m.last >= 0;
  if (interleaved) {
    const math::Vec3d x = p.points.load(m.last);
    for (int a = 0; a < 3; ++a)
      m.padded[a] = x[a];
  }
  loop_ = HWY_DYNAMIC_DISPATCH(choose_loop)(p.connectivity.is_int32, p.points.is_float32,
                                            mesh::vertex_count(p.uniform_shape), interleaved);
}

void CellGather::fill(const std::int64_t* cells, int n, int more, PairBlock& block) const {
  if (loop_)
    return loop_(arrays_, cells, n, more, block);
  for (int i = 0; i < n; ++i) {
    mesh::CellVertices cell;
    mesh::gather(*mesh_, cells[i], cell, alpha_);
    for (int v = 0; v < cell.count; ++v)
      for (int a = 0; a < 3; ++a)
        block.vertex[v][a][i] = cell.x[v][a];
  }
}

} // namespace insitu::query
#endif
