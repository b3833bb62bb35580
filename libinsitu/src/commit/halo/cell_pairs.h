#pragma once

#include <cstdint>
#include <string>

#include "mesh/cell_name.h"
#include "parallel/world.h"

namespace insitu::commit {

/// Cells of this process, each beside one of another process with which something is wrong.
struct CellPairs {
  std::int64_t count = 0;
  mesh::CellName own, other; ///< of the first pair, if there is one

  void add(const mesh::CellName& here, const mesh::CellName& there) {
    if (count++ > 0 && !(here < own))
      return;
    own = here;
    other = there;
  }
};

/// Collective: what all processes found, as a sentence without its mesh; empty if nothing. found:
/// by this process; what: behind the number of all; so: behind the names of the first pair.
std::string describe(const CellPairs& found, const std::string& what, const std::string& so,
                     parallel::World& world);

} // namespace insitu::commit
