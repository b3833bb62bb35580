#include "commit/earlier/gathered_adaptive.h"

#include <algorithm>
#include <tuple>

#include "amr/dual/enumerate.h"
#include "core/status.h"
#include "mesh/box.h"

namespace insitu::commit {

using mesh::Gridlet;

namespace {

/// In the order of the dual's bricks.
auto key_of(int depth, const std::int32_t* index) {
  return std::tuple(depth, index[2] >> 3, index[1] >> 3, index[0] >> 3);
}
auto key_of_gridlet(const Gridlet& g) {
  return key_of(g.depth, g.lower);
}
auto key_of_leaf(const Spot& s) {
  return std::tuple(s.depth, s.index[2], s.index[1], s.index[0]);
}

/// The leaves at these places.
void build_map(const mesh::Lattice& lattice, const std::vector<Spot>& leaves,
               const core::Threads& threads, amr::LeafMap& to) {
  const auto bytes = [](const auto* item) { return reinterpret_cast<const std::byte*>(item); };
  mesh::AmrPieceView piece;
  piece.is_patch = false;
  piece.cell_count = std::int64_t(leaves.size());
  piece.rank = 0; // levels are depths
  piece.level_bytes = 1;
  piece.levels_stride = piece.corner_stride = sizeof(Spot);
  if (!leaves.empty()) {
    piece.levels = bytes(&leaves[0].depth);
    for (int a = 0; a < 3; ++a)
      piece.corner[a] = bytes(&leaves[0].index[a]);
  }
  const std::int64_t first_cell[] = {0, piece.cell_count};
  mesh::AmrView view;
  view.lattice = lattice;
  view.pieces = &piece;
  view.first_cell = first_cell;
  view.piece_count = 1;
  view.is_part = true;
  to.build(view, threads);
}

mesh::Box box_of(const mesh::Lattice& lattice, int depth, const std::int64_t* index,
                 std::int64_t cells) {
  mesh::Box box;
  for (int a = 0; a < 3; ++a) {
    box.low[a] = lattice.place(a, depth, 2 * index[a]);
    box.high[a] = lattice.place(a, depth, 2 * (index[a] + cells));
  }
  return box;
}

Spot spot_of(int depth, const std::int64_t* index) {
  return {{std::int32_t(index[0]), std::int32_t(index[1]), std::int32_t(index[2])},
          std::uint8_t(depth),
          0};
}

bool meets_any(const mesh::Box& box, std::span<const mesh::Box> boxes) {
  return std::ranges::any_of(boxes, [&](const mesh::Box& of) { return mesh::meet(box, of); });
}

} // namespace

/// Of the dual's cells behind gridlets, where their places are not kept: at which corners, if at
/// any.
static std::vector<Spot> corner_spots(const amr::CornerMap& corners, const mesh::MeshView& view) {
  std::vector<Spot> spots(std::size_t(view.pieces[1].cell_count), Spot{{}, 0, 0});
  corners.for_each([&](int depth, const std::int64_t* corner, const amr::CornerMap::Found& found) {
    if (!found.is_here())
      return;
    Spot& spot = spots[found.cell] = spot_of(depth, corner);
    spot.kind = found.kind.code;
  });
  return spots;
}

mesh::Box box_of(const mesh::Lattice& lattice, const Spot& leaf) {
  const std::int64_t index[3] = {leaf.index[0], leaf.index[1], leaf.index[2]};
  return box_of(lattice, leaf.depth, index, 1);
}

CellsKind kind_of(const Adaptive& mesh) {
  const DualCells* const dual = mesh.dual_cells();
  return !dual                         ? CellsKind::leaves_by_places
         : dual->dual().has_gridlets() ? CellsKind::dual_by_places
                                       : CellsKind::dual_cells;
}

void add_places(const Adaptive& mesh, const mesh::MeshView& view,
                std::span<const std::int64_t> cells, std::span<const mesh::Box> boxes,
                EarlierCells& to) {
  const amr::LeafMap& map = mesh.leaves();
  const DualCells* const of = mesh.dual_cells();
  to.lattice = map.lattice();
  if (!of) {
    for (const std::int64_t flat : cells) {
      const std::int32_t p = view.piece_of(flat);
      const mesh::AmrView& all = *view.pieces[p].leaves->mesh;
      const mesh::AmrCell c = all.cell(all.pieces[p], flat - view.first_cell[p]);
      to.spots.push_back(spot_of(c.depth, c.index));
    }
    return;
  }
  using Store = amr::BrickStore;
  const Store& store = map.store();
  std::vector<mesh::Box> near;
  for (std::int64_t b = 0; b < store.brick_count() && !boxes.empty(); ++b) {
    const int depth = store.depth_of(b);
    const amr::BrickKey& key = store.key(b);
    const std::int64_t first[3] = {std::int64_t(key.x) * 8, std::int64_t(key.y) * 8,
                                   std::int64_t(key.z) * 8};
    const mesh::Box brick = box_of(to.lattice, depth, first, Store::side);
    near.clear();
    std::ranges::copy_if(boxes, std::back_inserter(near),
                         [&](const mesh::Box& box) { return mesh::meet(box, brick); });
    for (int e = 0; e < Store::brick_entries && !near.empty(); ++e) {
      const std::uint32_t leaf = store.entries(b)[e];
      const std::int64_t index[3] = {first[0] + (e & 7), first[1] + (e >> 3 & 7),
                                     first[2] + (e >> 6)};
      if (Store::is_leaf(leaf) && leaf < mesh.own_cells() &&
          meets_any(box_of(to.lattice, depth, index, 1), near))
        to.leaves.push_back(spot_of(depth, index));
    }
  }
  const amr::DualMesh& dual = of->dual();
  const std::vector<Spot> at_corners =
      mesh.is_shared() ? std::vector<Spot>() : corner_spots(dual.corners(), view);
  for (const std::int64_t flat : cells) {
    if (!mesh.is_shared() && flat >= view.first_cell[1]) {
      to.spots.push_back(at_corners[std::size_t(flat - view.first_cell[1])]);
      continue;
    }
    const amr::CellPlace place = dual.place(flat);
    Spot& spot = to.spots.emplace_back(Spot{{}, place.depth, 0});
    std::int64_t corner[3];
    for (int a = 0; a < 3; ++a)
      corner[a] = spot.index[a] = place.corner[a];
    if (flat < view.first_cell[1]) {
      spot.kind = Spot::in_gridlet;
      const Gridlet& g = view.pieces[0].gridlets->gridlets[flat >> Gridlet::cell_bits];
      if (to.gridlets.empty() || key_of_gridlet(to.gridlets.back()) != key_of_gridlet(g))
        to.gridlets.push_back(g);
    } else if (const auto at = dual.corners().find(place.depth, corner);
               at && at.cell == flat - view.first_cell[1]) {
      spot.kind = at.kind.code;
    }
  }
}

GatheredDual::GatheredDual(core::Memory& memory)
    : leaves_(memory), corners_(memory), places_(memory), locator_({&places_, &corners_}) {
  view_.pieces = pieces_;
  view_.first_cell = first_cell_;
  view_.first_vertex = first_vertex_;
}

void GatheredDual::build(EarlierCells& from, const core::Threads& threads) {
  std::vector<std::int64_t> vertices; // of `from`, in this order
  add_gridlets(from, vertices);
  first_vertex_[1] = std::int64_t(vertices.size());
  add_others(from, vertices);
  first_vertex_[2] = std::int64_t(vertices.size());
  if (first_vertex_[1] > UINT32_MAX || first_vertex_[2] - first_vertex_[1] > INT32_MAX)
    throw core::Error(INSITU_ERROR_MESH, "the adaptive step before has " +
                                             std::to_string(first_vertex_[2]) +
                                             " vertices here; these cannot be numbered");
  add_corners(from, threads);
  add_leaves(from, threads);
  from.order_vertices(vertices);
  points_.assign(from.step.points.begin() + first_vertex_[1], from.step.points.end());
  set_views(from);
  places_.build(gridlets_view_, leaves_, threads);
}

/// Puts cells into the gridlets in which they were.
void GatheredDual::add_gridlets(EarlierCells& from, std::vector<std::int64_t>& vertices) {
  gridlets_ = std::move(from.gridlets);
  std::ranges::sort(gridlets_, {}, key_of_gridlet);
  const auto twice = std::ranges::unique(gridlets_, {}, key_of_gridlet);
  gridlets_.erase(twice.begin(), twice.end());
  std::int64_t count = 0;
  for (Gridlet& g : gridlets_) {
    g.first = std::uint32_t(count);
    count += g.vertex_count();
  }
  vertices.assign(std::size_t(count), -1);
  full_.assign(8 * gridlets_.size(), 0);
  mesh::GridletsView view;
  view.gridlets = gridlets_.data();
  view.count = std::int64_t(gridlets_.size());
  cubes_ = std::ranges::count(from.spots, Spot::in_gridlet, &Spot::kind);
  for (std::size_t c = 0; c < std::size_t(cubes_); ++c) { // those with gridlets come first
    const Spot& spot = from.spots[c];
    const auto g =
        std::ranges::lower_bound(gridlets_, key_of(spot.depth, spot.index), {}, key_of_gridlet);
    std::int64_t cell = (g - gridlets_.begin()) << Gridlet::cell_bits, ids[8];
    for (int a = 0; a < 3; ++a)
      cell += std::int64_t(spot.index[a] - g->lower[a]) << (3 * a);
    full_[std::size_t(cell >> 6)] |= std::uint64_t(1) << (cell & 63);
    view.vertex_ids(cell, ids);
    for (int v = 0; v < 8; ++v)
      vertices[std::size_t(ids[v])] = from.ids[std::size_t(from.offsets[c] + v)];
  }
}

void GatheredDual::add_others(const EarlierCells& from, std::vector<std::int64_t>& vertices) {
  const std::size_t first = vertices.size();
  std::vector<std::int32_t> number(from.step.points.size(), -1);
  for (auto c = std::size_t(cubes_); c < from.count(); ++c)
    for (std::int64_t k = from.offsets[c]; k < from.offsets[c] + 8; ++k) {
      if (k >= from.offsets[c + 1]) {
        ids_.push_back(-1);
        continue;
      }
      const std::int64_t id = from.ids[std::size_t(k)];
      if (number[std::size_t(id)] < 0) {
        number[std::size_t(id)] = std::int32_t(vertices.size() - first);
        vertices.push_back(id);
      }
      ids_.push_back(number[std::size_t(id)]);
    }
}

void GatheredDual::add_corners(const EarlierCells& from, const core::Threads& threads) {
  std::vector<amr::DualPart> parts(1);
  for (auto c = std::size_t(cubes_); c < from.count(); ++c) {
    const Spot& spot = from.spots[c];
    if (spot.kind != 0)
      parts[0].at_corners.push_back({{spot.index[0], spot.index[1], spot.index[2]},
                                     spot.depth,
                                     {spot.kind},
                                     std::uint32_t(c - std::size_t(cubes_))});
  }
  corners_.build(parts, {0}, threads);
}

/// Those of gridlets, too, whose bricks have to be there.
void GatheredDual::add_leaves(EarlierCells& from, const core::Threads& threads) {
  std::vector<Spot> leaves = std::move(from.leaves);
  for (std::size_t c = 0; c < std::size_t(cubes_); ++c)
    for (int v = 0; v < 8; ++v) {
      Spot leaf = from.spots[c];
      leaf.kind = 0;
      for (int a = 0; a < 3; ++a)
        leaf.index[a] += v >> a & 1;
      leaves.push_back(leaf);
    }
  std::ranges::sort(leaves, {}, key_of_leaf);
  const auto twice = std::ranges::unique(leaves, {}, key_of_leaf);
  leaves.erase(twice.begin(), twice.end());
  build_map(from.lattice, leaves, threads, leaves_);
}

void GatheredDual::set_views(const EarlierCells& from) {
  gridlets_view_.lattice = from.lattice;
  gridlets_view_.gridlets = gridlets_.data();
  gridlets_view_.count = std::int64_t(gridlets_.size());
  gridlets_view_.full = full_.data();
  pieces_[0].layout = mesh::CellLayout::gridlets;
  pieces_[0].uniform_shape = mesh::Shape::voxel;
  pieces_[0].cell_count = gridlets_view_.count * Gridlet::most_cells;
  pieces_[0].gridlets = &gridlets_view_;
  mesh::PieceView& others = pieces_[1];
  others.layout = mesh::CellLayout::padded;
  others.uniform_shape = mesh::Shape::hexahedron;
  others.cell_count = std::int64_t(ids_.size() / 8);
  others.connectivity.data = reinterpret_cast<const std::byte*>(ids_.data());
  others.connectivity.count = others.cell_count;
  others.connectivity.stride = 8 * sizeof(std::int32_t);
  others.id_stride = sizeof(std::int32_t);
  for (int a = 0; a < 3; ++a)
    others.points.component[a] =
        reinterpret_cast<const std::byte*>(points_.data()) + std::size_t(a) * sizeof(double);
  others.points.layout.count = std::int64_t(points_.size());
  others.points.layout.stride[0] = sizeof(math::Vec3d);
  for (int p = 0; p < 2; ++p) {
    pieces_[p].vertex_count = first_vertex_[p + 1] - first_vertex_[p];
    first_cell_[p + 1] = first_cell_[p] + pieces_[p].cell_count;
  }
  view_.piece_count = 2;
  view_.set_plane(from.lattice);
  view_.free_of_folds = view_.covers_once = true;
}

void GatheredDual::share(const DualReach& here, parallel::World& world) {
  if (here.corners) {
    corners_.reach_as(*here.corners);
    places_.reach_as(*here.places);
  }
  corners_.share(world);
  places_.share_farthest(world);
}

GatheredLeaves::GatheredLeaves(const EarlierCells& from, core::Memory& memory,
                               const core::Threads& threads)
    : leaves_(memory), locator_(leaves_) {
  build_map(from.lattice, from.spots, threads, leaves_);
  leaves_.number_bricks(threads);
  copy_ = std::make_unique<LeavesCopy>(
      leaves_, std::vector<std::int64_t>{0, std::int64_t(from.count())}, memory, threads);
}

} // namespace insitu::commit
