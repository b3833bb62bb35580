#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "mesh/registered/mesh.h"
#include "part_fields.h"
#include "unit/flat/flat_meshes.h"

/// Flat meshes over processes.
namespace insitu::test {

using flat_meshes::Flat;

/// The cells of a mesh that a process has, in their order, with vertices in another order.
struct FlatPart {
  std::vector<std::int64_t> cells, vertices; ///< of the whole
  std::vector<double> xy;
  PartFields fields;
  std::vector<std::int32_t> ids; ///< padded

  FlatPart(const Flat& whole, const std::vector<int>& process, int rank) {
    std::map<int, int> local;
    for (std::size_t cell = 0; cell < whole.cells.size(); ++cell)
      if (process[cell] == rank)
        cells.push_back(std::int64_t(cell));
    for (auto cell = cells.rbegin(); cell != cells.rend(); ++cell) // numbers as they come
      for (const int v : whole.cells[std::size_t(*cell)])
        if (local.emplace(v, int(vertices.size())).second)
          vertices.push_back(v);
    for (const std::int64_t v : vertices)
      xy.insert(xy.end(), {whole.x[std::size_t(v)], whole.y[std::size_t(v)]});
    for (const std::int64_t cell : cells) {
      const std::vector<int>& ring = whole.cells[std::size_t(cell)];
      for (std::size_t v = 0; v < 4; ++v)
        ids.push_back(v < ring.size() ? local.at(ring[v]) : -1);
    }
  }
  bool empty() const { return cells.empty(); }
  void give(mesh::Mesh& to) {
    const auto array = [](const auto& values, insitu_type type, int components) {
      return insitu_array_of(values.data(), type, std::int64_t(values.size()) / components,
                             components);
    };
    const insitu_array points = array(xy, INSITU_FLOAT64, 2);
    to.set_points(0, &points, 1);
    insitu_cells given = insitu_cells_default();
    given.layout = INSITU_LAYOUT_PADDED;
    given.shape = INSITU_QUAD;
    given.count = std::int64_t(cells.size());
    given.connectivity = array(ids, INSITU_INT32, 4);
    to.set_cells(0, &given);
    insitu_array numbers = array(cells, INSITU_INT64, 1);
    to.set_global_ids(0, INSITU_CELL, &numbers);
    numbers = array(vertices, INSITU_INT64, 1);
    to.set_global_ids(0, INSITU_VERTEX, &numbers);
  }
  void move(mesh::Mesh& to) {
    for (std::size_t v = 0; v < xy.size(); v += 2)
      xy[v] += 0.03 * std::sin(xy[v] + xy[v + 1]);
    to.set_changed(INSITU_CHANGED_GEOMETRY);
  }
  void give_fields(mesh::Mesh& to, double t, double middle) {
    fields.begin(cells, t);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const double x = xy[2 * v] - middle, y = xy[2 * v + 1] - middle;
      fields.p.push_back(std::sin(x + t) + x * y);
      fields.u.insert(fields.u.end(), {-y, x});
    }
    fields.give(to, 0);
  }
};

/// Of squares from 0 to 5, the process of each cell.
inline std::vector<int> flat_slabs(const Flat& whole, int processes) {
  std::vector<int> process;
  for (const auto& ring : whole.cells) {
    const double x = whole.x[std::size_t(ring[0])];
    process.push_back(std::min(processes - 1, std::max(0, int(processes * x / 5))));
  }
  return process;
}

} // namespace insitu::test
