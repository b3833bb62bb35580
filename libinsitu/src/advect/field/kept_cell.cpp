#include "advect/field/kept_cell.h"

#include <limits>

#include "mesh/cell_arrays.h"

namespace insitu::advect {

using math::Vec3d;

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr Box everywhere{{-endless, -endless, -endless}, {endless, endless, endless}};

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

/// Reads items of three components.
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
         piece.shares_vertices();
}

} // namespace

void KeptCell::open(std::int64_t id, const Moment& moment) {
  const mesh::MeshView& mesh = moment.mesh();
  mesh::CellVertices& c = vertices;
  c.piece = mesh.piece_of(id);
  const mesh::PieceView& piece = mesh.pieces[c.piece];
  const std::int64_t local = id - mesh.first_cell[c.piece];
  cell = -1;
  opened = id;
  c.shape = piece.shape(local);
  c.count = piece.vertex_ids(local, c.ids);
  if (has_points(piece))
    prefetch(piece.points.component, piece.points.layout, c.ids, c.count);
  if (moment.is_by_cell() || moment.components() != 3)
    return;
  for (int step = 0; step < moment.steps(); ++step) {
    const mesh::FieldPieceView& from = moment.field(step).pieces[c.piece];
    prefetch(from.component, from.layout, c.ids, c.count);
  }
}

void KeptCell::load(const Moment& moment) {
  const mesh::MeshView& mesh = moment.mesh();
  mesh::CellVertices& c = vertices;
  const mesh::PieceView& piece = mesh.pieces[c.piece];
  const std::int64_t local = opened - mesh.first_cell[c.piece];
  cell = opened;
  opened = -1;
  sound = query::SoundCells::Known::unknown;
  closed_on = 0;
  alpha = 1.0;
  if (has_points(piece))
    read(piece.points.component, piece.points.layout, piece.points.is_float32, c.ids, c.count, c.x);
  else
    mesh::gather_points(piece, local, c);
  box = box_of(c);
  if (moment.moves()) {
    box = everywhere;
    const Vec3d* before = mesh.earlier_points + mesh.first_vertex[c.piece];
    for (int i = 0; i < c.count; ++i) {
      now[i] = c.x[i];
      earlier[i] = before[c.ids[i]];
    }
  }
  const bool by_cell = moment.is_by_cell();
  values = by_cell ? 1 : c.count;
  for (int step = 0; step < moment.steps(); ++step) {
    const mesh::FieldPieceView& from = moment.field(step).pieces[c.piece];
    if (!by_cell && from.layout.linear && !from.behind && moment.components() == 3) {
      read(from.component, from.layout, from.is_float32, c.ids, c.count, velocity[step]);
      continue;
    }
    for (int i = 0; i < values; ++i) {
      const std::int64_t item = by_cell ? local : c.ids[i];
      velocity[step][i] = {from.load(item, 0), from.load(item, 1),
                           moment.components() > 2 ? from.load(item, 2) : 0.0};
    }
  }
}

} // namespace insitu::advect
