#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "advect/across/rounds.h"
#include "advect/lines/line_vertices.h"
#include "advect/lines/streamlines.h"

namespace insitu::advect {

/// A part of a streamline that was made on one process.
struct LinePiece {
  std::int64_t line; ///< as Streamlines counts lines
  std::int32_t hops; ///< of the line from process to process before it
  std::uint64_t
      first; ///< number on the line of its first vertex; what there was from there on goes
  std::vector<LineVertex> vertices; ///< cells are flat ids here
};

/// The lines of all processes, as far as they are here.
struct LinePieces {
  std::vector<LinePiece> pieces; ///< in the order in which they were made
  /// A vertex of another process's piece, which has no cell of it, in a cell here.
  struct OfOther {
    std::int64_t rank, piece, number; ///< the process, and places in its lists
    LineVertex vertex;
  };
  std::vector<OfOther> of_others;
  struct End {
    std::int64_t line;
    std::int64_t ending;
  };
  std::vector<End> ends; ///< of lines that ended here
  Counts counts;         ///< of all processes
  Work work;
};

/// Streamlines through a mesh that is spread over processes: see trace_streamlines(). The sampler's
/// mesh has the cells of other processes that touch this one's; cells beyond these that a step
/// needs come from their owners (FarCells). Collective; throws parallel::AgreedError.
LinePieces trace_lines_across(const Across& across, const query::Sampler& sampler,
                              const mesh::FieldView& velocity, std::span<const math::Vec3d> seeds,
                              const StreamlineSettings& settings, const core::Threads& threads,
                              core::Memory& memory);

} // namespace insitu::advect
