#include "adaptive_meshes.h"

#include <algorithm>
#include <numeric>

#include "amr/dual/dual_cells.h"

namespace insitu::bench {

namespace {

std::unique_ptr<commit::CommittedMesh> adaptive(double spacing, int level_count,
                                                insitu_reconstruction reconstruction,
                                                core::Memory& memory) {
  auto out = std::make_unique<commit::CommittedMesh>("amr", memory);
  insitu_amr amr = insitu_amr_default();
  for (double& h : amr.spacing)
    h = spacing;
  amr.level_count = level_count;
  amr.reconstruction = reconstruction;
  out->mesh().set_amr(&amr);
  return out;
}

} // namespace

std::unique_ptr<commit::CommittedMesh> register_patches(const workload::AmrMesh& blocks,
                                                        insitu_reconstruction reconstruction,
                                                        core::Memory& memory) {
  auto out = adaptive(blocks.spacing, blocks.level_count, reconstruction, memory);
  const std::int64_t n = blocks.cells_a_block();
  for (std::size_t b = 0; b < blocks.blocks.size(); ++b) {
    insitu_patch patch = insitu_patch_default();
    patch.level = blocks.blocks[b].level;
    for (int a = 0; a < 3; ++a) {
      patch.lower[a] = blocks.blocks[b].lower[a];
      patch.cells[a] = blocks.side;
    }
    const auto piece = std::int32_t(b);
    out->mesh().set_patch(piece, &patch);
    const insitu_array values =
        insitu_array_of(blocks.values.data() + b * std::size_t(n), INSITU_FLOAT64, n, 1);
    out->mesh().set_field(piece, "f", INSITU_CELL, &values, 1);
  }
  return out;
}

std::unique_ptr<commit::CommittedMesh> register_leaves(const workload::AmrLeaves& leaves,
                                                       double spacing, int level_count,
                                                       insitu_reconstruction reconstruction,
                                                       core::Memory& memory) {
  auto out = adaptive(spacing, level_count, reconstruction, memory);
  insitu_leaves registered = insitu_leaves_default();
  const auto n = std::int64_t(leaves.levels.size());
  registered.levels = insitu_array_of(leaves.levels.data(), INSITU_INT32, n, 1);
  registered.corners = insitu_array_of(leaves.corners.data(), INSITU_INT32, n, 3);
  out->mesh().set_leaves(0, &registered);
  const insitu_array values = insitu_array_of(leaves.values.data(), INSITU_FLOAT64, n, 1);
  out->mesh().set_field(0, "f", INSITU_CELL, &values, 1);
  return out;
}

CubeBytes cube_bytes(const mesh::MeshView& dual, std::int64_t cubes) {
  const mesh::GridletsView& g = *dual.pieces[0].gridlets;
  std::vector<std::uint32_t> bound;
  std::int64_t scalars = 0;
  for (std::int64_t i = 0; i < g.count; ++i) {
    const std::int64_t first = g.gridlets[i].first, n = g.gridlets[i].vertex_count();
    scalars += n;
    for (std::int64_t v = first; v < first + n; ++v)
      if (g.leaves[v] != mesh::GridletsView::no_leaf)
        bound.push_back(g.leaves[v]);
  }
  std::sort(bound.begin(), bound.end());
  const auto vertices = std::unique(bound.begin(), bound.end()) - bound.begin();
  return {16.0 * double(vertices) + 32.0 * double(cubes),
          32.0 * double(g.count) + 4.0 * double(scalars)};
}

DualStatistics statistics_of(const mesh::MeshView& dual) {
  DualStatistics out;
  const mesh::GridletsView& g = *dual.pieces[0].gridlets;
  out.gridlets = g.count;
  for (std::int64_t i = 0; i < g.count; ++i) {
    const mesh::Gridlet& one = g.gridlets[i];
    std::int64_t full = 0;
    for (int cell = 0; cell < mesh::Gridlet::most_cells; ++cell)
      full += g.is_full((i << mesh::Gridlet::cell_bits) + cell);
    out.full_cells += full;
    out.empty_cells += std::int64_t(one.size[0]) * one.size[1] * one.size[2] - full;
    for (std::int64_t v = one.first; v < one.first + one.vertex_count(); ++v)
      ++(g.leaves[v] != mesh::GridletsView::no_leaf ? out.full_scalars : out.empty_scalars);
  }
  const mesh::PieceView& stitching = dual.pieces[1];
  out.vertices = stitching.vertex_count;
  mesh::CellVertices cell;
  for (std::int64_t c = 0; c < stitching.cell_count; ++c) {
    mesh::gather(dual, dual.first_cell[1] + c, cell);
    const int n = cell.count;
    ++(n == 4 ? out.tetrahedra : n == 5 ? out.pyramids : n == 6 ? out.wedges : out.hexahedra);
    out.folded += amr::folds(cell.shape, cell.x);
  }
  return out;
}

PlainDual plain_dual(const commit::CommittedMesh& mesh) {
  const mesh::MeshView& dual = mesh.mesh().view();
  const mesh::FieldView field = mesh.mesh().field("f");
  const mesh::PieceView &gridlets = dual.pieces[0], &stitching = dual.pieces[1];
  PlainDual out;
  // A vertex a leaf for cubes, then those of stitching cells.
  std::vector<std::int32_t> number(std::size_t(mesh.mesh().own_view().cell_count()), -1);
  const auto vertex = [&](const math::Vec3d& p, double value) {
    for (int a = 0; a < 3; ++a)
      out.points.push_back(p[a]);
    out.values.push_back(value);
    return std::int32_t(out.values.size() - 1);
  };
  mesh::CellVertices cell;
  for (std::int64_t c = 0; c < gridlets.cell_count; ++c) {
    if (!gridlets.owns(c))
      continue;
    mesh::gather(dual, c, cell);
    constexpr int order[8] = {0, 1, 3, 2, 4, 5, 7, 6}; // a voxel's as a hexahedron's
    for (const int v : order) {
      std::int32_t& n = number[gridlets.gridlets->leaves[cell.ids[v]]];
      if (n < 0)
        n = vertex(cell.x[v], field.pieces[0].load(cell.ids[v], 0));
      out.connectivity.push_back(n);
    }
  }
  const auto first = std::int32_t(out.values.size());
  for (std::int64_t v = 0; v < stitching.vertex_count; ++v)
    vertex(stitching.point(v), field.pieces[1].load(v, 0));
  for (std::int64_t c = 0; c < stitching.cell_count; ++c) {
    std::int64_t ids[8];
    const int n = stitching.vertex_ids(c, ids);
    for (int v = 0; v < 8; ++v)
      out.connectivity.push_back(v < n ? first + std::int32_t(ids[v]) : -1);
  }
  return out;
}

PlainDual welded(const PlainDual& plain) {
  PlainDual out;
  const std::size_t n = plain.values.size();
  const auto place = [&](std::size_t v) { return &plain.points[3 * v]; };
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::lexicographical_compare(place(a), place(a) + 3, place(b), place(b) + 3);
  });
  std::vector<std::int32_t> number(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t v = order[i];
    if (i == 0 || !std::equal(place(v), place(v) + 3, place(order[i - 1]))) {
      out.points.insert(out.points.end(), place(v), place(v) + 3);
      out.values.push_back(plain.values[v]);
    }
    number[v] = std::int32_t(out.values.size() - 1);
  }
  for (const std::int32_t v : plain.connectivity)
    out.connectivity.push_back(v < 0 ? v : number[std::size_t(v)]);
  return out;
}

std::unique_ptr<commit::CommittedMesh> register_plain(const PlainDual& plain,
                                                      core::Memory& memory) {
  auto out = std::make_unique<commit::CommittedMesh>("plain", memory);
  const auto count = std::int64_t(plain.values.size());
  const insitu_array points = insitu_array_of(plain.points.data(), INSITU_FLOAT64, count, 3);
  out->mesh().set_points(0, &points, 1);
  insitu_cells cells = insitu_cells_default();
  cells.layout = INSITU_LAYOUT_PADDED;
  cells.count = plain.cells();
  cells.connectivity = insitu_array_of(plain.connectivity.data(), INSITU_INT32, cells.count, 8);
  out->mesh().set_cells(0, &cells);
  const insitu_array values = insitu_array_of(plain.values.data(), INSITU_FLOAT64, count, 1);
  out->mesh().set_field(0, "f", INSITU_VERTEX, &values, 1);
  return out;
}

} // namespace insitu::bench
