#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "commit/standins/geodetic.h"

/// What the copies of a geodetic mesh's cells consist of.
namespace insitu::commit {

/// A vertex of a copy: the solver's, moved by whole turns.
struct Geodetic::Key {
  std::int64_t vertex; ///< flat
  int turns;
  auto operator<=>(const Key&) const = default;
};

/// The cosine and sine that take a vector's east and north to another chart's.
struct Geodetic::Turn {
  double c, s;
};

/// The cells of one chart.
struct Geodetic::Copies {
  explicit Copies(core::Memory& memory)
      : points(memory, INSITU_MEMORY_CHART), ids(memory, INSITU_MEMORY_CHART),
        offsets(memory, INSITU_MEMORY_CHART), types(memory, INSITU_MEMORY_CHART),
        keys(memory, INSITU_MEMORY_CHART), cells(memory, INSITU_MEMORY_CHART),
        vertex_turns(memory, INSITU_MEMORY_CHART), cell_turns(memory, INSITU_MEMORY_CHART) {}

  geo::Pole pole = geo::Pole::none;
  bool is_halo = false;
  core::Buffer<math::Vec3d> points;
  core::Buffer<std::int64_t> ids, offsets;
  core::Buffer<std::uint8_t> types;
  core::Buffer<Key> keys;                      ///< [vertex] ascending
  core::Buffer<std::int64_t> cells;            ///< [cell] the solver's, flat
  core::Buffer<Turn> vertex_turns, cell_turns; ///< of vectors; at poles

  std::int64_t bytes() const {
    return std::int64_t(points.bytes() + ids.bytes() + offsets.bytes() + types.bytes() +
                        keys.bytes() + cells.bytes() + vertex_turns.bytes() + cell_turns.bytes());
  }
  bool same_cells(const Copies& b) const {
    return pole == b.pole && is_halo == b.is_halo &&
           std::ranges::equal(cells.span(), b.cells.span()) &&
           std::ranges::equal(keys.span(), b.keys.span()) &&
           std::ranges::equal(ids.span(), b.ids.span());
  }
  mesh::PieceView view() const {
    mesh::PieceView p;
    p.layout = mesh::CellLayout::mixed;
    p.cell_count = std::int64_t(cells.size());
    p.vertex_count = std::int64_t(points.size());
    p.connectivity = {reinterpret_cast<const std::byte*>(ids.data()), std::int64_t(ids.size()), 8,
                      false};
    p.id_stride = 8;
    p.offsets = {reinterpret_cast<const std::byte*>(offsets.data()), std::int64_t(offsets.size()),
                 8, false};
    p.types = reinterpret_cast<const std::byte*>(types.data());
    for (int a = 0; a < 3; ++a)
      p.points.component[a] = reinterpret_cast<const std::byte*>(points.data()) + 8 * a;
    p.points.layout = {p.vertex_count, {p.vertex_count, 1}, {24, 0, 0}, true};
    p.pole = std::int8_t(pole);
    p.is_halo = is_halo;
    return p;
  }
};

/// A field's values at the copies.
struct Geodetic::Gathered {
  std::string name;
  bool fresh = false;
  std::vector<core::Buffer<double>> values; ///< [chart][item][component]
  std::vector<std::vector<const std::byte*>> bases;
  std::vector<mesh::FieldPieceView> views; ///< [piece of view()]
};

} // namespace insitu::commit
