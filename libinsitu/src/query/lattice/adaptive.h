#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "query/lattice/dual_stand_in.h"
#include "query/sampler.h"

namespace insitu::query {

/// What a committed adaptive mesh keeps: which cells are leaves and, unless its reconstruction is
/// `nearest`, its dual.
class Adaptive {
public:
  explicit Adaptive(core::Memory& memory) : memory_(&memory), masked_(memory, INSITU_MEMORY_AMR) {}

  /// At a regrid: brings the mesh's views to the leaves, and the dual in their place. Throws
  /// INSITU_ERROR_MESH; the mesh then must not be used.
  void build(mesh::Mesh& mesh, const core::Threads& threads);
  /// Whether it was built for the mesh's reconstruction.
  bool fits(const mesh::Mesh& mesh) const {
    return (dual_ != nullptr) == (mesh.reconstruction() == INSITU_DUAL);
  }
  /// The solver's values changed.
  void fields_changed();

  /// The places of the dual's gridlets and of its stitching cells; null for `nearest`, where
  /// leaves() tells all.
  const GridletPlaces* gridlets() const { return dual_ ? &dual_->places() : nullptr; }
  const amr::CornerMap* corners() const { return dual_ ? &dual_->dual().corners() : nullptr; }
  /// The dual's cells; null for `nearest`.
  const mesh::MeshView* dual_view() const { return dual_ ? &dual_->view() : nullptr; }
  const amr::LeafMap& leaves() const { return dual_ ? dual_->dual().leaves() : *leaves_; }
  /// A location as the solver counts cells: the leaf that holds p, with p's place in it, flat over
  /// the solver's pieces.
  Location own(const Location& at, const math::Vec3d& p) const;
  insitu_amr_info info() const;

private:
  void mask(const mesh::AmrView& mesh, const core::Threads& threads);

  core::Memory* memory_;
  std::unique_ptr<DualStandIn> dual_;
  std::unique_ptr<amr::LeafMap> leaves_; ///< without a dual
  core::Buffer<std::uint64_t> masked_;   ///< a bit a flat cell
  double build_s_ = 0.0;
};

} // namespace insitu::query
