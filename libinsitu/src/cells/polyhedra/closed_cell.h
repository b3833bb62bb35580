#pragma once

#include <span>
#include <string>
#include <vector>

#include "cells/polyhedra/cell_faces.h"
#include "cells/polyhedra/findings.h"

namespace insitu::cells {

/// One cell, put together from its faces: its vertices, and rings that all are wound outward,
/// whatever way they were given. The order of vertices and rings, and where rings begin, follow
/// from the coordinates alone, so that a cell is the same to the bit however it is numbered. Reused
/// from cell to cell.
class ClosedCell {
public:
  struct Ring {
    std::int32_t first, size; ///< in ring_vertices()
    std::int64_t face;
    bool flipped; ///< while the cell is put together: read backwards, it is wound outward
  };

  ClosedCell(const mesh::FacesView& faces, const mesh::PieceView& piece, const std::string& name)
      : given_(faces), piece_(piece), name_(name) {}

  /// False, and one finding more, if these faces do not bound a cell.
  bool gather(std::int64_t cell, std::span<const std::int64_t> faces, FaceFindings& findings);

  const std::vector<Ring>& rings() const { return rings_; }
  /// Vertex k of a ring wound outward, as a place in vertices().
  int at(const Ring& ring, int k) const {
    return places_[std::size_t(ring.first + (ring.flipped ? ring.size - 1 - k : k))];
  }
  std::int64_t id(int place) const { return vertices_[std::size_t(place)]; }
  const std::vector<std::int64_t>& vertices() const { return vertices_; }

  /// The cell's vertices in VTK's order if it is a tetrahedron, pyramid, wedge or hexahedron;
  /// otherwise Shape::none.
  mesh::Shape recognise(std::int64_t ids[8]) const;

private:
  struct Found {
    math::Vec3d x;
    std::int64_t id;
  };
  struct Edge {
    std::int32_t low, high, ring;
    bool ascends; ///< the ring runs from low to high
  };
  bool take_rings(std::span<const std::int64_t> faces, FaceFindings& findings);
  bool take_vertices(FaceFindings& findings);
  bool match_edges(FaceFindings& findings);
  bool wind(FaceFindings& findings);
  bool has_volume() const;
  void order_rings();
  void refuse(std::int64_t& errors, const std::string& what, FaceFindings& findings) const;
  bool are_joined(int a, int b) const;
  /// The vertices that edges join to those of a ring, in its order; false if a vertex has another
  /// number of them than one.
  bool find_tops(const Ring& ring, int* tops) const;
  int find_ring_of(int size) const;

  const mesh::FacesView& given_;
  const mesh::PieceView& piece_;
  const std::string& name_;
  std::int64_t cell_ = 0;
  std::vector<Ring> rings_;
  std::vector<std::int64_t> ring_ids_; ///< [ring vertex] ids
  std::vector<std::int32_t> places_;   ///< [ring vertex] in vertices_
  std::vector<std::int64_t> vertices_; ///< ids
  std::vector<std::int64_t> sorted_ids_;
  std::vector<std::int32_t> place_of_; ///< [of sorted_ids_] in vertices_
  std::vector<Found> found_;
  std::vector<math::Vec3d> points_;
  std::vector<Edge> edges_; ///< sorted: each twice
  std::vector<std::int32_t> parent_;
  std::vector<std::uint8_t> parity_;
  double volume_ = 0.0;
};

} // namespace insitu::cells
