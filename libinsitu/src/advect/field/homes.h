#pragma once

#include <cstdint>

#include "mesh/cell_name.h"

namespace insitu::advect {

using mesh::CellName;

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
