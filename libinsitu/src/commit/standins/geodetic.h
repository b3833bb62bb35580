#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "commit/standins/chart_cells.h"
#include "core/memory.h"
#include "mesh/registered/mesh.h"

namespace insitu::commit {

/// A mesh in longitude, latitude and height or depth. Its cells are located where they are, in its
/// own chart and arrays; the few that wrap around or lie near a pole that is within a cell are
/// located in copies (ChartCells), which then stand in for them, as pieces behind the solver's own:
/// all cells of these are there under their own ids, the hidden ones as ghosts. Fields are gathered
/// to the copies when they are first asked for after a commit; vectors (3 components: east, north,
/// up) of those at a pole are turned to its chart's east and north.
class Geodetic final : public mesh::StandIn {
public:
  explicit Geodetic(core::Memory& memory);
  ~Geodetic() override;

  /// After the mesh's update(), when its cells or vertices changed. True if the cells it stands in
  /// for are others than before (from none on). Throws INSITU_ERROR_MESH (find_chart_cells); it
  /// then must not be used.
  bool build(const mesh::Mesh& mesh, const geo::ChartUnits& units, const core::Threads& threads);
  /// The solver's values changed: what was gathered is stale.
  void fields_changed();

  const query::ChartImage& image() const { return image_; }
  /// Otherwise the solver's cells are located as they are, and this does not stand in.
  bool has_copies() const { return !copies_.empty(); }
  std::int64_t copied_cells() const;
  std::int64_t hidden_cells() const { return std::int64_t(hidden_.size()); }
  std::int64_t bytes() const;
  /// The solver's own cell, flat over its pieces.
  std::int64_t own(std::int64_t flat) const;

  const mesh::MeshView& view() const override { return view_; }
  mesh::MeshView* solver_view() override { return &view_; }
  /// Thread-safe.
  mesh::FieldView field(const mesh::FieldView& own) override;

private:
  struct Copies;
  struct Gathered;
  void copy(const mesh::MeshView& own, const std::vector<ChartCopy>& cells, geo::Pole pole,
            Copies& to) const;
  void hide(const mesh::MeshView& own, const core::Threads& threads);
  void set_views(const mesh::MeshView& own);
  void gather(const mesh::FieldView& own, Gathered& to) const;

  core::Memory* memory_;
  const mesh::MeshView* own_ = nullptr;
  query::ChartImage image_;
  std::vector<std::int64_t> hidden_;
  std::vector<std::unique_ptr<Copies>> copies_; ///< seam, north, south: those there are
  std::vector<std::unique_ptr<core::Buffer<std::uint8_t>>> masks_; ///< [own piece] or null
  std::vector<mesh::PieceView> pieces_;
  std::vector<std::int64_t> first_cell_, first_vertex_;
  mesh::MeshView view_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Gathered>> fields_;
};

} // namespace insitu::commit
