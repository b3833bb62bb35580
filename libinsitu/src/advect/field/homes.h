#pragma once

#include <cstdint>

#include "mesh/cell_name.h"

namespace insitu::advect {

using mesh::CellName;

/// How all processes know the cells that exist here.
class NamedCells {
public:
  virtual ~NamedCells() = default;
  /// Of any cell that exists here (flat id).
  virtual CellName name(std::int64_t cell) const = 0;
  /// The flat id of a cell here; -1: it does not exist here.
  virtual std::int64_t find(const CellName& name) const = 0;
};

/// And which process owns each of them: this one, or for a cell of the halo another.
class Homes : public NamedCells {
public:
  /// Whether this process owns a cell (flat id).
  virtual bool is_own(std::int64_t cell) const = 0;
};

} // namespace insitu::advect
