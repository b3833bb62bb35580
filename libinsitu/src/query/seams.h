#pragma once

#include <cstdint>

namespace insitu::query {

/// What is known of cells beside those of other processes. Of several cells that hold a point the
/// first owns it; within a process that is the one with the lowest flat id, which here is not
/// enough, since others lie behind them whatever their global ids are.
class Seams {
public:
  virtual ~Seams() = default;
  /// Whether a cell touches cells of another process, or is one of those.
  virtual bool is_at_seam(std::int64_t flat) const = 0;
  virtual bool is_before(std::int64_t flat, std::int64_t other) const = 0;
};

} // namespace insitu::query
