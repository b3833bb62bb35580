#include "commit/earlier/adaptive_cells.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>

#include "commit/earlier/gathered_adaptive.h"

namespace insitu::commit {

using mesh::Gridlet;

namespace {

/// The brick of a gridlet, or of a cell in one.
using Brick = std::array<std::int32_t, 4>;
Brick brick_of(int depth, const std::int32_t* index) {
  return {depth, index[0] >> 3, index[1] >> 3, index[2] >> 3};
}
bool is_in(const Gridlet& g, const Spot& cell) {
  return brick_of(g.depth, g.lower) == brick_of(cell.depth, cell.index);
}

/// Of all vertices, or of the cells, which are leaves.
std::vector<double> values_of(const mesh::EarlierStep::Field& field,
                              const std::vector<mesh::CellName>& leaves) {
  const std::vector<double>& all = field.steps.front();
  if (field.association != INSITU_CELL)
    return all;
  std::vector<double> values;
  for (const mesh::CellName& leaf : leaves)
    for (std::int64_t c = 0; c < field.components; ++c)
      values.push_back(all[std::size_t(leaf.cell * field.components + c)]);
  return values;
}

} // namespace

mesh::CellName name_of(const Adaptive& mesh, const EarlierMesh::Own& own, std::int64_t flat) {
  if (mesh.dual_cells())
    return {mesh.number(flat), -1, 0, 0};
  return {own.global.empty() ? -1 : own.global[std::size_t(flat)], -1, 0, flat};
}

AdaptiveCells::AdaptiveCells(const Adaptive& mesh, const mesh::MeshView& view,
                             const EarlierMesh::Own& own)
    : kind_(kind_of(mesh)) {
  const bool is_dual = mesh.dual_cells() != nullptr;
  std::vector<std::int64_t> cells;
  for (std::int64_t flat = 0; flat < own.cells; ++flat) {
    const std::int32_t p = view.piece_of(flat);
    const mesh::PieceView& piece = view.pieces[p];
    const std::int64_t cell = flat - view.first_cell[p];
    if (!piece.owns(cell))
      continue;
    cells.push_back(flat);
    cells_.names.push_back(name_of(mesh, own, flat));
    cells_.types.push_back(std::uint8_t(piece.shape(cell)));
    if (!is_dual || piece.gridlets)
      continue;
    std::int64_t ids[8];
    const int n = piece.vertex_ids(cell, ids);
    for (int v = 0; v < n; ++v)
      cells_.ids.push_back(view.first_vertex[p] + ids[v]);
  }
  if (is_dual) {
    in_gridlets_ = view.first_vertex[1];
    for (std::int64_t v = 0; v < view.pieces[1].vertex_count; ++v)
      cells_.step.points.push_back(view.pieces[1].point(v));
  }
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const mesh::Box everywhere{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
  cells_.lattice = mesh.leaves().lattice();
  if (kind_ != CellsKind::dual_cells)
    add_places(mesh, view, cells, std::span(&everywhere, 1), cells_);
}

void AdaptiveCells::keep(core::Archive& archive) {
  mesh::Lattice& lattice = cells_.lattice;
  archive.value("adaptive cells are found", kind_);
  archive.array("adaptive cells", cells_.names);
  archive.array("types", cells_.types);
  archive.array("vertex ids", cells_.ids);
  archive.array("vertices behind gridlets'", cells_.step.points);
  archive.value("vertices of gridlets", in_gridlets_);
  archive.array("spots", cells_.spots);
  archive.array("gridlets", cells_.gridlets);
  archive.array("leaves", cells_.leaves);
  for (int a = 0; a < 3; ++a) {
    archive.value("origin", lattice.origin[a]);
    archive.value("spacing", lattice.spacing[a]);
  }
  archive.value("plane", lattice.plane);
  archive.value("is flat", lattice.is_flat);
}

/// The ids and points of all.
void AdaptiveCells::add_vertices(EarlierCells& to) const {
  mesh::GridletsView gridlets;
  gridlets.lattice = cells_.lattice;
  gridlets.gridlets = cells_.gridlets.data();
  to.ids.clear();
  std::size_t g = 0; // ascending with the cells
  auto id = cells_.ids.begin();
  for (std::size_t c = 0; c < cells_.count(); ++c) {
    if (!cells_.spots.empty() && cells_.spots[c].kind == Spot::in_gridlet) {
      while (!is_in(cells_.gridlets[g], cells_.spots[c]))
        ++g;
      std::int64_t cell = std::int64_t(g) << Gridlet::cell_bits, ids[8];
      for (int a = 0; a < 3; ++a)
        cell += std::int64_t(cells_.spots[c].index[a] - cells_.gridlets[g].lower[a]) << (3 * a);
      gridlets.vertex_ids(cell, ids);
      to.ids.insert(to.ids.end(), ids, ids + 8);
    } else if (kind_ != CellsKind::leaves_by_places) {
      const int n = mesh::vertex_count(mesh::Shape(cells_.types[c]));
      to.ids.insert(to.ids.end(), id, id + n);
      id += n;
    }
    to.offsets.push_back(std::int64_t(to.ids.size()));
  }
  to.step.points.assign(std::size_t(in_gridlets_), math::Vec3d{});
  for (const Gridlet& of : cells_.gridlets)
    for (std::int64_t v = 0; v < of.vertex_count(); ++v) {
      const std::int64_t ni = of.size[0] + 1, nj = of.size[1] + 1;
      to.step.points[std::size_t(of.first + v)] = {gridlets.coordinate(of, 0, int(v % ni)),
                                                   gridlets.coordinate(of, 1, int(v / ni % nj)),
                                                   gridlets.coordinate(of, 2, int(v / (ni * nj)))};
    }
  to.step.points.insert(to.step.points.end(), cells_.step.points.begin(), cells_.step.points.end());
}

EarlierCells AdaptiveCells::with(const mesh::EarlierStep& step, int process) const {
  EarlierCells all = cells_;
  for (mesh::CellName& name : all.names)
    name.rank = name.piece = process; // the rank becomes that of the process that tells it
  add_vertices(all);
  for (const mesh::EarlierStep::Field& field : step.fields)
    if (!field.steps.empty())
      all.step.fields.push_back(
          {field.name, field.association, field.components, {values_of(field, all.names)}});
  return all;
}

EarlierCells EarlierCells::in(std::span<const mesh::Box> boxes) const {
  EarlierCells some;
  some.lattice = lattice;
  std::vector<std::size_t> cells, vertices;
  std::vector<std::int64_t> number(step.points.size(), -1);
  const auto meets = [&](const mesh::Box& box) {
    return std::ranges::any_of(boxes, [&](const mesh::Box& of) { return mesh::meet(of, box); });
  };
  for (std::size_t c = 0; c < count(); ++c) {
    const std::span<const std::int64_t> of(ids.data() + offsets[c], ids.data() + offsets[c + 1]);
    mesh::Box box =
        of.empty() ? box_of(lattice, spots[c])
                   : mesh::Box{step.points[std::size_t(of[0])], step.points[std::size_t(of[0])]};
    for (const std::int64_t v : of)
      box.extend({step.points[std::size_t(v)], step.points[std::size_t(v)]});
    if (!meets(box))
      continue;
    cells.push_back(c);
    some.names.push_back(names[c]);
    some.types.push_back(types[c]);
    if (!spots.empty())
      some.spots.push_back(spots[c]);
    for (const std::int64_t v : of) {
      std::int64_t& n = number[std::size_t(v)];
      if (n < 0) {
        n = std::int64_t(vertices.size());
        vertices.push_back(std::size_t(v));
        some.step.points.push_back(step.points[std::size_t(v)]);
      }
      some.ids.push_back(n);
    }
    some.offsets.push_back(std::int64_t(some.ids.size()));
  }
  std::vector<Brick> bricks;
  for (const Spot& cell : some.spots)
    if (const Brick brick = brick_of(cell.depth, cell.index);
        cell.kind == Spot::in_gridlet && (bricks.empty() || bricks.back() != brick))
      bricks.push_back(brick);
  std::ranges::sort(bricks);
  std::ranges::copy_if(gridlets, std::back_inserter(some.gridlets), [&](const Gridlet& g) {
    return std::ranges::binary_search(bricks, brick_of(g.depth, g.lower));
  });
  std::ranges::copy_if(leaves, std::back_inserter(some.leaves),
                       [&](const Spot& leaf) { return meets(box_of(lattice, leaf)); });
  for (const mesh::EarlierStep::Field& field : step.fields) {
    std::vector<double> values;
    const auto n = std::size_t(field.components);
    for (const std::size_t item : field.association == INSITU_CELL ? cells : vertices)
      values.insert(values.end(), field.steps.front().begin() + std::ptrdiff_t(item * n),
                    field.steps.front().begin() + std::ptrdiff_t((item + 1) * n));
    some.step.fields.push_back({field.name, field.association, field.components, {values}});
  }
  return some;
}

} // namespace insitu::commit
