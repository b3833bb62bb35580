#include "commit/standins/dual_cells.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "amr/values/leaf_gradient.h"

namespace insitu::commit {

namespace {

constexpr std::int64_t grain = 1 << 13; ///< vertices a task

/// Reads values of cells by flat id, neighbours of which mostly lie in one piece.
class CellValues {
public:
  CellValues(const mesh::AmrView& amr, const mesh::MeshView& mesh, const mesh::FieldView& field)
      : amr_(&amr), mesh_(&mesh), field_(&field) {}
  double load(std::int64_t flat, int component) {
    find(flat);
    return field_->pieces[piece_].load(flat - mesh_->first_cell[piece_], component);
  }
  /// Of the ghost cell across a face.
  double load_ghost(std::int64_t flat, int face, int component) {
    find(flat);
    const std::int64_t cell = flat - mesh_->first_cell[piece_];
    if (const std::int32_t* const items = amr_->pieces[piece_].ghost_items)
      return field_->pieces[piece_].load(items[6 * cell + face], component);
    return field_->pieces[piece_].load_ghost(cell, component, face);
  }

private:
  void find(std::int64_t flat) {
    if (flat < mesh_->first_cell[piece_] || flat >= mesh_->first_cell[piece_ + 1])
      piece_ = mesh_->piece_of(flat);
  }

  const mesh::AmrView* amr_;
  const mesh::MeshView* mesh_;
  const mesh::FieldView* field_;
  std::int32_t piece_ = 0;
};

} // namespace

struct DualCells::Gathered {
  explicit Gathered(core::Memory& memory) : bytes(memory, INSITU_MEMORY_GATHERED) {}

  std::string name;
  int components = 0;
  bool fresh = false;
  core::Buffer<std::byte> bytes; ///< [vertex of any piece][component]
  std::vector<const std::byte*> bases;
  std::vector<mesh::FieldPieceView> views;
};

DualCells::DualCells(core::Memory& memory)
    : memory_(&memory), dual_(memory),
      places_(memory), foreign_{core::Buffer<std::uint64_t>(memory, INSITU_MEMORY_AMR),
                                core::Buffer<std::uint64_t>(memory, INSITU_MEMORY_AMR)} {}

DualCells::~DualCells() = default;

void DualCells::build(const mesh::Mesh& mesh, const core::Threads& threads, amr::Cubes cubes,
                      const Neighbours* neighbours) {
  own_ = &mesh.own_view();
  amr_ = &mesh.adaptive();
  threads_ = &threads;
  fields_.clear();
  std::optional<amr::SharedLeaves> shared;
  if (neighbours)
    shared.emplace(amr::SharedLeaves{neighbours->world, mesh.adaptive(), neighbours->lent,
                                     neighbours->outermost});
  dual_.build(mesh.adaptive(), threads, cubes, shared ? &*shared : nullptr);
  amr::agree_after(shared ? &*shared : nullptr, [&] {
    if (dual_.has_gridlets())
      places_.build(*dual_.view().pieces[0].gridlets, dual_.leaves(), threads);
    else
      places_.release();
    if (neighbours)
      find_owners(*neighbours);
  });
  if (!neighbours)
    return;
  if (dual_.has_gridlets())
    places_.share_farthest(neighbours->world);
  order_.build(dual_, neighbours->world);
}

int DualCells::leaves_of(std::int64_t flat, std::uint32_t* leaves) const {
  const mesh::MeshView& dual = dual_.view();
  const std::int32_t p = dual.piece_of(flat);
  const mesh::PieceView& piece = dual.pieces[p];
  std::int64_t ids[8];
  const int n = piece.vertex_ids(flat - dual.first_cell[p], ids);
  for (int v = 0; v < n; ++v)
    leaves[v] = piece.gridlets ? piece.gridlets->leaves[ids[v]] : dual_.leaf_at(ids[v]);
  return n;
}

std::uint32_t
DualCells::first_leaf(std::int64_t flat,
                      core::FunctionRef<bool(std::uint32_t, std::uint32_t)> is_before) const {
  std::uint32_t leaves[8];
  const int n = leaves_of(flat, leaves);
  for (int v = 1; v < n; ++v)
    if (leaves[v] != leaves[0] && is_before(leaves[v], leaves[0]))
      leaves[0] = leaves[v];
  return leaves[0];
}

/// A cell is where the first of its leaves is.
void DualCells::find_owners(const Neighbours& neighbours) {
  const mesh::MeshView& dual = dual_.view();
  const std::int64_t own = amr_->own_cell_count();
  const auto is_foreign = [&](std::int64_t flat) {
    std::uint32_t leaves[8];
    const int n = leaves_of(flat, leaves);
    return std::any_of(leaves, leaves + n, [&](std::uint32_t leaf) { return leaf >= own; }) &&
           first_leaf(flat, neighbours.is_before) >= own;
  };
  for (std::int32_t p = 0; p < 2; ++p) {
    const mesh::PieceView& piece = dual.pieces[p];
    core::Buffer<std::uint64_t>& bits = foreign_[p];
    bits.resize_discard(std::size_t((piece.cell_count + 63) / 64));
    threads_->parallel_for(std::int64_t(bits.size()), 64,
                           [&](std::int64_t begin, std::int64_t end) {
                             for (std::int64_t word = begin; word < end; ++word) {
                               bits[std::size_t(word)] = 0;
                               for (std::int64_t cell = 64 * word;
                                    cell < std::min(64 * word + 64, piece.cell_count); ++cell)
                                 if (piece.exists(cell) && is_foreign(dual.first_cell[p] + cell))
                                   bits[std::size_t(word)] |= std::uint64_t(1) << (cell & 63);
                             }
                           });
  }
  dual_.set_foreign(foreign_[0].data(), foreign_[1].data());
}

void DualCells::fields_changed() {
  fields_.values_changed();
}

mesh::FieldView DualCells::field(const mesh::FieldView& own) {
  const Gathered& g = fields_.find(
      own, [&] { return std::make_unique<Gathered>(*memory_); },
      [&](Gathered& to) { gather(own, to); });
  return {g.name.c_str(), INSITU_VERTEX, g.components, g.views.data()};
}

void DualCells::gather(const mesh::FieldView& own, Gathered& to) const {
  const mesh::MeshView& dual = dual_.view();
  const int n = to.components = own.components;
  bool all_float32 = true;
  for (std::int32_t p = 0; p < own_->piece_count; ++p)
    all_float32 = all_float32 && own.pieces[p].is_float32;
  const std::int64_t size = all_float32 ? 4 : 8, stride = n * size;
  to.bytes.resize_discard(std::size_t(dual.vertex_count() * stride));
  to.bases.assign(std::size_t(n) * std::size_t(dual.piece_count), nullptr);
  to.views.clear();
  for (std::int32_t p = 0; p < dual.piece_count; ++p) {
    std::byte* const base = to.bytes.data() + dual.first_vertex[p] * stride;
    const std::byte** bases = to.bases.data() + p * n;
    for (int c = 0; c < n; ++c)
      bases[c] = base + c * size;
    const std::int64_t count = dual.first_vertex[p + 1] - dual.first_vertex[p];
    to.views.push_back(
        {bases, {count, {count, 1}, {stride, count * stride, count * stride}}, all_float32});
    const auto put = [&](std::int64_t vertex, int c, double value) {
      std::byte* const at = base + vertex * stride + c * size;
      if (all_float32)
        *reinterpret_cast<float*>(at) = float(value);
      else
        *reinterpret_cast<double*>(at) = value;
    };
    const mesh::GridletsView* const gridlets = dual.pieces[p].gridlets;
    threads_->parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      CellValues values(*amr_, *own_, own);
      for (std::int64_t v = begin; v < end; ++v) {
        if (gridlets) {
          const std::uint32_t leaf = gridlets->leaves[v];
          for (int c = 0; c < n; ++c)
            put(v, c,
                leaf == mesh::GridletsView::no_leaf ? std::numeric_limits<double>::quiet_NaN()
                                                    : values.load(leaf, c));
          continue;
        }
        const amr::DualMesh::Terms terms = dual_.terms(v);
        for (int c = 0; c < n; ++c) {
          double sum = 0.0;
          for (int t = 0; t < terms.count; ++t) {
            const bool ghost = terms.ghosts && terms.ghosts[t] != amr::no_ghost;
            sum += (terms.weights ? terms.weights[t] : 1.0) *
                   (ghost ? values.load_ghost(terms.leaves[t], terms.ghosts[t], c)
                          : values.load(terms.leaves[t], c));
          }
          put(v, c, sum);
        }
      }
    });
  }
}

} // namespace insitu::commit
