#pragma once

#include <memory>
#include <string>
#include <vector>

#include "commit/standins/chart_cells.h"
#include "commit/standins/gathered_fields.h"
#include "commit/standins/stand_in.h"
#include "core/memory.h"

namespace insitu::commit {

/// A mesh in longitude, latitude and height or depth. Its cells are located where they are, in its
/// own chart and arrays; the few that wrap around or lie near a pole that is within a cell are
/// located in copies (ChartCells), which then stand in for them, as pieces behind the solver's own:
/// all cells of these are there under their own ids, the hidden ones as ghosts. A halo, and copies
/// of its cells, come behind all these. Over several processes the chart is that of all their
/// cells, once it is known (set_whole_chart()); a commit that finds other facts here keeps to what
/// was known of the others. Fields are gathered to the copies when they are first asked for after a
/// commit; vectors (3 components: east, north, up) of those at a pole are turned to its chart's
/// east and north.
class Geodetic final : public StandIn {
public:
  explicit Geodetic(core::Memory& memory);
  ~Geodetic() override;

  bool serves(const mesh::Mesh& mesh, const insitu_frame& frame) const override {
    return !mesh.is_adaptive() && !mesh.has_faces() && frame.kind == INSITU_FRAME_GEODETIC;
  }
  void require(const std::string& mesh_name, const query::LocatorPick& pick,
               bool on_device) const override;
  bool is_due(const mesh::Mesh& mesh, std::uint32_t changed) const override;
  Found commit(mesh::Mesh& mesh, const insitu_frame& frame, std::uint32_t changed,
               const core::Threads& threads, const core::Log& log) override;
  bool is_made() const override { return false; }
  bool tells_one_mesh() const override { return true; }

  /// Without copies the solver's cells are located as they are.
  bool stands() const override { return has_copies(); }
  bool has_copies() const { return !copies_.empty(); }
  std::int64_t copied_cells() const;
  std::int64_t hidden_cells() const { return std::int64_t(hidden_.size()); }
  std::int64_t bytes() const;

  const mesh::MeshView& view() const override { return view_; }
  mesh::MeshView* solver_view() override { return &view_; }
  /// Thread-safe.
  mesh::FieldView field(const mesh::FieldView& own) override;
  query::Location own(const query::Location& at, const math::Vec3d& p) const override;
  Place place(std::int64_t flat) const override;
  std::int64_t own_vertex(std::int64_t flat) const override;
  std::int64_t find(const Place& place) const override;
  const ChartFacts* chart_facts() const override { return &facts_; }
  const ChartFacts* whole_chart() const override { return &whole_; }
  void begin_chart(double west) override { west_ = west; }
  bool has_whole_chart() const override { return has_whole_; }
  bool set_whole_chart(const ChartFacts& whole) override;
  void take_chart(const StandIn& of, bool is_part) override;
  const query::ChartImage& image() const { return image_; }
  const query::ChartImage* chart() const override { return &image_; }
  std::optional<Held> held() const override {
    return Held{"copies of cells at the seam and the poles", bytes(), "a geodetic mesh"};
  }
  void audit(std::vector<insitu_audit_entry>& entries) const override;

private:
  struct Key;
  struct Turn;
  struct Copies;
  struct Gathered;
  /// Of a piece of view(): its copies, or else the piece of own_view() that it is.
  struct Of {
    const Copies* copies;
    std::int32_t piece;
  };
  Of piece_of(std::int32_t piece) const;
  bool build(const mesh::Mesh& mesh, const geo::ChartUnits& units, bool other_cells,
             const core::Threads& threads);
  Turn turn_of(geo::Pole pole, const math::Vec3d& east, const math::Vec3d& turned) const;
  void copy(const mesh::MeshView& own, const std::vector<ChartCopy>& cells, Copies& to) const;
  void hide(const mesh::MeshView& own, const core::Threads& threads);
  void set_views(const mesh::MeshView& own);
  void gather(const mesh::FieldView& own, Gathered& to) const;

  core::Memory* memory_;
  bool built_ = false; ///< at the last commit that changed cells or vertices
  const mesh::MeshView* own_ = nullptr;
  ChartFacts facts_, whole_;                      ///< of this process's cells, and of all
  bool has_whole_ = false, knows_others_ = false; ///< whole_ is that; it was once
  double west_ = ChartFacts::none;                ///< where the chart begins at the latest
  query::ChartImage image_;
  std::vector<std::int64_t> hidden_;
  /// Seam, north, south: those there are; own_copies_ of them of own cells, then those of a halo's.
  std::vector<std::unique_ptr<Copies>> copies_;
  std::size_t own_copies_ = 0;
  std::vector<std::unique_ptr<core::Buffer<std::uint8_t>>> masks_; ///< [own piece] or null
  std::vector<mesh::PieceView> pieces_;
  std::vector<std::int64_t> first_cell_, first_vertex_;
  mesh::MeshView view_;
  GatheredFields<Gathered> fields_;
};

} // namespace insitu::commit
