#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cells/polyhedra/made_points.h"
#include "cells/polyhedra/parts.h"
#include "commit/standins/gathered_fields.h"
#include "commit/standins/stand_in.h"
#include "core/memory.h"

namespace insitu::commit {

/// A mesh with pieces whose cells are given by faces. What they are cut into (cells::Parts) stands
/// in for them, piece by piece; pieces of cells with shapes are as they are. Parts are in the order
/// of the solver's cells, so that the lowest part that holds a point is of the lowest cell that
/// does. Where vertices are made, the vertices and the fields on them are copies with the made ones
/// behind; fields on cells are copies where a cell has several parts. Fields are gathered when they
/// are first asked for after a commit. Vertices that move move the made ones, and the cells stay
/// what they are.
class Polyhedral final : public StandIn {
public:
  explicit Polyhedral(core::Memory& memory);
  ~Polyhedral() override;

  bool serves(const mesh::Mesh& mesh, const insitu_frame& frame) const override {
    return mesh.has_faces() && frame.kind != INSITU_FRAME_GEODETIC;
  }
  void require(const std::string& mesh_name, const query::LocatorPick& pick,
               bool on_device) const override;
  std::optional<cells::Validation> validate(const mesh::Mesh& mesh,
                                            const core::Threads& threads) const override;
  bool is_due(const mesh::Mesh& mesh, std::uint32_t changed) const override;
  Found commit(mesh::Mesh& mesh, const insitu_frame& frame, std::uint32_t changed,
               const core::Threads& threads, const core::Log& log) override;
  bool is_made() const override { return false; }
  bool lends_parts() const override { return true; }
  bool stands() const override { return built_; }

  const mesh::MeshView& view() const override { return view_; }
  mesh::MeshView* solver_view() override { return &view_; }
  /// Thread-safe.
  mesh::FieldView field(const mesh::FieldView& own) override;
  /// Places within a cell that is cut are told by no coordinates: they are NaN.
  query::Location own(const query::Location& at, const math::Vec3d& p) const override;
  query::Location own_here(const query::Location& at, const math::Vec3d& p) const override {
    const query::Location own = this->own(at, p);
    return own && own.cell < own_->own_cell_count() ? own : query::Location{};
  }
  Place place(std::int64_t flat) const override;
  std::int64_t find(const Place& place) const override;
  std::optional<Held> held() const override {
    return Held{"cells cut from those given by faces", bytes(), "cut at the last topology"};
  }
  void audit(std::vector<insitu_audit_entry>& entries) const override;

private:
  struct Piece;
  struct Gathered;
  cells::FaceFindings cut(const mesh::Mesh& mesh, const core::Threads& threads);
  void place_vertices(const core::Threads& threads);
  void set_views();
  cells::Validation validated(const std::string& mesh_name, const core::Threads& threads) const;
  void gather(const mesh::FieldView& own, Gathered& to) const;
  void gather_piece(const mesh::FieldView& own, std::int32_t p, Gathered& to) const;
  void count_odd_cells(insitu_validation& counts) const;
  std::int64_t bytes() const;

  core::Memory* memory_;
  const core::Threads* threads_ = nullptr;
  bool built_ = false; ///< since the last change of topology
  const mesh::MeshView* own_ = nullptr;
  std::vector<std::unique_ptr<Piece>> parts_; ///< [own piece], null where cells have shapes
  std::vector<mesh::PieceView> pieces_;
  std::vector<std::int64_t> first_cell_, first_vertex_;
  mesh::MeshView view_;
  GatheredFields<Gathered> fields_;
};

} // namespace insitu::commit
