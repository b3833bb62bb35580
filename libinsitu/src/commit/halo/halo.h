#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "amr/dual/shared_leaves.h"
#include "commit/halo/leaf_search.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/cell_name.h"
#include "mesh/registered/mesh.h"
#include "parallel/parcels.h"
#include "query/directory.h"

namespace insitu::commit {

class CommittedMesh;

using mesh::CellName;

/// The axes along which what leaves the box of a mesh comes in at the opposite side.
using PeriodicAxes = std::array<bool, 3>;

/// The cells of other processes that touch this process's cells: copies of their vertices, global
/// ids and fields, as pieces of the mesh behind the solver's own. They exist and do not own points,
/// so a mesh with its halo has at its seams what the whole mesh has there. Cells touch here if
/// their boxes do, rounded outwards to floats and wider by the seam's tolerance: more than needed,
/// never less. What of a mesh is
/// borrowed here and lent to others stays the same until the cells of a process change. Over
/// periodic sides cells touch, too, that would if one of them were a period further on, give or
/// take a quarter of a cell, by which sides that move may come apart. On a mesh in longitude and
/// latitude cells touch in any of their places on its chart, and over its seam. Of polyhedra parts
/// touch and are here, by their cells' names (CommittedMesh::lent_view).
class Halo final : public mesh::HaloPieces {
public:
  explicit Halo(core::Memory& memory) : memory_(&memory) {}

  /// Collective, of a committed mesh that is not adaptive: finds the cells and copies their
  /// vertices. The mesh's views are of the halo before until its next update().
  /// sides: the axes along which the mesh's box is periodic, alike on all processes. The mesh's
  /// tree is not asked.
  void find(const CommittedMesh& mesh, const PeriodicAxes& sides, parallel::World& world,
            const core::Threads& threads);
  /// Collective: the same of an adaptive mesh, as of an update() without a halo: leaves, with the
  /// ghost cells that the solver has beyond them, in as many layers as its reconstruction takes
  /// (leaf_halo.cpp). On a process without cells the mesh may be any. own: of the mesh's leaves,
  /// where that is there; or null.
  void find_leaves(const mesh::Mesh& mesh, const amr::LeafMap* own, parallel::World& world,
                   const core::Threads& threads);
  /// Collective: copies the vertices again, which moved. Throws parallel::AgreedError, as all here.
  void refresh_points(const CommittedMesh& mesh, parallel::World& world);
  /// Collective: copies the values of the fields that the mesh lends (lends_field()).
  void refresh_fields(const CommittedMesh& mesh, parallel::World& world);
  /// Collective: gives numbers that each process has at its own cells, or at the vertices of them,
  /// to those that have copies of these. values: [flat item of the view][component]; those of the
  /// halo are set.
  void refresh_values(const CommittedMesh& mesh, parallel::World& world, std::span<double> values,
                      insitu_association association = INSITU_VERTEX, int components = 1) const;

  std::span<const mesh::PieceView> pieces() const override { return views_; }
  mesh::FieldPieceView values(const std::string& field, std::size_t piece) const override;
  std::span<const mesh::AmrPieceView> leaves() const override { return leaf_views_; }
  std::int32_t far_count() const override { return far_count_; }
  const std::uint64_t* covered() const override {
    return covered_.empty() ? nullptr : covered_.data();
  }
  /// Beside this process's leaves: LeafSearch::gaps.
  const CellPairs& gaps() const { return gaps_; }
  /// Which leaves of this process others have.
  std::span<const amr::LentLeaf> lent_leaves() const { return lent_leaves_; }
  /// A bit for each leaf of the halo that does not touch this process's: it is of the last layer.
  const std::uint64_t* outermost() const { return outermost_.data(); }

  /// Of the cell that is number `cell` in halo piece `piece`.
  CellName name(std::size_t piece, std::int64_t cell) const;
  /// The halo piece that has a cell of another process, and its number there; a number of -1: the
  /// halo does not have it. The name's global id is not looked at. Of a polyhedron the part, or
  /// else the first that is here.
  std::pair<std::size_t, std::int64_t> find(const CellName& name) const;
  std::int64_t cell_count() const;
  /// Whether a cell of this process, by its flat id, touches others.
  bool is_at_seam(std::int64_t flat) const {
    return std::size_t(flat >> 6) < seam_.size() &&
           (seam_[std::size_t(flat >> 6)] >> (flat & 63)) & 1;
  }
  /// Sent since the halo was made.
  std::int64_t bytes_sent() const { return bytes_sent_; }

private:
  /// Cells and vertices of a piece of this process that another process has.
  struct Lent {
    int rank;
    std::int32_t piece;
    std::vector<std::int64_t> cells, vertices; ///< in the piece, ascending
    std::vector<std::uint8_t> ghosts; ///< of leaves: a bit a face, whose ghost cells go with them
  };
  struct Values {
    core::Buffer<std::byte> bytes;
    std::vector<const std::byte*> components;
    mesh::FieldPieceView view;
    explicit Values(core::Memory& memory) : bytes(memory, INSITU_MEMORY_HALO) {}
  };
  struct Borrowed {
    int rank = 0;
    std::int32_t piece = 0;
    bool has_global = false, from_float32 = false; ///< the latter: coordinates
    core::Buffer<math::Vec3d> points;
    core::Buffer<std::int64_t> cells, global, offsets; ///< of parts, the cells that they are of
    core::Buffer<std::int32_t> connectivity;
    core::Buffer<std::uint8_t> types;
    /// Of parts of polyhedra: their cells, and which of a cell's a part is.
    core::Buffer<std::uint32_t> part_of, part;
    std::optional<ToldLeaves> leaves; ///< of an adaptive mesh, in place of shapes and vertices
    std::map<std::string, std::unique_ptr<Values>> fields;
    /// Of cells, values come with those of leaves' ghost cells behind them.
    std::size_t value_count(bool of_cells) const {
      return !of_cells ? points.size()
                       : cells.size() + std::size_t(leaves ? leaves->ghost_count() : 0);
    }
    explicit Borrowed(core::Memory& memory)
        : points(memory, INSITU_MEMORY_HALO), cells(memory, INSITU_MEMORY_HALO),
          global(memory, INSITU_MEMORY_HALO), offsets(memory, INSITU_MEMORY_HALO),
          connectivity(memory, INSITU_MEMORY_HALO), types(memory, INSITU_MEMORY_HALO),
          part_of(memory, INSITU_MEMORY_HALO), part(memory, INSITU_MEMORY_HALO) {}
    mesh::PieceView view();
  };

  std::vector<std::vector<std::int64_t>> touching_cells(const CommittedMesh& mesh,
                                                        const PeriodicAxes& sides,
                                                        parallel::World& world,
                                                        const core::Threads& threads);
  void lend(const CommittedMesh& mesh, const std::vector<std::vector<std::int64_t>>& cells,
            std::vector<parallel::ByteWriter>& to);
  void borrow(int rank, parallel::ByteReader& from);
  void borrow_leaves(std::span<const ToldLeaf> leaves);
  void ask_for_leaves(std::vector<parallel::ByteWriter>& to) const;
  void lend_leaves(const mesh::Mesh& mesh, int rank, parallel::ByteReader& from);
  /// Exchanges what write() has for each process that borrows here; read() gets what comes.
  void swap(parallel::World& world,
            core::FunctionRef<void(std::vector<parallel::ByteWriter>& to)> write,
            core::FunctionRef<void(int rank, parallel::ByteReader& from)> read) const;

  core::Memory* memory_;
  query::Directory directory_;
  std::vector<Lent> lent_;
  std::vector<Borrowed> borrowed_; ///< by rank, then piece
  std::vector<mesh::PieceView> views_;
  std::vector<std::uint64_t> seam_; ///< a bit a flat cell
  std::size_t near_count_ = 0;      ///< of borrowed_: the others are leaves that do not touch
  std::int32_t far_count_ = 0;
  std::vector<mesh::AmrPieceView> leaf_views_;
  std::vector<std::uint64_t> covered_; ///< a bit a flat cell
  std::vector<amr::LentLeaf> lent_leaves_;
  std::vector<std::uint64_t> outermost_;
  CellPairs gaps_;
  mutable std::int64_t bytes_sent_ = 0;
};

} // namespace insitu::commit
