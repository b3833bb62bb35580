#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "mesh/registered/mesh.h"

namespace insitu::test {

/// The fields of a piece of a process: p and u at vertices, and c in cells.
struct PartFields {
  std::vector<double> p, u, c; ///< u: [vertex][component]

  /// No values at vertices yet, and those of cells. cells: their numbers in the whole mesh.
  void begin(const std::vector<std::int64_t>& cells, double t) {
    p.clear(), u.clear(), c.clear();
    for (const std::int64_t cell : cells)
      c.push_back(std::cos(0.1 * double(cell) + t));
  }
  void give(mesh::Mesh& to, std::int32_t piece) const {
    const auto give = [&](const char* name, insitu_association of, const std::vector<double>& all,
                          std::size_t components) {
      const insitu_array array =
          insitu_array_of(all.data(), INSITU_FLOAT64, std::int64_t(all.size() / components),
                          std::int64_t(components));
      to.set_field(piece, name, of, &array, 1);
    };
    give("p", INSITU_VERTEX, p, 1);
    give("u", INSITU_VERTEX, u, p.empty() ? 1 : u.size() / p.size());
    give("c", INSITU_CELL, c, 1);
  }
};

} // namespace insitu::test
