#include "commit/standins/dual_cells.h"

#include <algorithm>
#include <limits>

#include "amr/values/leaf_gradient.h"

namespace insitu::commit {

namespace {

constexpr std::int64_t grain = 1 << 13; ///< vertices a task

/// Reads values of cells by flat id, neighbours of which mostly lie in one piece.
class CellValues {
public:
  CellValues(const mesh::MeshView& mesh, const mesh::FieldView& field)
      : mesh_(&mesh), field_(&field) {}
  double load(std::int64_t flat, int component) {
    find(flat);
    return field_->pieces[piece_].load(flat - mesh_->first_cell[piece_], component);
  }
  /// Of the ghost cell across a face.
  double load_ghost(std::int64_t flat, int face, int component) {
    find(flat);
    return field_->pieces[piece_].load_ghost(flat - mesh_->first_cell[piece_], component, face);
  }

private:
  void find(std::int64_t flat) {
    if (flat < mesh_->first_cell[piece_] || flat >= mesh_->first_cell[piece_ + 1])
      piece_ = mesh_->piece_of(flat);
  }

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

DualCells::DualCells(core::Memory& memory) : memory_(&memory), dual_(memory), places_(memory) {}

DualCells::~DualCells() = default;

void DualCells::build(const mesh::Mesh& mesh, const core::Threads& threads, amr::Cubes cubes) {
  own_ = &mesh.own_view();
  threads_ = &threads;
  fields_.clear();
  dual_.build(mesh.adaptive(), threads, cubes);
  if (dual_.has_gridlets())
    places_.build(*dual_.view().pieces[0].gridlets, dual_.leaves(), threads);
  else
    places_.release();
}

void DualCells::fields_changed() {
  for (const auto& f : fields_)
    f->fresh = false;
}

mesh::FieldView DualCells::field(const mesh::FieldView& own) {
  const std::lock_guard lock(mutex_);
  const auto known = std::find_if(fields_.begin(), fields_.end(),
                                  [&](const auto& f) { return f->name == own.name; });
  Gathered& g = known != fields_.end()
                    ? **known
                    : *fields_.emplace_back(std::make_unique<Gathered>(*memory_));
  if (!g.fresh) {
    g.name = own.name;
    gather(own, g);
    g.fresh = true;
  }
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
      CellValues values(*own_, own);
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
