#include "mesh/registered/blank_values.h"

#include <limits>

namespace insitu::mesh {

void BlankedValues::make(const FieldPieceView& from, int components, std::span<const double> blanks,
                         const std::byte* hidden, const ItemLayout& hidden_layout,
                         const core::Threads* threads) {
  is_float32_ = from.is_float32;
  const std::int64_t count = from.layout.count;
  const std::int64_t size = is_float32_ ? sizeof(float) : sizeof(double);
  values_.resize_discard(std::size_t(count * components * size + 7) / sizeof(double));
  components_.resize(std::size_t(components));
  for (int c = 0; c < components; ++c)
    components_[std::size_t(c)] = reinterpret_cast<const std::byte*>(values_.data()) + c * size;
  const std::int64_t stride = components * size;
  layout_ = {count, {count, 1}, {stride, count * stride, count * stride}};
  if (is_float32_)
    copy<float>(from, blanks, hidden, hidden_layout, threads);
  else
    copy<double>(from, blanks, hidden, hidden_layout, threads);
}

template <class Real>
void BlankedValues::copy(const FieldPieceView& from, std::span<const double> blanks,
                         const std::byte* hidden, const ItemLayout& hidden_layout,
                         const core::Threads* threads) {
  const std::vector<Real> blank(blanks.begin(), blanks.end());
  Real* const values = reinterpret_cast<Real*>(values_.data());
  const int n = int(components_.size());
  const auto run = [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      Real* const to = values + i * n;
      bool is_blank = hidden && (load_as<std::uint8_t>(hidden + hidden_layout.offset(i)) & 2) != 0;
      for (int c = 0; c < n; ++c) {
        to[c] = Real(from.load(i, c));
        is_blank |= to[c] != to[c];
        for (const Real b : blank)
          is_blank |= to[c] == b;
      }
      for (int c = 0; c < n && is_blank; ++c)
        to[c] = std::numeric_limits<Real>::quiet_NaN();
    }
  };
  constexpr std::int64_t grain = 1 << 14;
  if (threads)
    threads->parallel_for(from.layout.count, grain, run);
  else
    run(0, from.layout.count);
}

} // namespace insitu::mesh
