#pragma once

#include <cstdint>

#include "advect/field/cells_beyond.h"
#include "query/sampler.h"

/// The cells that hold a particle's place, told from its cell without the tree.
namespace insitu::advect {

/// The cells that share a face, edge or vertex, told by the vertex ids of the faces on which it
/// lies; closed: each of these faces has a cell on both sides, so no other cell comes near the
/// places there, unless cells overlap.
struct CellsAbout {
  static constexpr int most = 32;
  bool closed = false;
  int count = 0;
  std::int64_t cells[most];
};

/// The cells that own points about the face, edge or vertex of a cell with these local vertices, a
/// bit each, as far as guesses find them.
CellsAbout cells_about(const mesh::MeshView& mesh, const CellsBeyond& beyond, std::int64_t cell,
                       unsigned on);

/// The owner of the place of a particle that was in `cell` (-1: in none): that of Sampler::locate,
/// unless cells overlap. Where it is not known of all cells whether they fold, a sound cell that is
/// proven to hold the place is it, and on a face, edge or vertex about which sound cells close the
/// lowest of these that hold it, exactly; else the sampler is asked. beyond: may be null.
query::Location owner_of(const query::Sampler& sampler, const CellsBeyond* beyond,
                         std::int64_t cell, const math::Vec3d& x,
                         const query::LocateOptions& options);

} // namespace insitu::advect
