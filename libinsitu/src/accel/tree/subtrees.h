#pragma once

#include <cstdint>
#include <vector>

#include "accel/tree/node.h"
#include "core/parallel.h"

namespace insitu::accel {

/// A tree cut for passes from the bottom up: into parts that a core's cache holds, each a range of
/// a level with all that is below it, and the few nodes above. Level by level instead, what the
/// solver's arrays hold would be read once for each level with leaves. The parts depend on the tree
/// alone.
class Subtrees {
public:
  /// levels: nodes of level l are [levels[l], levels[l + 1]); both arrays are to outlive this.
  Subtrees(const Node* nodes, const std::vector<std::uint32_t>& levels);

  /// How many values of `part` there are below.
  std::size_t parts() const { return parts_.size() + above_.size(); }

  /// visit(part, begin, end) for ranges of a level that cover the tree, each after all that is
  /// below it. Ranges of a part come one after the other on one thread, other parts' in parallel.
  template <class Visit>
  void bottom_up(const core::Threads& threads, Visit&& visit) const {
    threads.parallel_for(std::int64_t(parts_.size()), 1,
                         [&](std::int64_t first, std::int64_t last) {
                           for (auto p = std::size_t(first); p < std::size_t(last); ++p)
                             visit_below(p, parts_[p], visit);
                         });
    for (std::size_t i = above_.size(); i-- > 0;)
      visit(parts_.size() + i, above_[i], above_[i] + 1);
  }

private:
  /// Nodes of a level.
  struct Range {
    std::size_t level;
    std::uint32_t begin, end;
  };

  /// The inner children of a range's nodes, which are a range of the next level.
  Range below(const Range& r) const {
    return {r.level + 1, first_child(r.level, r.begin), first_child(r.level, r.end)};
  }
  std::uint32_t first_child(std::size_t level, std::uint32_t node) const {
    return node < levels_[level + 1] ? nodes_[node].first_child : levels_[level + 2];
  }
  bool is_last(std::size_t level) const { return level + 2 == levels_.size(); }
  std::uint32_t count(Range r) const;
  void cut(const Range& r);

  template <class Visit>
  void visit_below(std::size_t part, const Range& r, Visit& visit) const {
    if (r.begin == r.end)
      return;
    if (!is_last(r.level))
      visit_below(part, below(r), visit);
    visit(part, r.begin, r.end);
  }

  const Node* nodes_;
  const std::vector<std::uint32_t>& levels_;
  std::vector<Range> parts_;
  std::vector<std::uint32_t> above_; ///< nodes, those above before those below
};

} // namespace insitu::accel
