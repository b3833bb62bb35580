#include <map>

#include "domain.h"
#include "lists.h"

namespace insitu::blueprint {

namespace {

using Ring = std::vector<std::int64_t>;

/// Whether the triangle from a to b to c goes round counter-clockwise, and how much: twice its
/// area.
struct Point {
  double x, y;
};
double twice_area(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
}

/// The mean of numbers near the first of them.
template <class Get>
double mean_of(std::size_t count, Get&& get) {
  const double base = get(0);
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i)
    sum += get(i) - base;
  return base + sum / static_cast<double>(count);
}

/// Makes triangles and quads of polygons.
class Cutter {
public:
  Cutter(const Domain& d, Cuts& cuts) : d_(d), cuts_(cuts) {}

  void add(const CellLists::Cell& cell) {
    Ring ring = ring_of(cell);
    std::vector<Point> at;
    for (const std::int64_t id : ring)
      at.push_back(point(id));
    double area = 0;
    for (std::size_t i = 2; i < ring.size(); ++i)
      area += twice_area(at[0], at[i - 1], at[i]);
    if (area < 0) {
      std::reverse(ring.begin() + 1, ring.end());
      std::reverse(at.begin() + 1, at.end());
    }
    if (ring.size() == 3 || cell.shape->ids == 4 || (ring.size() == 4 && is_convex(at)))
      give(cell.number, ring);
    else
      cut(cell, ring, at);
  }

  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> ids, offsets{0};

private:
  Point point(std::int64_t id) const {
    const bool joined = d_.points.size() == 1;
    return {value_of(d_.points[0], id, 0), value_of(d_.points[joined ? 0 : 1], id, joined ? 1 : 0)};
  }

  /// The vertices of a polygon, without those that follow themselves.
  Ring ring_of(const CellLists::Cell& cell) const {
    Ring ring;
    const std::string of_cell = "of cell " + std::to_string(cell.number);
    for (const std::int64_t id : cell.ids) {
      if (id < 0 || id >= d_.vertex_count)
        cell.elements->at("connectivity")
            .refuse(INSITU_ERROR_ARGUMENT, of_cell + " has the id " + std::to_string(id) +
                                               ", 0 to " + std::to_string(d_.vertex_count - 1) +
                                               " expected");
      if (cell.shape->ids > 0 || ring.empty() || ring.back() != id)
        ring.push_back(id);
    }
    while (cell.shape->ids == 0 && ring.size() > 1 && ring.back() == ring.front())
      ring.pop_back();
    if (ring.size() < 3)
      cell.elements->at("connectivity")
          .refuse(INSITU_ERROR_ARGUMENT, of_cell + " has " + std::to_string(ring.size()) +
                                             " vertices; 3 or more expected");
    return ring;
  }

  static bool is_convex(const std::vector<Point>& at) {
    for (std::size_t i = 0; i < 4; ++i)
      if (!(twice_area(at[i], at[(i + 1) % 4], at[(i + 2) % 4]) > 0))
        return false;
    return true;
  }

  void give(std::int64_t cell, const Ring& ring) {
    types.push_back(ring.size() == 3 ? INSITU_TRIANGLE : INSITU_QUAD);
    ids.insert(ids.end(), ring.begin(), ring.end());
    offsets.push_back(static_cast<std::int64_t>(ids.size()));
    cuts_.cell.push_back(cell);
  }

  void cut(const CellLists::Cell& cell, const Ring& ring, const std::vector<Point>& at) {
    const std::size_t n = ring.size();
    const Point mean{mean_of(n, [&](std::size_t i) { return at[i].x; }),
                     mean_of(n, [&](std::size_t i) { return at[i].y; })};
    for (std::size_t i = 0; i < n; ++i)
      if (!(twice_area(mean, at[i], at[(i + 1) % n]) > 0))
        return cut_ears(cell, ring, at);
    const std::int64_t made = d_.vertex_count + cuts_.made();
    for (std::size_t i = 0; i < n; ++i)
      give(cell.number, {made, ring[i], ring[(i + 1) % n]});
    cuts_.ring_ids.insert(cuts_.ring_ids.end(), ring.begin(), ring.end());
    cuts_.ring_offsets.push_back(static_cast<std::int64_t>(cuts_.ring_ids.size()));
  }

  /// Whether the triangle at a vertex of a polygon lies within it and holds none of its others.
  static bool is_ear(const std::vector<Point>& at, std::size_t i) {
    const std::size_t n = at.size(), before = (i + n - 1) % n, after = (i + 1) % n;
    const Point &a = at[before], &b = at[i], &c = at[after];
    if (!(twice_area(a, b, c) > 0))
      return false;
    for (std::size_t k = 0; k < n; ++k)
      if (k != before && k != i && k != after && twice_area(a, b, at[k]) >= 0 &&
          twice_area(b, c, at[k]) >= 0 && twice_area(c, a, at[k]) >= 0)
        return false;
    return true;
  }

  /// Cuts a polygon by diagonals, vertex by vertex.
  void cut_ears(const CellLists::Cell& cell, Ring ring, std::vector<Point> at) {
    constexpr std::size_t most = 256; // as the work grows by the third power
    const std::size_t all = ring.size();
    const auto refuse = [&] {
      cell.elements->refuse(
          INSITU_ERROR_MESH,
          "has the cell " + std::to_string(cell.number) + " of " + std::to_string(all) +
              " vertices, which cannot be cut into triangles: its sides cross, or it is not seen "
              "whole from the mean of its vertices and has more than " +
              std::to_string(most));
    };
    if (all > most)
      refuse();
    while (ring.size() > 3) {
      std::size_t ear = 0;
      while (ear < ring.size() && !is_ear(at, ear))
        ++ear;
      if (ear == ring.size())
        refuse();
      const std::size_t n = ring.size();
      give(cell.number, {ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]});
      ring.erase(ring.begin() + std::ptrdiff_t(ear));
      at.erase(at.begin() + std::ptrdiff_t(ear));
    }
    if (!(twice_area(at[0], at[1], at[2]) > 0))
      refuse();
    give(cell.number, ring);
  }

  const Domain& d_;
  Cuts& cuts_;
};

/// Values of vertices with the means of rings behind them.
template <class T>
T* with_means(const insitu_array& array, const Cuts& cuts, Copies& copies) {
  const auto components = static_cast<std::int64_t>(array.components);
  T* out = copies.make<T>((array.count + cuts.made()) * components);
  for (std::int64_t v = 0; v < array.count; ++v)
    for (std::int64_t c = 0; c < components; ++c)
      out[v * components + c] = static_cast<T>(value_of(array, v, static_cast<int>(c)));
  for (std::int64_t m = 0; m < cuts.made(); ++m) {
    const auto first = static_cast<std::size_t>(cuts.ring_offsets[static_cast<std::size_t>(m)]),
               end = static_cast<std::size_t>(cuts.ring_offsets[static_cast<std::size_t>(m) + 1]);
    for (std::int64_t c = 0; c < components; ++c) {
      const auto value = [&](std::size_t i) {
        return value_of(array, cuts.ring_ids[first + i], static_cast<int>(c));
      };
      T& to = out[(array.count + m) * components + c];
      if constexpr (sizeof(T) == 1) { // what tells of vertices: all that is said of one of them
        to = 0;
        for (std::size_t i = 0; i < end - first; ++i)
          to = static_cast<T>(to | static_cast<T>(value(i)));
      } else {
        to = static_cast<T>(mean_of(end - first, value));
      }
    }
  }
  return out;
}

template <class T>
T* of_parts(const insitu_array& array, const Cuts& cuts, Copies& copies) {
  const auto components = static_cast<std::int64_t>(array.components);
  T* out = copies.make<T>(static_cast<std::int64_t>(cuts.cell.size()) * components);
  T* to = out;
  for (const std::int64_t cell : cuts.cell)
    for (std::int64_t c = 0; c < components; ++c)
      *to++ = static_cast<T>(value_of(array, cell, static_cast<int>(c)));
  return out;
}

} // namespace

insitu_array Cuts::expanded(const insitu_array& array, bool on_cells, Copies& copies) const {
  if (!on_cells && made() == 0)
    return array;
  const auto make = [&](auto type) -> const void* {
    using T = decltype(type);
    return on_cells ? of_parts<T>(array, *this, copies) : with_means<T>(array, *this, copies);
  };
  insitu_array out = insitu_array_of(
      array.type == INSITU_UINT8     ? make(std::uint8_t{})
      : array.type == INSITU_FLOAT32 ? make(float{})
                                     : make(double{}),
      array.type, on_cells ? static_cast<std::int64_t>(cell.size()) : array.count + made(),
      array.components);
  out.converted = "polygons are cut into triangles";
  return out;
}

void read_polygons(const Node& topology, Domain& d) {
  const CellLists lists(topology);
  auto cuts = std::make_shared<Cuts>();
  Cutter cutter(d, *cuts);
  std::map<std::string, std::int64_t> lower;
  lists.for_each([&](const CellLists::Cell& cell) {
    if (cell.shape->dimensions < 2)
      ++lower[cell.shape->name];
    else
      cutter.add(cell);
  });
  for (const auto& [name, number] : lower)
    d.left_out.push_back(topology.path() + "/elements: " + std::to_string(number) +
                         " cells of shape " + name + " have no area");
  d.are_polygons = true;
  d.cell_count = lists.count();
  const auto parts = static_cast<std::int64_t>(cutter.types.size());
  auto* types = d.cell_copies->make<std::uint8_t>(parts);
  std::copy(cutter.types.begin(), cutter.types.end(), types);
  d.cells.layout = INSITU_LAYOUT_MIXED;
  d.cells.count = parts;
  d.cells.types = insitu_array_of(types, INSITU_UINT8, parts, 1);
  d.cells.offsets = d.cell_copies->array(cutter.offsets);
  d.cells.connectivity = d.cell_copies->array(cutter.ids);
  for (insitu_array* a : {&d.cells.types, &d.cells.offsets, &d.cells.connectivity})
    a->converted = "polygons of any number of vertices";
  if (cuts->made() == 0 && parts == d.cell_count)
    return;
  d.cuts = cuts;
  if (cuts->made() == 0)
    return;
  for (insitu_array& a : d.points) { // as doubles, so that the means lie where they are
    const double* values = with_means<double>(a, *cuts, *d.point_copies);
    a = insitu_array_of(values, INSITU_FLOAT64, a.count + cuts->made(), a.components);
    a.converted = "polygons are cut into triangles";
  }
}

} // namespace insitu::blueprint
