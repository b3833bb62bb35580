#include "mesh/registered/copy_items.h"

#include <algorithm>
#include <cstring>

namespace insitu::mesh {

namespace {

/// Evenly spaced items of n components. n: known to the compiler, or 0: components tells.
template <class T, int n>
void copy_spaced(const std::byte* const* from, std::int64_t offset, std::int64_t stride,
                 int components, std::int64_t count, double* to) {
  const int width = n > 0 ? n : components;
  for (int c = 0; c < width; ++c) {
    const std::byte* p = from[c] + offset;
    double* out = to + c;
    for (std::int64_t i = 0; i < count; ++i, p += stride, out += width)
      *out = double(load_as<T>(p));
  }
}

/// Three arrays at once, since each line of `to` then is written once.
template <class T>
void copy_three(const std::byte* const* from, std::int64_t offset, std::int64_t stride,
                std::int64_t count, double* to) {
  const std::byte* const x = from[0] + offset;
  const std::byte* const y = from[1] + offset;
  const std::byte* const z = from[2] + offset;
  for (std::int64_t i = 0; i < count; ++i) {
    to[3 * i] = double(load_as<T>(x + i * stride));
    to[3 * i + 1] = double(load_as<T>(y + i * stride));
    to[3 * i + 2] = double(load_as<T>(z + i * stride));
  }
}

template <class T>
void copy_row(const std::byte* const* from, std::int64_t offset, std::int64_t stride,
              int components, std::int64_t count, double* to) {
  constexpr std::int64_t item = sizeof(T);
  if (components == 1)
    return stride == item ? copy_spaced<T, 1>(from, offset, item, 1, count, to)
                          : copy_spaced<T, 1>(from, offset, stride, 1, count, to);
  if (components == 3)
    return stride == item ? copy_three<T>(from, offset, item, count, to)
                          : copy_three<T>(from, offset, stride, count, to);
  copy_spaced<T, 0>(from, offset, stride, components, count, to);
}

/// Whether an item's components are doubles that lie side by side, and the next item behind them.
bool is_packed(const FieldPieceView& from, int components, std::int64_t stride) {
  if (from.is_float32 || stride != components * std::int64_t(sizeof(double)))
    return false;
  for (int c = 1; c < components; ++c)
    if (from.component[c] != from.component[0] + c * std::int64_t(sizeof(double)))
      return false;
  return true;
}

} // namespace

void copy_items(const FieldPieceView& from, int components, std::int64_t begin, std::int64_t end,
                double* to) {
  const ItemLayout& layout = from.layout;
  if (from.behind) {
    for (std::int64_t i = begin; i < end; ++i)
      for (int c = 0; c < components; ++c)
        *to++ = from.load(i, c);
    return;
  }
  const std::int64_t stride = layout.stride[0];
  const bool packed = is_packed(from, components, stride);
  for (std::int64_t i = begin; i < end;) {
    const std::int64_t row_end =
        layout.linear ? end : std::min(end, (i / layout.extent[0] + 1) * layout.extent[0]);
    const std::int64_t offset = layout.offset(i), count = row_end - i;
    if (packed)
      std::memcpy(to, from.component[0] + offset, std::size_t(count * components) * sizeof(double));
    else if (from.is_float32)
      copy_row<float>(from.component, offset, stride, components, count, to);
    else
      copy_row<double>(from.component, offset, stride, components, count, to);
    to += count * components;
    i = row_end;
  }
}

void copy_points(const PieceView& from, std::int64_t begin, std::int64_t end, math::Vec3d* to) {
  static_assert(sizeof(math::Vec3d) == 3 * sizeof(double));
  const bool stored = !from.implicit_points && from.layout != CellLayout::gridlets &&
                      from.layout != CellLayout::leaves;
  if (stored)
    return copy_items({from.points.component, from.points.layout, from.points.is_float32}, 3, begin,
                      end, &to->x);
  for (std::int64_t i = begin; i < end; ++i)
    *to++ = from.point(i);
}

} // namespace insitu::mesh
