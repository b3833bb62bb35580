#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "commit/standins/dual_cells.h"
#include "commit/standins/leaves_copy.h"
#include "commit/standins/stand_in.h"
#include "query/lattice/place_locators.h"
#include "query/on_demand.h"

namespace insitu::commit {

class Halo;

/// Of adaptive meshes: which cells are leaves and, unless the reconstruction is `nearest`, the dual
/// in their place.
class Adaptive final : public StandIn {
public:
  using IsBefore = std::function<bool(std::uint32_t, std::uint32_t)>;

  explicit Adaptive(core::Memory& memory)
      : memory_(&memory), masked_(memory, INSITU_MEMORY_AMR), later_(*this) {}

  bool serves(const mesh::Mesh& mesh, const insitu_frame& frame) const override {
    return mesh.is_adaptive() && frame.kind != INSITU_FRAME_GEODETIC;
  }
  void require(const std::string& mesh_name, const query::LocatorPick& pick,
               bool on_device) const override;
  std::optional<cells::Validation> validate(const mesh::Mesh& mesh,
                                            const core::Threads& threads) const override;
  bool is_due(const mesh::Mesh& mesh, std::uint32_t changed) const override;
  Found commit(mesh::Mesh& mesh, const insitu_frame& frame, std::uint32_t changed,
               const core::Threads& threads, const core::Log& log) override;
  /// Collective, of a mesh whose halo is in its views: makes ready what the next commit, which is
  /// due, puts in place. mesh: of a process that has none, an adaptive one without pieces.
  /// is_before: of the leaves' flat ids, in the order of all processes; it must outlive what is
  /// built.
  void make_on_all(mesh::Mesh& mesh, parallel::World& world, const Halo& halo,
                   const IsBefore& is_before, const core::Threads& threads);
  bool is_made() const override { return true; }
  const mesh::MeshView& keep(std::vector<std::int64_t> first_cell,
                             const core::Threads& threads) override;

  bool stands() const override { return dual_ != nullptr; }
  bool waits() const override { return later_.is_due(); }
  const mesh::MeshView& view() const override { return dual().view(); }
  mesh::FieldView field(const mesh::FieldView& own) override { return dual().field(own); }
  /// The leaf that holds p, with p's place in it.
  query::Location own(const query::Location& at, const math::Vec3d& p) const override;
  query::Location own_here(const query::Location& at, const math::Vec3d& p) const override;
  std::optional<MadeCell> made_cell(std::int64_t flat) const override;
  std::int64_t find_made(std::int64_t number) const override;
  const query::PointLocator* locator() const override {
    later_.complete();
    return locator_.get();
  }
  /// Null by `nearest`.
  const DualCells* dual_cells() const { return dual_ ? &dual() : nullptr; }
  const amr::LeafMap& leaves() const { return leaves_ ? *leaves_ : dual_->dual().leaves(); }
  /// Whether other processes have more of the mesh.
  bool is_shared() const { return bool(is_before_); }
  /// Of a cell of the dual: numbers ascend with the ids, alike on all processes.
  std::int64_t number(std::int64_t flat) const {
    return is_before_ ? dual_->order().number(dual_->dual(), flat) : flat;
  }
  /// Ids of leaves below are this process's.
  std::int64_t own_cells() const { return own_cells_; }
  std::optional<Held> held() const override;
  std::optional<insitu_amr_info> amr_info() const override;

private:
  /// The dual of this process's leaves alone, of a mesh that is spread over processes: mostly
  /// nobody asks for it before the halo is there, with which make_on_all() makes another one.
  class Later final : public query::PutOff {
  public:
    explicit Later(Adaptive& of) : of_(of) {}
    void put_off(const mesh::Mesh& mesh, int threads) {
      mesh_ = &mesh;
      threads_ = threads;
      set_due(true);
    }
    void forget() { set_due(false); }

  private:
    void do_it() const override {
      of_.make_dual(*mesh_, arena_.emplace(threads_), nullptr);
      of_.choose_locator();
    }

    Adaptive& of_;
    const mesh::Mesh* mesh_ = nullptr;
    int threads_ = 1;
    mutable std::optional<core::Threads> arena_; ///< which the dual keeps for its fields
  };

  DualCells& dual() const {
    later_.complete();
    return *dual_;
  }
  void build(mesh::Mesh& mesh, const core::Threads& threads,
             const DualCells::Neighbours* neighbours = nullptr);
  void put_off(mesh::Mesh& mesh, const core::Threads& threads);
  void begin(mesh::Mesh& mesh);
  void build_leaves(const mesh::Mesh& mesh, const core::Threads& threads);
  void make_dual(const mesh::Mesh& mesh, const core::Threads& threads,
                 const DualCells::Neighbours* neighbours);
  void choose_locator();
  void put_in_place(mesh::Mesh& mesh, const core::Threads& threads);
  query::Location in_leaf(const amr::LeafMap::Leaf& leaf, const math::Vec3d& p) const;
  void mask(const mesh::AmrView& mesh, const core::Threads& threads);

  core::Memory* memory_;
  std::unique_ptr<DualCells> dual_;
  std::unique_ptr<amr::LeafMap> leaves_; ///< without a dual, or of one that was put off
  std::unique_ptr<query::PointLocator> locator_;
  std::unique_ptr<LeavesCopy> kept_;   ///< of a step that has passed, without a dual
  core::Buffer<std::uint64_t> masked_; ///< a bit a flat cell
  IsBefore is_before_;                 ///< empty: by ids
  std::int64_t own_cells_ = 0;
  bool is_ready_ = false; ///< for the next commit
  double build_s_ = 0.0;
  Later later_;
};

} // namespace insitu::commit
