#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/piece.h"

namespace insitu::mesh {

/// What is known of the flat cells of a mesh, or of a part of it; facts of parts add up, whatever
/// the parts are. Lengths are told by their powers of two.
struct FlatFacts {
  static constexpr int powers = 1024, middle = powers / 2; ///< lengths[middle + e]: 2^e to 2^(e+1)
  static constexpr double none = std::numeric_limits<double>::infinity();

  double least = none, greatest = -none;      ///< third coordinates
  std::array<std::int64_t, powers> lengths{}; ///< edges of cells: those of two cells count twice
  std::int64_t volumes = 0;                   ///< cells that are not flat

  bool any() const { return least <= greatest; }
  void add(const FlatFacts& other);
  bool operator==(const FlatFacts&) const = default;
};

/// Where the cells stand: from low to high, which are the plane's both sides. The thickness is the
/// power of two at or below the median edge, and what keeps both sides apart from the plane in
/// float32, too.
struct FlatSlab {
  double plane = 0.0, low = -0.5, high = 0.5;

  static FlatSlab of(const FlatFacts& facts);
  /// So far a vertex may be from the plane, by rounding.
  double out_of_plane() const { return (high - low) / 1024; }
  bool operator==(const FlatSlab&) const = default;
};

/// What a piece's flat cells are. A block of them has one vertex along k.
struct FlatCells {
  enum class Kind : std::uint8_t { none, uniform, padded, mixed, block };
  Kind kind = Kind::none;
  std::uint8_t shape = 0; ///< VTK's number; PADDED: of 4 ids

  explicit operator bool() const { return kind != Kind::none; }
};

/// A cell as the solver gave it: its ids in a row around it, and how many; fewer than 3: none.
struct FlatCell {
  int count = 0;
  std::int64_t ids[4];
};

/// The flat cells of a piece as the solver gave them.
class FlatSource {
public:
  /// given: the piece as it was registered, whose points may lack the third component.
  /// turn: so many of the first coordinate are a full turn, around the Earth; 0: it does not turn.
  FlatSource(const PieceView& given, const FlatCells& cells, std::int64_t vertices, bool has_third,
             double turn)
      : given_(given), cells_(cells), vertices_(vertices), has_third_(has_third), turn_(turn) {}

  FlatCell cell(std::int64_t c) const;
  math::Vec3d point(std::int64_t id) const;
  std::int64_t vertex_count() const { return vertices_; }
  const PieceView& given() const { return given_; }
  const FlatCells& cells() const { return cells_; }
  /// Whether the ids are there.
  bool is_sound(const FlatCell& cell) const;
  /// What is wrong with a cell that exists; "": nothing.
  std::string fault(std::int64_t c) const;
  /// Twice the area, negative if the cell goes round clockwise; around a pole by its own sense.
  double area(const FlatCell& cell) const;
  /// Adds what the piece's cells tell. Throws INSITU_ERROR_MESH for ids that are none.
  void look(const std::string& name, const core::Threads* threads, FlatFacts& facts) const;
  /// Throws INSITU_ERROR_MESH, by cell and vertex, unless all lie in one plane.
  void require_plane(const std::string& name, const FlatFacts& facts) const;

private:
  math::Vec3d step(std::int64_t from, std::int64_t to) const;

  const PieceView& given_;
  FlatCells cells_;
  std::int64_t vertices_;
  bool has_third_;
  double turn_;
};

/// The flat cells of a piece as volume cells, whose vertices are the solver's, below and above the
/// plane: triangles become wedges, quads hexahedra, pixels voxels. Cells keep their numbers. Blocks
/// whose coordinates come from axes take no memory. Cells that go round clockwise are turned over,
/// so that none is inverted.
class FlatPiece {
public:
  explicit FlatPiece(core::Memory& memory)
      : points_(memory, INSITU_MEMORY_FLAT), ids_(memory, INSITU_MEMORY_FLAT) {}

  /// other_cells: or else the vertices alone are others.
  void make(const FlatSource& source, const FlatSlab& slab, bool other_cells,
            const core::Threads* threads);
  /// Ghosts and parts are to be set.
  const PieceView& view() const { return view_; }
  /// Whether ids below PieceView::flat_vertices are above the plane.
  bool top_first() const { return top_first_; }
  std::int64_t bytes() const { return std::int64_t(points_.bytes() + ids_.bytes()); }

private:
  void make_block(const FlatSource& source, const FlatSlab& slab);
  void make_cells(const FlatSource& source, const core::Threads* threads);
  void make_points(const FlatSource& source, const FlatSlab& slab, const core::Threads* threads);
  template <class Id>
  void fill(const FlatSource& source, int width, const core::Threads* threads);

  core::Buffer<std::byte> points_, ids_;
  double axis_[2] = {0, 0};
  float axis32_[2] = {0, 0};
  bool top_first_ = false;
  PieceView view_;
};

/// Cells of a mixed piece that are left out since others have more dimensions.
class LeftOutCells {
public:
  explicit LeftOutCells(core::Memory& memory) : ghosts_(memory, INSITU_MEMORY_FLAT) {}

  /// leaves_out(type): by VTK's numbers. The view's own ghosts stay ghosts.
  void make(const PieceView& given, bool (*leaves_out)(int type), const core::Threads* threads);
  void put_in(PieceView& view) const;
  /// [0]: of vertices, [1]: of lines, [2]: of triangles, quads and other surfaces.
  const std::array<std::int64_t, 3>& counts() const { return counts_; }
  std::int64_t bytes() const { return std::int64_t(ghosts_.bytes()); }

private:
  core::Buffer<std::uint8_t> ghosts_;
  std::array<std::int64_t, 3> counts_{};
};

} // namespace insitu::mesh
