#include "accel/tree/subtrees.h"

#include <algorithm>

namespace insitu::accel {

namespace {

constexpr std::uint32_t most_nodes = 1024; ///< of a part: about 5000 cells, half a megabyte

} // namespace

Subtrees::Subtrees(const Node* nodes, const std::vector<std::uint32_t>& levels)
    : nodes_(nodes), levels_(levels) {
  cut({0, levels[0], levels[1]});
  std::sort(above_.begin(), above_.end());
}

/// Nodes of the range and below it.
std::uint32_t Subtrees::count(Range r) const {
  std::uint32_t n = r.end - r.begin;
  while (!is_last(r.level) && r.begin != r.end) {
    r = below(r);
    n += r.end - r.begin;
  }
  return n;
}

void Subtrees::cut(const Range& r) {
  if (r.begin == r.end)
    return;
  if (count(r) <= most_nodes) {
    parts_.push_back(r);
  } else if (r.end - r.begin > 1) {
    const std::uint32_t middle = r.begin + (r.end - r.begin) / 2;
    cut({r.level, r.begin, middle});
    cut({r.level, middle, r.end});
  } else {
    above_.push_back(r.begin);
    cut(below(r));
  }
}

} // namespace insitu::accel
