#pragma once

#include <cstdint>

namespace insitu::advect {

/// A cell as all processes know it: the process that owns it, the piece there and its id in that.
/// rank -1: none.
struct CellName {
  std::int32_t rank = -1, piece = -1;
  std::int64_t cell = -1;
  bool operator==(const CellName&) const = default;
};

/// Which process owns each of the cells that exist here: this one, or for a cell of the halo
/// another.
class Homes {
public:
  virtual ~Homes() = default;
  /// Whether this process owns a cell (flat id).
  virtual bool is_own(std::int64_t cell) const = 0;
  /// Of any cell that exists here.
  virtual CellName name(std::int64_t cell) const = 0;
  /// The flat id of a cell here; -1: it does not exist here.
  virtual std::int64_t find(const CellName& name) const = 0;
};

} // namespace insitu::advect
