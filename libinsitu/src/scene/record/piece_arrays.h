#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "mesh/registered/given.h"

namespace insitu::scene {

/// Items that this process adds to a dataset of a record.
struct RecordRun {
  std::int64_t items = 0;
  /// Where they lie side by side, as the dataset has them; null: copy() puts them together.
  const std::byte* dense = nullptr;
  /// Copies the items [begin, end) to `to`. Calls come in the order of the items.
  std::function<void(std::int64_t begin, std::int64_t end, std::byte* to)> copy;
};

/// What this process adds to a dataset: items of `components` numbers each, run after run.
struct RecordStream {
  std::string where; ///< path in the file
  insitu_type type = INSITU_FLOAT64;
  int components = 1;
  std::vector<RecordRun> runs;

  std::int64_t items() const;
  std::int64_t item_bytes() const { return components * mesh::size_of(type); }
  /// Copies the items [begin, end) of all runs, or tells where they lie.
  const std::byte* items_at(std::int64_t begin, std::int64_t end, std::byte* scratch) const;
};

/// The items of arrays that together hold one quantity, without gaps, in their own type.
RecordRun run_of(const std::vector<mesh::ExternalArray>& arrays);

} // namespace insitu::scene
