// Vertex offsets of cells (mesh/cell_arrays.h), a cell's at a time, once per Highway target.
// Include after hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_MESH_OFFSETS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_MESH_OFFSETS_SIMD_H
#undef INSITU_MESH_OFFSETS_SIMD_H
#else
#define INSITU_MESH_OFFSETS_SIMD_H
#endif

#include <cstdint>
#include <hwy/highway.h>

#include "mesh/cell_arrays.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::mesh::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Offsets of a cell's vertices, as Layout::offsets, with `origin` added to each.
template <class Layout>
HWY_INLINE int offsets_from(const CellArrays& m, std::int64_t origin, std::int64_t cell,
                            std::int64_t* out) {
#if HWY_MAX_BYTES >= 32
  if constexpr (requires { requires Layout::may_be_packed; })
    if (m.ids_are_packed) {
      constexpr int count = Layout::most;
      const hn::CappedTag<std::int64_t, 4> d;
      const hn::Rebind<std::int32_t, decltype(d)> d_ids;
      const hn::Repartition<std::int32_t, decltype(d)> d_even;
      constexpr int lanes = int(hn::MaxLanes(d));
      const std::byte* ids = m.ids + cell * m.cell_stride;
      const auto base = hn::Set(d_ids, std::int32_t(m.base));
      const auto stride = hn::BitCast(d_even, hn::Set(d, m.point_stride()));
      const auto from = hn::Set(d, origin);
      int v = 0;
      for (; v + lanes <= count; v += lanes) {
        const auto id = hn::PromoteTo(
            d, hn::Sub(hn::LoadU(d_ids, reinterpret_cast<const std::int32_t*>(ids + 4 * v)), base));
        hn::StoreU(hn::Add(hn::MulEven(hn::BitCast(d_even, id), stride), from), d, out + v);
      }
      for (; v < count; ++v)
        out[v] =
            origin + (std::int64_t(load_as<std::int32_t>(ids + 4 * v)) - m.base) * m.point_stride();
      return count;
    }
#endif
  const int count = Layout::offsets(m, cell, out);
  for (int v = 0; v < count; ++v)
    out[v] += origin;
  return count;
}

/// Where a cell's vertices are. Coordinates side by side have an address, others an offset into the
/// three arrays.
template <class Layout, bool interleaved>
HWY_INLINE int vertex_places(const CellArrays& m, std::int64_t cell, std::int64_t* out) {
  static_assert(sizeof(std::int64_t) >= sizeof(void*));
  return offsets_from<Layout>(
      m, interleaved ? reinterpret_cast<std::intptr_t>(m.points.component[0]) : 0, cell, out);
}

/// Asks for the coordinates at some places of a cell. Vertices 2 v and 2 v + 1 are neighbours in
/// many meshes: interleaved, the first one's beginning and the second one's end are the lines that
/// both lie in; else one of them stands for both.
template <bool interleaved>
HWY_INLINE void prefetch_points(const CellArrays& m, const std::int64_t* places, int count) {
  if constexpr (interleaved) {
    const std::int64_t end = m.points.component[2] - m.points.component[0];
    for (int v = 0; v < count; ++v)
      __builtin_prefetch(reinterpret_cast<const void*>(places[v] + (v & 1 ? end : 0)));
  } else {
    for (int v = 0; v < count; v += count == 4 ? 1 : 2)
      for (int a = 0; a < 3; ++a)
        __builtin_prefetch(m.points.component[a] + places[v]);
  }
}

/// The places of the vertices of flat cells that a loop goes through, found some cells early, when
/// what lies there is asked for; cells in the solver's order need no asking.
template <class Layout, bool interleaved>
class PlacesAhead {
public:
  /// n cells of a piece whose first is `first`. A loop may end before, and the rest come next.
  HWY_INLINE PlacesAhead(const CellArrays& m, std::int64_t first, const std::uint32_t* cells,
                         std::uint32_t n)
      : m_(m), first_(first), cells_(cells), n_(n) {
    for (std::uint32_t i = 0; i < ahead && i < n; ++i)
      find(i);
  }
  /// For i = 0, 1, ...: the i-th cell's, valid until the next call, and how many.
  HWY_INLINE const std::int64_t* next(std::uint32_t i, int& count) {
    if (i + layout_ahead < n_ && cells_[i + layout_ahead] - cells_[i] != layout_ahead)
      Layout::prefetch(m_, std::int64_t(cells_[i + layout_ahead]) - first_);
    if (i + ahead < n_) {
      const int found = find(i + ahead);
      if (cells_[i + ahead] - cells_[i] != ahead)
        prefetch_points<interleaved>(m_, places_[(i + ahead) % kept], found);
    }
    count = Layout::least == Layout::most ? Layout::most : count_[i % kept];
    return places_[i % kept];
  }

private:
  static constexpr std::uint32_t layout_ahead = 96, ahead = 24, kept = 32;

  HWY_INLINE int find(std::uint32_t i) {
    const int count =
        vertex_places<Layout, interleaved>(m_, std::int64_t(cells_[i]) - first_, places_[i % kept]);
    count_[i % kept] = count;
    return count;
  }

  const CellArrays m_;
  std::int64_t first_;
  const std::uint32_t* cells_;
  std::uint32_t n_;
  HWY_ALIGN std::int64_t places_[kept][8];
  int count_[kept];
};

} // namespace insitu::mesh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
