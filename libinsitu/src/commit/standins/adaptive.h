#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "commit/standins/dual_cells.h"
#include "commit/standins/leaves_copy.h"
#include "commit/standins/stand_in.h"
#include "query/lattice/place_locators.h"

namespace insitu::commit {

/// Of adaptive meshes: which cells are leaves and, unless the reconstruction is `nearest`, the dual
/// in their place.
class Adaptive final : public StandIn {
public:
  explicit Adaptive(core::Memory& memory) : memory_(&memory), masked_(memory, INSITU_MEMORY_AMR) {}

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
  bool is_made() const override { return true; }
  const mesh::MeshView& keep(std::vector<std::int64_t> first_cell,
                             const core::Threads& threads) override;

  bool stands() const override { return dual_ != nullptr; }
  const mesh::MeshView& view() const override { return dual_->view(); }
  mesh::FieldView field(const mesh::FieldView& own) override { return dual_->field(own); }
  /// The leaf that holds p, with p's place in it.
  query::Location own(const query::Location& at, const math::Vec3d& p) const override;
  const query::PointLocator* locator() const override { return locator_.get(); }
  std::optional<Held> held() const override;
  std::optional<insitu_amr_info> amr_info() const override;

private:
  void build(mesh::Mesh& mesh, const core::Threads& threads);
  void mask(const mesh::AmrView& mesh, const core::Threads& threads);
  const amr::LeafMap& leaves() const { return dual_ ? dual_->dual().leaves() : *leaves_; }

  core::Memory* memory_;
  std::unique_ptr<DualCells> dual_;
  std::unique_ptr<amr::LeafMap> leaves_; ///< without a dual
  std::unique_ptr<query::PointLocator> locator_;
  std::unique_ptr<LeavesCopy> kept_;   ///< of a step that has passed, without a dual
  core::Buffer<std::uint64_t> masked_; ///< a bit a flat cell
  double build_s_ = 0.0;
};

} // namespace insitu::commit
