#pragma once

#include <cstdint>

#include "core/parallel.h"

namespace insitu::accel::morton {

/// Something and its place along a Morton curve.
struct Coded {
  std::uint32_t code;
  std::uint32_t id;
};

/// Makes the items [begin, end) of those to be sorted, at to[begin] and on; from any thread.
using MakeItems = core::FunctionRef<void(std::int64_t begin, std::int64_t end, Coded* to)>;

/// Fills `items` with n items, at most 2^32, in the order of their codes, which have code_bits
/// bits; equal codes stay as they were made. scratch: room for n. `to` is one of the two, so make
/// may read items[i] of before while it makes item i. The result does not depend on the thread
/// count.
void sort_by_code(Coded* items, Coded* scratch, std::int64_t n, int code_bits,
                  const core::Threads& threads, MakeItems make);

} // namespace insitu::accel::morton
