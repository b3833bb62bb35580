#include "scene/tracers/tracer_cells.h"

#include <cmath>
#include <optional>

#include "mesh/ghosts.h"

namespace insitu::scene {

namespace {

/// Whether a cell that exists has values in all of these fields.
bool has_values(const mesh::MeshView& mesh, std::span<const mesh::FieldView> fields, std::int32_t p,
                std::int64_t cell) {
  const mesh::PieceView& piece = mesh.pieces[p];
  if (!piece.exists(cell))
    return false;
  std::int64_t ids[8];
  int count = 0;
  for (const mesh::FieldView& field : fields) {
    if (field.association == INSITU_CELL) {
      if (std::isnan(field.pieces[p].load(cell, 0)))
        return false;
      continue;
    }
    if (count == 0)
      count = piece.vertex_ids(cell, ids);
    for (int v = 0; v < count; ++v)
      if (std::isnan(field.pieces[p].load(ids[v], 0)))
        return false;
  }
  return true;
}

/// Whether a cell that owns no points can be looked at.
bool can_be_read(const mesh::PieceView& piece, std::int64_t cell) {
  if (piece.exists(cell) || !mesh::has_sound_ids(piece, cell))
    return false;
  std::int64_t ids[8];
  const int count = piece.vertex_ids(cell, ids);
  for (int v = 0; v < count; ++v) {
    const math::Vec3d x = piece.point(ids[v]);
    if (!(std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z)))
      return false;
  }
  return true;
}

} // namespace

query::SomeCells::Changed TracerCells::Versions::update(const commit::CommittedMesh& mesh) {
  using Changed = query::SomeCells::Changed;
  const bool other_cells = mesh_id != mesh.id() || topology != mesh.topology_version();
  const Changed changed = other_cells                           ? Changed::topology
                          : geometry != mesh.geometry_version() ? Changed::geometry
                                                                : Changed::nothing;
  mesh_id = mesh.id();
  topology = mesh.topology_version();
  geometry = mesh.geometry_version();
  return changed;
}

query::Sampler TracerCells::sampler(const commit::CommittedMesh& mesh,
                                    std::span<const mesh::FieldView> velocities,
                                    const core::Threads& threads) {
  const query::Sampler whole = mesh.sampler();
  if (!velocities.front().has_blanks)
    return whole;
  with_values_.update(whole.mesh(), threads, of_values_.update(mesh),
                      [&](std::int32_t piece, std::int64_t cell) {
                        return has_values(whole.mesh(), velocities, piece, cell);
                      });
  return with_values_.leaves_out_owners() ? with_values_.of(whole) : whole;
}

query::Sampler TracerCells::earlier_sampler(const query::Sampler& sampler,
                                            const mesh::FieldView& velocity,
                                            const core::Threads& threads) {
  earlier_.emplace(*memory_);
  earlier_->update(sampler.mesh(), threads, query::SomeCells::Changed::topology,
                   [&](std::int32_t piece, std::int64_t cell) {
                     return has_values(sampler.mesh(), {&velocity, 1}, piece, cell);
                   });
  return earlier_->leaves_out_owners() ? earlier_->of(sampler) : sampler;
}

query::SomeCells* TracerCells::left_out(const commit::CommittedMesh& mesh,
                                        const core::Threads& threads) {
  // Copies of a geodetic mesh's cells come behind the solver's own; the originals are not left out.
  const mesh::MeshView& own = mesh.mesh().own_view();
  bool any = false;
  for (std::int32_t p = 0; p < own.piece_count; ++p)
    any |= own.pieces[p].ghosts != nullptr;
  if (!any)
    return nullptr;
  left_out_.update(mesh.mesh().view(), threads, of_left_out_.update(mesh),
                   [&](std::int32_t piece, std::int64_t cell) {
                     if (piece >= own.piece_count)
                       return false;
                     const mesh::PieceView& p = own.pieces[piece];
                     return can_be_read(p.parts ? *p.parts->piece : p, cell);
                   });
  return &left_out_;
}

} // namespace insitu::scene
