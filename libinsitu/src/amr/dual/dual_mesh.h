#pragma once

#include <cstdint>
#include <memory>

#include "amr/dual/corner_map.h"
#include "amr/dual/enumerate.h"
#include "amr/dual/shared_leaves.h"
#include "amr/leaves/leaf_map.h"
#include "mesh/view.h"

namespace insitu::amr {

/// Counts of a dual mesh, in cells unless said otherwise.
struct DualCounts {
  std::int64_t leaves = 0, masked = 0;
  std::int64_t gridlets = 0; ///< gridlets
  std::int64_t cubes = 0;    ///< full cells of gridlets
  std::int64_t empty = 0;    ///< other cells of gridlets
  std::int64_t scalars = 0;  ///< vertices of gridlets
  std::int64_t tetrahedra = 0, pyramids = 0, wedges = 0, hexahedra = 0,
               collapsed = 0;    ///< stitching
  std::int64_t boundary = 0;     ///< of these, cells between the dual and the domain's boundary
  std::int64_t folded = 0;       ///< stitching cells that fold before the repair
  std::int64_t repaired = 0;     ///< virtual leaves that the repair made
  std::int64_t still_folded = 0; ///< after it; 0
  std::int64_t stitching() const { return tetrahedra + pyramids + wedges + hexahedra + collapsed; }
};

/// What cubes are: cells of gridlets, or cells like all others. counts: as gridlets_pay() says.
enum class Cubes { counts, gridlets, cells };

/// Whether gridlets, in which points find their cells by their places on the lattices, are worth
/// it. Where most cells stitch, cells that are all alike, in a tree, are sooner drawn and no later
/// found; of a few thousand cells most stitch at the domain's boundary, and nothing is gained. A
/// sum of such counts over processes decides for all of them.
bool gridlets_pay(const DualCounts& counts);

/// The dual mesh of an adaptive mesh (Moran and Ellsworth 2011; Wald 2020; Zellmann 2023, section
/// 4.1): a vertex at the centre of every leaf, a cell at every corner of the finest leaves there.
/// Cells among leaves of one depth are cubes and lie in gridlets (Zellmann 2023, section 4.2), the
/// others are stitching cells.
///
/// Between the outermost centres and the domain's boundary lie cells whose vertices are the centres
/// and their projections to the boundary, so that the cells cover the domain. The projections have
/// the same values, or, where the solver has ghost cells beyond, values between the leaf's and
/// theirs. At re-entrant corners the domain is filled with pyramids and tetrahedra from the corner,
/// which has the mean of the leaves' values (reentrant.h), or with ghost cells all around the mean
/// of their extrapolations. With ghost cells everywhere, linear fields are reproduced up to the
/// boundary; a vertex has one value whatever its leaf has beyond, so the interpolant does not jump
/// where patches with and without ghost cells meet (vertex_values.h). Only where a domain ends in
/// the middle of leaves' faces, without a leaf of their depth beside them, may faces in its planes
/// not match one to one; cells cover such domains once, too, but the interpolant may jump at those
/// planes.
///
/// Where depths differ by more than one around a corner, cells can fold. Coarse leaves around such
/// cells are split virtually, for the dual mesh alone, until none folds: then every Jacobian is
/// positive and faces match in pairs, so cells cover every point once. A virtual leaf's value is
/// linear in the real one's and its neighbours' (vertex_values.h).
class DualMesh {
public:
  explicit DualMesh(core::Memory& memory);
  ~DualMesh();

  /// Builds anew, at a regrid; the result does not depend on the thread count. Throws what
  /// LeafMap::build throws, and INSITU_ERROR_MESH for more vertices than ids can number; then the
  /// dual mesh is empty.
  /// shared: of a mesh with a halo, collective; cells are then at all corners of this process's
  /// leaves and of those that touch them. mesh: shared->mesh.
  void build(const mesh::AmrView& mesh, const core::Threads& threads, Cubes cubes = Cubes::counts,
             const SharedLeaves* shared = nullptr);

  const LeafMap& leaves() const;
  const DualCounts& counts() const;
  std::int64_t bytes() const; ///< of gridlets, stitching cells and the map, without values

  /// Piece 0: the gridlets (CellLayout::gridlets). Piece 1: all other cells (PADDED, int32 ids,
  /// points of their own). Valid until the next build.
  const mesh::MeshView& view() const;

  /// Bits of the cells of both pieces that another process owns (PieceView::foreign), until the
  /// next build.
  void set_foreign(const std::uint64_t* of_gridlets, const std::uint64_t* of_others);

  /// Of a flat cell, where leaves are shared. Cells of the same places are one, and of two cells
  /// the first in the order of the ids is so on all processes: cubes in gridlets, then those at
  /// corners, then other cubes; of each kind by depth, brick, place in the brick and number.
  CellPlace place(std::int64_t cell) const;

  /// Whether cubes lie in gridlets. If not, piece 0 is empty, and so are corners().
  bool has_gridlets() const;
  /// Which cells of piece 1 stand at corners.
  const CornerMap& corners() const;

  /// Where the value of a vertex of piece 1 comes from: one leaf, or for a virtual leaf, in a
  /// re-entrant corner and beside ghost cells the sum of weight * value over some, which may name a
  /// leaf more than once. Other vertices on the domain's boundary have the value of the leaf that
  /// they were moved from. Vertices of piece 0 are leaves (GridletsView::leaves).
  struct Terms {
    const std::uint32_t* leaves = nullptr;
    const double* weights = nullptr; ///< null: one term of weight 1
    /// The face of the leaf (2 axis + side) across which the term's ghost cell lies, or no_ghost
    /// (leaf_gradient.h) if it is the leaf itself; null: none is a ghost cell.
    const std::uint8_t* ghosts = nullptr;
    int count = 0;
  };
  Terms terms(std::int64_t vertex) const;
  /// The real leaf that a vertex of piece 1 is in the middle of, lies in or is moved from; of a
  /// mean, one of its leaves. It has the corner of each of the vertex's cells.
  std::uint32_t leaf_at(std::int64_t vertex) const { return *terms(vertex).leaves; }

private:
  struct State;
  std::unique_ptr<State> state_;
};

} // namespace insitu::amr
