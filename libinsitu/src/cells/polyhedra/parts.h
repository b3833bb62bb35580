#pragma once

#include <string>

#include "cells/polyhedra/findings.h"
#include "cells/polyhedra/ids.h"
#include "core/parallel.h"
#include "mesh/faces.h"
#include "mesh/piece.h"

namespace insitu::cells {

/// What the cells of a piece that are given by faces are cut into. A tetrahedron, pyramid, wedge or
/// hexahedron is one part. Any other cell is cut around its centre: into a pyramid over each quad,
/// a tetrahedron over each triangle, and over a face of more vertices into tetrahedra around the
/// face's centre. Parts are in the order of the cells. Their vertices are the solver's, by their
/// ids, then the centres of faces, then those of cells: the made ones. Where these lie is told by
/// MadePoints.
class Parts {
public:
  explicit Parts(core::Memory& memory);

  /// own: the piece, with the points of its vertices. A cell that does not exist has parts only if
  /// it is sound. With findings there are no parts.
  void cut(const mesh::FacesView& faces, const mesh::PieceView& own, const std::string& name,
           const core::Threads& threads, FaceFindings& findings);

  std::int64_t part_count() const { return std::int64_t(cell_of_.size()); }
  std::int64_t cell_of(std::int64_t part) const { return cell_of_[std::size_t(part)]; }
  /// The parts of cell c are first()[c] to first()[c + 1] - 1.
  const std::uint32_t* first() const { return first_.data(); }
  /// Each cell is one part, of its own number.
  bool are_the_cells() const { return made_count() == 0 && part_count() == cell_count(); }
  std::int64_t cell_count() const { return std::int64_t(first_.size()) - 1; }

  std::int64_t face_centre_count() const { return face_centres_; }
  std::int64_t made_count() const { return face_centres_ + std::int64_t(cut_cells_.size()); }
  /// The cell whose centre a made vertex is, of those behind the centres of faces.
  std::int64_t cut_cell(std::int64_t made) const {
    return cut_cells_[std::size_t(made - face_centres_)];
  }
  /// The vertices between which a made one lies: place_of_sources(k) to before that of k + 1, in
  /// sources().
  std::int64_t place_of_sources(std::int64_t made) const {
    return source_first_[std::size_t(made)];
  }
  Ids& sources() { return sources_; }
  const Ids& sources() const { return sources_; }

  /// The cells of own, which it has everything else from, but for its points.
  mesh::PieceView view(const mesh::PieceView& own) const;
  std::int64_t bytes() const;

private:
  struct Chunk;
  class Cutter;
  void number_centres(const mesh::FacesView& faces, std::int64_t vertices,
                      const std::vector<Chunk>& chunks,
                      core::Buffer<std::uint32_t>& number_of_face);
  void join(const std::vector<Chunk>& chunks, const core::Buffer<std::uint32_t>& number_of_face,
            std::int64_t vertices, const core::Threads& threads);

  core::Memory* memory_;
  mesh::Shape uniform_ = mesh::Shape::none; ///< of all parts; none: types_ and offsets_ tell
  Ids ids_, offsets_;
  core::Buffer<std::uint8_t> types_;
  core::Buffer<std::uint32_t> first_, cell_of_;
  std::int64_t face_centres_ = 0;
  core::Buffer<std::uint32_t> cut_cells_;
  core::Buffer<std::int64_t> source_first_;
  Ids sources_;
};

} // namespace insitu::cells
