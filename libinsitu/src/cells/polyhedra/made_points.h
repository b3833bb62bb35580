#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "cells/polyhedra/parts.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::cells {

/// Where the vertices of Parts lie, and the values of fields there: the solver's in a copy, and
/// behind them the made ones. A face's centre is the mean of its vertices, taken in the order of
/// their coordinates, so that both neighbours have the same bits wherever they are. A cell's centre
/// is the mean of its vertices; if a part then has no positive volume, the cell's centroid; if one
/// has none then either, a point as deep as possible behind the planes of the faces. Values there
/// are means alike, with weights beside the mean that meet linear fields.
class MadePoints {
public:
  explicit MadePoints(core::Memory& memory) : points_(memory, INSITU_MEMORY_POLYHEDRA) {}

  /// own: the piece, whose points may have moved since the last call. Sorts the parts' sources.
  void place(const mesh::PieceView& own, Parts& parts, const core::Threads& threads);

  const math::Vec3d* data() const { return points_.data(); }
  /// Makes the view's points these; as they are if no vertex is made.
  void put_in(mesh::PieceView& view) const;
  /// The cells of which no point tried sees all faces, ascending.
  const std::vector<std::uint32_t>& without_centre() const { return without_centre_; }

  /// A field on vertices, [vertex][component], as float or double: as many as the parts have.
  template <class T>
  void extend(const mesh::FieldPieceView& own, int components, const Parts& parts,
              const core::Threads& threads, T* to) const;

  std::int64_t bytes() const {
    return std::int64_t(points_.bytes() + beside_.capacity() * sizeof(Beside));
  }

private:
  /// A made vertex that is not the mean of its sources: a source's weight differs from that of the
  /// mean by its distance from the mean times this.
  struct Beside {
    std::int64_t made;
    math::Vec3d gradient, mean;
  };
  class CellCentre;

  core::Buffer<math::Vec3d> points_;
  std::int64_t solvers_ = 0;   ///< of these
  std::vector<Beside> beside_; ///< ascending
  std::vector<std::uint32_t> without_centre_;
};

} // namespace insitu::cells
