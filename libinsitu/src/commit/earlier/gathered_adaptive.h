#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "amr/dual/corner_map.h"
#include "amr/leaves/leaf_map.h"
#include "commit/earlier/earlier_cells.h"
#include "commit/standins/adaptive.h"
#include "commit/standins/leaves_copy.h"
#include "query/elsewhere.h"
#include "query/lattice/place_locators.h"

namespace insitu::commit {

/// What is told of all cells of a dual; null: of no cells that are found by their places.
struct DualReach {
  const amr::CornerMap* corners = nullptr;
  const query::GridletPlaces* places = nullptr;
};

/// Cells of an adaptive mesh's step before that were gathered and are found by their places.
class GatheredAdaptive {
public:
  virtual ~GatheredAdaptive() = default;
  virtual const mesh::MeshView& view() const = 0;
  virtual const query::PointLocator& locator() const = 0;
  virtual DualReach reach() const { return {}; }
  /// Who is asked first about points, where it hangs on what is gathered how they are found.
  virtual void watch_by(const query::Outlook*) {}
};

/// The dual's, with gridlets: points take the same way to their cells as in the whole dual, and
/// have the same coordinates there, where all of its cells and leaves that hold them are gathered.
class GatheredDual final : public GatheredAdaptive {
public:
  /// No cells.
  explicit GatheredDual(core::Memory& memory);
  /// from: vertices come to be in the order of view(). Throws INSITU_ERROR_MESH for more than can
  /// be numbered.
  void build(EarlierCells& from, const core::Threads& threads);
  /// Collective: what is told of all cells becomes that of the whole dual. here: of this process's
  /// part of it, or of none.
  void share(const DualReach& here, parallel::World& world);

  const mesh::MeshView& view() const override { return view_; }
  const query::PointLocator& locator() const override { return locator_; }
  DualReach reach() const override { return {&corners_, &places_}; }
  void watch_by(const query::Outlook* outlook) override { locator_.watch = outlook; }

private:
  /// By places, where all that decides is here.
  struct Locator final : query::PointLocator {
    explicit Locator(const query::DualPlaces& places) : inner(places) {}
    bool find(const math::Vec3d& p, std::int64_t hint, query::Location& at, query::Reason& reason,
              std::int64_t& guess) const override {
      if (watch && watch->is_beyond(p)) {
        at = watch->find(p, 1.0);
        reason = at ? query::Reason::certified : query::Reason::outside;
        return true;
      }
      return inner.find(p, hint, at, reason, guess);
    }
    void with_batches(const query::PointQuery& query, Ask ask) const override {
      inner.with_batches(query, ask);
    }
    const query::DualPlaces* dual() const override { return inner.dual(); }

    query::DualLocator inner;
    const query::Outlook* watch = nullptr;
  };

  void add_gridlets(EarlierCells& from, std::vector<std::int64_t>& vertices);
  void add_others(const EarlierCells& from, std::vector<std::int64_t>& vertices);
  void add_corners(const EarlierCells& from, const core::Threads& threads);
  void add_leaves(EarlierCells& from, const core::Threads& threads);
  void set_views(const EarlierCells& from);

  amr::LeafMap leaves_;
  amr::CornerMap corners_;
  query::GridletPlaces places_;
  Locator locator_;
  std::vector<mesh::Gridlet> gridlets_;
  std::vector<std::uint64_t> full_;
  std::vector<std::int32_t> ids_;   ///< of other cells, 8 each
  std::vector<math::Vec3d> points_; ///< of theirs
  std::int64_t cubes_ = 0;          ///< full cells of gridlets
  mesh::GridletsView gridlets_view_;
  mesh::PieceView pieces_[2];
  std::int64_t first_cell_[3] = {0, 0, 0}, first_vertex_[3] = {0, 0, 0};
  mesh::MeshView view_;
};

/// Leaves, by `nearest`, in the order of their names.
class GatheredLeaves final : public GatheredAdaptive {
public:
  GatheredLeaves(const EarlierCells& from, core::Memory& memory, const core::Threads& threads);
  const mesh::MeshView& view() const override { return copy_->view(); }
  const query::PointLocator& locator() const override { return locator_; }

private:
  amr::LeafMap leaves_;
  std::unique_ptr<LeavesCopy> copy_;
  query::LeafLocator locator_;
};

/// What says how an adaptive mesh's cells are found by their places: of each of `cells`, flat ids
/// of the view, its spot, and of a dual this process's leaves that meet the boxes.
void add_places(const Adaptive& mesh, const mesh::MeshView& view,
                std::span<const std::int64_t> cells, std::span<const mesh::Box> boxes,
                EarlierCells& to);
CellsKind kind_of(const Adaptive& mesh);
/// Where a leaf lies.
mesh::Box box_of(const mesh::Lattice& lattice, const Spot& leaf);

} // namespace insitu::commit
