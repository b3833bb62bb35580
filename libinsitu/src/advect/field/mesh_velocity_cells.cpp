#include <utility>

#include "advect/field/mesh_velocity.h"
#include "mesh/cell_arrays.h"

/// The cells that a MeshVelocity keeps.
namespace insitu::advect {

using math::Vec3d;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Box everywhere{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};

/// Asks for items of three components.
INSITU_PREFETCH void prefetch(const std::byte* const* component, const mesh::ItemLayout& layout,
                              const std::int64_t* items, int count) {
  if (!layout.linear)
    return;
  const bool apart = component[2] - component[0] > 64;
  for (int i = 0; i < count; ++i) {
    const std::int64_t offset = items[i] * layout.stride[0];
    __builtin_prefetch(component[0] + offset);
    if (apart)
      __builtin_prefetch(component[1] + offset);
    __builtin_prefetch(component[2] + offset + 7);
  }
}

/// The same, read.
void read(const std::byte* const* component, const mesh::ItemLayout& layout, bool is_float32,
          const std::int64_t* items, int count, Vec3d* to) {
  const auto typed = [&]<class Real>(Real) {
    for (int i = 0; i < count; ++i) {
      const std::int64_t offset = items[i] * layout.stride[0];
      to[i] = {double(mesh::load_as<Real>(component[0] + offset)),
               double(mesh::load_as<Real>(component[1] + offset)),
               double(mesh::load_as<Real>(component[2] + offset))};
    }
  };
  is_float32 ? typed(float()) : typed(double());
}

bool has_points(const mesh::PieceView& piece) {
  return piece.points.component[0] && piece.points.layout.linear && !piece.implicit_points &&
         !piece.gridlets && !piece.leaves;
}

} // namespace

/// Cells of gridlets have no vertices of their own to keep.
bool MeshVelocity::can_keep(std::int64_t cell) const {
  const mesh::MeshView& mesh = sampler_->mesh();
  return !mesh.pieces[mesh.piece_of(cell)].gridlets;
}

void MeshVelocity::foresee(std::int64_t cell) const {
  const mesh::MeshView& mesh = sampler_->mesh();
  const std::int32_t p = mesh.piece_of(cell);
  const mesh::PieceView& piece = mesh.pieces[p];
  if (piece.layout == mesh::CellLayout::uniform || piece.layout == mesh::CellLayout::padded)
    __builtin_prefetch(piece.connectivity.data +
                       (cell - mesh.first_cell[p]) * piece.connectivity.stride);
}

void MeshVelocity::open(Kept& k, std::int64_t cell) const {
  const mesh::MeshView& mesh = sampler_->mesh();
  mesh::CellVertices& c = k.vertices;
  c.piece = mesh.piece_of(cell);
  const mesh::PieceView& piece = mesh.pieces[c.piece];
  const std::int64_t local = cell - mesh.first_cell[c.piece];
  k.cell = -1;
  k.opened = cell;
  c.shape = piece.shape(local);
  c.count = piece.vertex_ids(local, c.ids);
  if (beyond_cells_)
    beyond_cells_->foresee(cell);
  if (has_points(piece))
    prefetch(piece.points.component, piece.points.layout, c.ids, c.count);
  if (fields_[0].association == INSITU_CELL)
    return;
  for (int f = 0; f < steps_; ++f) {
    const mesh::FieldPieceView& from = fields_[f].pieces[c.piece];
    prefetch(from.component, from.layout, c.ids, c.count);
  }
}

void MeshVelocity::load(Kept& k, std::int64_t cell) const {
  if (k.opened != cell)
    open(k, cell);
  const mesh::MeshView& mesh = sampler_->mesh();
  mesh::CellVertices& c = k.vertices;
  const mesh::PieceView& piece = mesh.pieces[c.piece];
  k.cell = cell;
  k.opened = -1;
  k.alpha = 1.0;
  if (has_points(piece))
    read(piece.points.component, piece.points.layout, piece.points.is_float32, c.ids, c.count, c.x);
  else
    mesh::gather_points(piece, cell - mesh.first_cell[c.piece], c);
  k.box = box_of(c);
  if (moves_) {
    k.box = everywhere;
    const Vec3d* earlier = mesh.earlier_points + mesh.first_vertex[c.piece];
    for (int i = 0; i < c.count; ++i) {
      k.now[i] = c.x[i];
      k.earlier[i] = earlier[c.ids[i]];
    }
  }
  const bool by_cell = fields_[0].association == INSITU_CELL;
  k.values = by_cell ? 1 : c.count;
  for (int f = 0; f < steps_; ++f) {
    const mesh::FieldPieceView& from = fields_[f].pieces[c.piece];
    if (!by_cell && from.layout.linear && !from.behind) {
      read(from.component, from.layout, from.is_float32, c.ids, c.count, k.velocity[f]);
      continue;
    }
    for (int i = 0; i < k.values; ++i) {
      const std::int64_t item = by_cell ? cell - mesh.first_cell[c.piece] : c.ids[i];
      k.velocity[f][i] = {from.load(item, 0), from.load(item, 1), from.load(item, 2)};
    }
  }
}

/// A cell that may own points and has vertices to keep.
bool MeshVelocity::may_own(std::int64_t cell) const {
  const mesh::MeshView& mesh = sampler_->mesh();
  const std::int32_t p = mesh.piece_of(cell);
  const mesh::PieceView& piece = mesh.pieces[p];
  const std::int64_t local = cell - mesh.first_cell[p];
  return !piece.gridlets && piece.owns(local) && piece.shape(local) != mesh::Shape::none;
}

/// The guess at a neighbour, or a cell across an edge or vertex; or -1.
std::int64_t MeshVelocity::next_cell(const Kept& from, const Vec3d& r, double near) const {
  const std::int64_t cell = beyond_cells_->guess(from.cell, from.vertices.shape, r, near);
  return cell >= 0 && cell < sampler_->mesh().cell_count() && may_own(cell) ? cell : -1;
}

/// The guess at the cell across the face of the own cell on which the point asked last lies, for a
/// point x beyond that face.
std::int64_t MeshVelocity::cell_across(const Vec3d& x) const {
  return keeps_ && beyond_cells_ && proof_.counts_for(x) ? next_cell(*own_, own_r_, 1e-6) : -1;
}

/// What was the own cell is kept.
void MeshVelocity::take_own(std::int64_t cell) {
  for (Kept*& k : kept_)
    if (k->cell == cell)
      return std::swap(k, own_);
  load(*own_, cell);
}

} // namespace insitu::advect
