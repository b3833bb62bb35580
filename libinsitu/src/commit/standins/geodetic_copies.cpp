/// The copies of a geodetic mesh's cells, and fields on them.
#include "commit/standins/geodetic_copies.h"

#include <utility>

namespace insitu::commit {

using geo::Pole;
using math::Vec3d;

namespace {

/// The ids as a hexahedron's: turned over, a voxel has no axes.
constexpr int voxel_order[] = {0, 1, 3, 2, 4, 5, 7, 6};

} // namespace

/// At a place whose true directions are known.
Geodetic::Turn Geodetic::turn_of(Pole pole, const Vec3d& east, const Vec3d& turned) const {
  const geo::ChartPlace there =
      geo::place_of(image_.units, pole, {turned.x - image_.offset(pole), turned.y, turned.z});
  return {dot(east, there.east), dot(east, there.north)};
}

void Geodetic::copy(const mesh::MeshView& own, const std::vector<ChartCopy>& cells,
                    Copies& to) const {
  const geo::ChartUnits& units = image_.units;
  const Pole pole = to.pole;
  mesh::CellVertices c;
  const auto turns_of = [&](const ChartCopy& copy, const Vec3d& x) {
    return pole == Pole::none ? turns_to(units, copy.first, x.x) + copy.turns : 0;
  };
  for (const ChartCopy& cell : cells) {
    mesh::gather(own, cell.cell, c);
    for (int v = 0; v < c.count; ++v)
      to.keys.push_back({own.first_vertex[c.piece] + c.ids[v], turns_of(cell, c.x[v])});
  }
  std::ranges::sort(to.keys);
  to.keys.resize(std::size_t(std::ranges::unique(to.keys).begin() - to.keys.begin()));

  for (const Key& key : to.keys) {
    const std::int32_t p = std::int32_t(
        std::upper_bound(own.first_vertex, own.first_vertex + own.piece_count, key.vertex) -
        own.first_vertex - 1);
    const Vec3d x = own.pieces[p].point(key.vertex - own.first_vertex[p]);
    if (pole == Pole::none) {
      to.points.push_back({x.x + key.turns * units.turn(), x.y, x.z});
      continue;
    }
    to.points.push_back(image_.turned(pole, x));
    // The direction east of the vertex' own longitude, at the pole too.
    to.vertex_turns.push_back(
        turn_of(pole, geo::place_of(units, Pole::none, x).east, to.points[to.points.size() - 1]));
  }

  to.offsets.push_back(0);
  for (const ChartCopy& cell : cells) {
    mesh::gather(own, cell.cell, c);
    const bool voxel = c.shape == mesh::Shape::voxel;
    Vec3d middle{};
    for (int i = 0; i < c.count; ++i) {
      const int v = voxel ? voxel_order[i] : i;
      const Key key{own.first_vertex[c.piece] + c.ids[v], turns_of(cell, c.x[v])};
      const Key* const at = std::lower_bound(to.keys.begin(), to.keys.end(), key);
      to.ids.push_back(at - to.keys.begin());
      middle += geo::normal_of(units, c.x[v]);
    }
    to.offsets.push_back(std::int64_t(to.ids.size()));
    to.types.push_back(std::uint8_t(voxel ? mesh::Shape::hexahedron : c.shape));
    to.cells.push_back(cell.cell);
    if (pole != Pole::none)
      to.cell_turns.push_back(turn_of(pole, geo::east_north(middle).east, [&] {
        Vec3d q = geo::chart_point(units, pole, middle, 0.0);
        q.x += image_.offset(pole);
        return q;
      }()));
  }
}

mesh::FieldView Geodetic::field(const mesh::FieldView& own) {
  const Gathered& g = fields_.find(
      own, [] { return std::make_unique<Gathered>(); }, [&](Gathered& to) { gather(own, to); });
  return {g.name.c_str(), own.association, own.components, g.views.data(), own.has_blanks};
}

void Geodetic::gather(const mesh::FieldView& own, Gathered& to) const {
  const int n = own.components;
  const bool of_cells = own.association == INSITU_CELL;
  const std::int32_t solvers = own_->piece_count - own_->halo_piece_count;
  to.views.assign(own.pieces, own.pieces + solvers);
  while (to.values.size() < copies_.size())
    to.values.emplace_back(*memory_, INSITU_MEMORY_CHART);
  to.bases.assign(copies_.size(), {});
  const std::int64_t* const first = of_cells ? own_->first_cell : own_->first_vertex;
  const auto add_halo = [&] {
    to.views.insert(to.views.end(), own.pieces + solvers, own.pieces + own_->piece_count);
  };
  for (std::size_t k = 0; k < copies_.size(); ++k) {
    if (k == own_copies_)
      add_halo();
    const Copies& from = *copies_[k];
    const std::size_t count = of_cells ? from.cells.size() : from.keys.size();
    core::Buffer<double>& values = to.values[k];
    values.resize_discard(count * std::size_t(n));
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t flat = of_cells ? from.cells[i] : from.keys[i].vertex;
      const auto p = std::upper_bound(first, first + own_->piece_count, flat) - first - 1;
      double* const at = values.data() + i * std::size_t(n);
      for (int c = 0; c < n; ++c)
        at[c] = own.pieces[p].load(flat - first[p], c);
      if (!own_->is_vector(own) || from.pole == Pole::none)
        continue;
      const Turn turn = of_cells ? from.cell_turns[i] : from.vertex_turns[i];
      const double east = at[0], north = at[1];
      at[0] = turn.c * east - turn.s * north;
      at[1] = turn.s * east + turn.c * north;
    }
    for (int c = 0; c < n; ++c)
      to.bases[k].push_back(reinterpret_cast<const std::byte*>(values.data() + c));
    const auto items = std::int64_t(count);
    const std::int64_t stride = 8 * n;
    to.views.push_back({to.bases[k].data(), {items, {items, 1}, {stride, 0, 0}, true}, false});
  }
  if (own_copies_ == copies_.size())
    add_halo();
}

} // namespace insitu::commit
