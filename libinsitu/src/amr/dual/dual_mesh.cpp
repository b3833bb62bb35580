#include "amr/dual/dual_mesh.h"

#include <algorithm>
#include <utility>

#include "amr/dual/dual_parts.h"
#include "amr/dual/stitching.h"
#include "amr/dual/whole_gridlets.h"
#include "amr/values/vertex_values.h"
#include "core/status.h"

namespace insitu::amr {

using mesh::Gridlet;

struct DualMesh::State {
  explicit State(core::Memory& m)
      : memory(m), map(m), gridlets(m, INSITU_MEMORY_AMR), full(m, INSITU_MEMORY_AMR),
        leaves(m, INSITU_MEMORY_AMR), stitching(m), values(m) {}

  void clear();
  void gather(const std::vector<DualPart>& parts, const core::Threads& threads);
  void make_view();
  void finish(DualParts& dual, const mesh::AmrView& mesh, bool with_places,
              const core::Threads& threads);

  core::Memory& memory;
  LeafMap map;
  DualCounts counts;
  core::Buffer<Gridlet> gridlets;
  core::Buffer<std::uint64_t> full;
  core::Buffer<std::uint32_t> leaves;
  Stitching stitching;
  VertexValues values;
  std::int64_t first_virtual = 0; ///< id
  bool has_gridlets = true;
  mesh::GridletsView gridlets_view;
  mesh::PieceView pieces[2];
  std::int64_t first_cell[3] = {0, 0, 0}, first_vertex[3] = {0, 0, 0};
  mesh::MeshView view;
};

namespace {

void count_cells(const std::vector<DualPart>& parts, DualCounts& counts) {
  for (const DualPart& part : parts) {
    counts.cubes += part.cubes;
    counts.empty += part.empty;
    for (const DualCell& c : part.cells) {
      counts.boundary += c.boundary;
      switch (c.shape) {
      case mesh::Shape::tetrahedron:
        ++counts.tetrahedra;
        break;
      case mesh::Shape::pyramid:
        ++counts.pyramids;
        break;
      case mesh::Shape::wedge:
        ++counts.wedges;
        break;
      default:
        ++(c.distinct == 8 ? counts.hexahedra : counts.collapsed);
      }
    }
  }
}

} // namespace

void DualMesh::State::clear() {
  counts = {};
  gridlets.resize_discard(0);
  full.resize_discard(0);
  leaves.resize_discard(0);
  stitching.clear();
  values.clear();
  make_view();
}

/// Copies the parts' gridlets together.
void DualMesh::State::gather(const std::vector<DualPart>& parts, const core::Threads& threads) {
  std::vector<std::size_t> first_gridlet(parts.size() + 1, 0), first_leaf(parts.size() + 1, 0);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    first_gridlet[p + 1] = first_gridlet[p] + parts[p].gridlets.size();
    first_leaf[p + 1] = first_leaf[p] + parts[p].leaves.size();
  }
  if (first_leaf.back() > UINT32_MAX)
    throw core::Error(INSITU_ERROR_MESH, "the gridlets of an adaptive mesh have " +
                                             std::to_string(first_leaf.back()) +
                                             " vertices; at most 2^32 - 1 can be numbered");
  gridlets.resize_discard(first_gridlet.back());
  full.resize_discard(8 * first_gridlet.back());
  leaves.resize_discard(first_leaf.back());
  threads.parallel_for(std::int64_t(parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::size_t p = std::size_t(begin); p < std::size_t(end); ++p) {
      std::copy(parts[p].full.begin(), parts[p].full.end(), full.begin() + 8 * first_gridlet[p]);
      std::copy(parts[p].leaves.begin(), parts[p].leaves.end(), leaves.begin() + first_leaf[p]);
      for (std::size_t g = 0; g < parts[p].gridlets.size(); ++g) {
        Gridlet copy = parts[p].gridlets[g];
        copy.first += std::uint32_t(first_leaf[p]);
        gridlets[first_gridlet[p] + g] = copy;
      }
    }
  });
  counts.gridlets = std::int64_t(gridlets.size());
  counts.scalars = std::int64_t(leaves.size());
}

void DualMesh::State::make_view() {
  gridlets_view.lattice = map.lattice();
  gridlets_view.gridlets = gridlets.data();
  gridlets_view.count = std::int64_t(gridlets.size());
  gridlets_view.leaves = leaves.data();
  gridlets_view.full = full.data();
  pieces[0] = {};
  pieces[0].layout = mesh::CellLayout::gridlets;
  pieces[0].uniform_shape = mesh::Shape::voxel;
  pieces[0].cell_count = gridlets_view.count * Gridlet::most_cells;
  pieces[0].vertex_count = std::int64_t(leaves.size());
  pieces[0].gridlets = &gridlets_view;
  pieces[1] = stitching.piece();
  for (int p = 0; p < 2; ++p) {
    first_cell[p + 1] = first_cell[p] + pieces[p].cell_count;
    first_vertex[p + 1] = first_vertex[p] + pieces[p].vertex_count;
  }
  view = {};
  view.pieces = pieces;
  view.first_cell = first_cell;
  view.first_vertex = first_vertex;
  view.piece_count = 2;
  view.set_plane(map.lattice());
}

bool gridlets_pay(const DualCounts& counts) {
  constexpr std::int64_t stitching_a_cube = 3, least = 1 << 15; // see doc/notes/amr.md
  return counts.stitching() < std::max(stitching_a_cube * counts.cubes, least);
}

namespace {

CellPlace place_of(const Gridlet& g, int local) {
  CellPlace place{{}, g.depth, 0, 0, 1};
  for (int a = 0; a < 3; ++a)
    place.corner[a] = g.lower[a] + (local >> (3 * a) & 7);
  return place;
}

/// Makes the cubes of a part's gridlets cells of another part.
DualPart cubes_as_cells(DualPart& part, bool with_places) {
  DualPart out;
  out.places.reserve(with_places ? std::size_t(part.cubes) : 0);
  constexpr int order[8] = {0, 1, 3, 2, 4, 5, 7, 6}; // from a voxel's vertices to a hexahedron's
  const mesh::GridletsView gridlets{{},
                                    part.gridlets.data(),
                                    std::int64_t(part.gridlets.size()),
                                    part.leaves.data(),
                                    part.full.data()};
  out.cells.reserve(std::size_t(part.cubes));
  for (std::int64_t cell = 0; cell < gridlets.count * Gridlet::most_cells; ++cell) {
    if (!gridlets.is_full(cell))
      continue;
    std::int64_t ids[8];
    gridlets.vertex_ids(cell, ids);
    DualCell cube{{}, {}, mesh::Shape::hexahedron, 8, false};
    for (int v = 0; v < 8; ++v)
      cube.leaves[v] = part.leaves[std::size_t(ids[order[v]])];
    out.cells.push_back(cube);
    if (with_places)
      out.places.push_back(place_of(part.gridlets[std::size_t(cell >> Gridlet::cell_bits)],
                                    int(cell & (Gridlet::most_cells - 1))));
  }
  part.gridlets = {};
  part.full = {};
  part.leaves = {};
  part.cubes = part.empty = 0;
  return out;
}

/// Behind all others, so that the order of cells does not depend on how bricks are grouped.
void turn_cubes_into_cells(std::vector<DualPart>& parts, bool with_places,
                           const core::Threads& threads) {
  const std::size_t count = parts.size();
  parts.resize(2 * count);
  threads.parallel_for(std::int64_t(count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto p = std::size_t(begin); p < std::size_t(end); ++p)
      parts[count + p] = cubes_as_cells(parts[p], with_places);
  });
}

/// Whether gridlets pay on all processes, of which some may have no leaves; each cell is counted
/// where the leaf of its first vertex is. Of flat meshes no cell has eight leaves.
bool gridlets_pay_everywhere(const DualParts& dual, const SharedLeaves& shared) {
  std::int64_t counts[3] = {0, 0, shared.mesh.lattice.is_flat}; // cubes, others, flat meshes
  const std::int64_t own = shared.mesh.own_cell_count();
  const auto real = [&](std::uint32_t leaf) {
    const std::int64_t n = std::int64_t(leaf) - dual.made.first;
    return n < 0 ? leaf : dual.made.leaves[std::size_t(n)].real_id;
  };
  for (const DualPart& part : dual.parts) {
    const mesh::GridletsView gridlets{{},
                                      part.gridlets.data(),
                                      std::int64_t(part.gridlets.size()),
                                      part.leaves.data(),
                                      part.full.data()};
    for (std::int64_t cell = 0; cell < gridlets.count * Gridlet::most_cells; ++cell)
      if (gridlets.is_full(cell)) {
        std::int64_t ids[8];
        gridlets.vertex_ids(cell, ids);
        counts[0] += part.leaves[std::size_t(ids[0])] < own;
      }
    for (const DualCell& c : part.cells)
      counts[1] +=
          real(c.moves[0] == mean_moves ? part.means[c.leaves[0]].leaves[0] : c.leaves[0]) < own;
  }
  shared.world.reduce(counts, parallel::Reduction::sum);
  DualCounts all;
  all.cubes = counts[0];
  all.hexahedra = counts[1];
  return counts[2] == 0 && gridlets_pay(all);
}

} // namespace

/// Makes what points are located in of the parts.
void DualMesh::State::finish(DualParts& dual, const mesh::AmrView& mesh, bool with_places,
                             const core::Threads& threads) {
  if (!has_gridlets) {
    turn_cubes_into_cells(dual.parts, with_places, threads);
    counts.hexahedra += std::exchange(counts.cubes, 0);
    counts.empty = 0;
  }
  gather(dual.parts, threads);
  stitching.build(dual.parts, mesh, dual.made, has_gridlets, threads);
  values.build(map.store(), mesh, dual.made, stitching.means(), stitching.take_on_boundary(),
               threads);
  counts.leaves = map.leaf_count();
  counts.masked = map.masked_count();
  counts.folded = dual.folded;
  counts.repaired = std::int64_t(dual.made.leaves.size());
  counts.still_folded = dual.still_folded;
  make_view();
  view.free_of_folds = view.covers_once = counts.still_folded == 0;
}

DualMesh::DualMesh(core::Memory& memory) : state_(std::make_unique<State>(memory)) {
  state_->make_view();
}
DualMesh::~DualMesh() = default;

void DualMesh::build(const mesh::AmrView& mesh, const core::Threads& threads, Cubes cubes,
                     const SharedLeaves* shared) {
  State& s = *state_;
  s.clear();
  try {
    amr::agree_after(shared, [&] {
      s.map.build(mesh, threads);
      s.first_virtual = mesh.cell_count();
    });
    DualParts dual =
        make_dual_parts(s.map.store(), s.map.lattice(), s.first_virtual, s.memory, threads, shared);
    amr::agree_after(shared, [&] { count_cells(dual.parts, s.counts); });
    if (cubes != Cubes::counts)
      s.has_gridlets = cubes == Cubes::gridlets;
    else if (shared)
      s.has_gridlets = gridlets_pay_everywhere(dual, *shared);
    else
      s.has_gridlets = mesh.lattice.is_flat == 0 && gridlets_pay(s.counts);
    if (shared && s.has_gridlets)
      make_gridlets_whole(dual.parts, s.map.store(), dual.made, *shared);
    amr::agree_after(shared, [&] { s.finish(dual, mesh, shared != nullptr, threads); });
    if (shared)
      s.stitching.corners().share(shared->world);
  } catch (...) {
    s.clear();
    throw;
  }
}

void DualMesh::set_foreign(const std::uint64_t* of_gridlets, const std::uint64_t* of_others) {
  state_->pieces[0].foreign = of_gridlets;
  state_->pieces[1].foreign = of_others;
}

CellPlace DualMesh::place(std::int64_t cell) const {
  const std::int64_t others = cell - state_->first_cell[1];
  if (others >= 0)
    return state_->stitching.places()[std::size_t(others)];
  return place_of(state_->gridlets[std::size_t(cell >> Gridlet::cell_bits)],
                  int(cell & (Gridlet::most_cells - 1)));
}

const LeafMap& DualMesh::leaves() const {
  return state_->map;
}
bool DualMesh::has_gridlets() const {
  return state_->has_gridlets;
}
const CornerMap& DualMesh::corners() const {
  return state_->stitching.corners();
}
const DualCounts& DualMesh::counts() const {
  return state_->counts;
}
std::int64_t DualMesh::bytes() const {
  const State& s = *state_;
  return s.map.bytes() + s.stitching.bytes() + s.values.bytes() +
         std::int64_t(s.gridlets.bytes() + s.full.bytes() + s.leaves.bytes());
}
const mesh::MeshView& DualMesh::view() const {
  return state_->view;
}

DualMesh::Terms DualMesh::terms(std::int64_t vertex) const {
  const std::uint32_t* leaf = state_->stitching.leaves() + vertex;
  if (*leaf < state_->first_virtual)
    return {leaf, nullptr, nullptr, 1};
  const std::int64_t n = *leaf - state_->first_virtual;
  const VertexValues& values = state_->values;
  return {values.leaves(n), values.weights(n), values.ghosts(n), values.count(n)};
}

} // namespace insitu::amr
