#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cells/checks/validate.h"
#include "commit/standins/chart_cells.h"
#include "core/log.h"
#include "mesh/registered/mesh.h"
#include "query/chart_image.h"
#include "query/locator_choice.h"
#include "query/point_locator.h"

namespace insitu::commit {

/// What a kind of mesh needs whose points are not simply located in the solver's cells: other cells
/// in their place (view(), if stands()), a locator of its own, a chart. A committed mesh has at
/// most one stand-in, and asks it instead of asking what the mesh is. A new kind of mesh is a new
/// stand-in here and a line in make_stand_in().
class StandIn : public mesh::StandIn {
public:
  /// Whether this is the stand-in for the mesh as it is registered by now.
  virtual bool serves(const mesh::Mesh& mesh, const insitu_frame& frame) const = 0;
  /// Throws INSITU_ERROR_UNSUPPORTED, by the mesh's name, where points cannot be located so.
  virtual void require(const std::string& mesh_name, const query::LocatorPick& pick,
                       bool on_device) const = 0;

  /// Validates the mesh as it is registered, if its cells have no vertices of the solver's. An
  /// empty optional means that the cells are validated like those of any mesh.
  virtual std::optional<cells::Validation> validate(const mesh::Mesh& /*mesh*/,
                                                    const core::Threads& /*threads*/) const {
    return std::nullopt;
  }

  /// What a commit found.
  struct Found {
    bool other_cells = false; ///< than before
    /// Of the solver's cells, where these were looked at and are located as they are.
    std::optional<cells::Validation> validation;
  };
  /// Whether a commit of these changes (INSITU_CHANGED_*) makes cells anew.
  virtual bool is_due(const mesh::Mesh& mesh, std::uint32_t changed) const = 0;
  /// Brings the cells up to date with the mesh, after its update(), and puts them in place.
  /// Throws core::Error; the stand-in then must not be used but for another commit.
  virtual Found commit(mesh::Mesh& mesh, const insitu_frame& frame, std::uint32_t changed,
                       const core::Threads& threads, const core::Log& log) = 0;

  /// True: the cells are made from the solver's (a dual, leaves), right by construction, without
  /// vertices of the solver's that move, and go with the step they are of (keep()). False: they are
  /// the solver's, some of them in copies elsewhere.
  virtual bool is_made() const = 0;
  /// The cells of a step that has passed, if is_made(): without the solver's arrays from now on.
  /// first_cell: of the solver's pieces, [piece count + 1].
  virtual const mesh::MeshView& keep(std::vector<std::int64_t> /*first_cell*/,
                                     const core::Threads& /*threads*/) {
    return view();
  }
  /// Whether other processes get cells of view(), and fields on them, and not the solver's own.
  virtual bool lends_parts() const { return false; }
  /// Whether view().one_mesh is told by the stand-in, and not looked for.
  virtual bool tells_one_mesh() const { return false; }
  /// Whether view() is in place; if not, points are located in the solver's cells.
  virtual bool stands() const = 0;
  /// Whether view() is made when somebody asks for it, or for its locator, and nobody has yet.
  virtual bool waits() const { return false; }

  /// A cell of view() that is the solver's: which, and in which of its places (mesh::CellName), or
  /// which of its parts.
  struct Place {
    std::int64_t own; ///< flat over the pieces of own_view()
    std::int32_t chart = 0, copy = 0;
  };
  virtual Place place(std::int64_t flat) const { return {flat}; }
  /// The same of a vertex of view(), whose cells are the solver's: its flat number in own_view().
  virtual std::int64_t own_vertex(std::int64_t flat) const { return flat; }
  /// The flat id of such a cell; -1: it has no such place.
  virtual std::int64_t find(const Place& place) const { return place.own; }

  // Of a mesh in longitude and latitude over several processes.
  /// What a chart takes from this process's cells, and whether it is that of all processes'.
  virtual const ChartFacts* chart_facts() const { return nullptr; }
  /// The same of all processes, as far as it is known.
  virtual const ChartFacts* whole_chart() const { return nullptr; }
  /// Before a commit: the chart begins at this longitude, unless cells begin further west.
  virtual void begin_chart(double /*west*/) {}
  virtual bool has_whole_chart() const { return true; }
  /// From the next commit on the chart is that of all processes' cells, until those here tell other
  /// facts. Returns whether the chart is another than that of the last commit.
  virtual bool set_whole_chart(const ChartFacts& /*whole*/) { return false; }
  /// Before the first commit, of the mesh that another stand-in is of, in copies: takes the chart
  /// that this one has, on all processes, which may be of steps before as well. is_part: there are
  /// several.
  virtual void take_chart(const StandIn& /*of*/, bool /*is_part*/) {}

  /// A location as the solver counts cells, flat over its pieces; at may be outside.
  virtual query::Location own(const query::Location& at, const math::Vec3d& p) const = 0;
  /// The same of this process's cells alone, where others' are beside them.
  virtual query::Location own_here(const query::Location& at, const math::Vec3d& p) const {
    return own(at, p);
  }
  /// Of a cell that is made and exists on several processes, alike on all of them: its number, and
  /// the solver's cell, by its flat id here, whose process owns it.
  struct MadeCell {
    std::int64_t number, owner;
  };
  virtual std::optional<MadeCell> made_cell(std::int64_t /*flat*/) const { return std::nullopt; }
  /// The cell here of that number; -1: none.
  virtual std::int64_t find_made(std::int64_t /*number*/) const { return -1; }
  /// How points find these cells; null: as in any mesh.
  virtual const query::PointLocator* locator() const { return nullptr; }
  /// Where points of the mesh's frame lie among the cells; null: where they are.
  virtual const query::ChartImage* chart() const { return nullptr; }

  /// Memory that is held with the mesh: what for, bytes, why.
  struct Held {
    const char* item;
    std::int64_t bytes;
    const char* why;
  };
  virtual std::optional<Held> held() const = 0;
  /// Adds copies of the solver's arrays.
  virtual void audit(std::vector<insitu_audit_entry>& /*entries*/) const {}
  /// Of adaptive meshes.
  virtual std::optional<insitu_amr_info> amr_info() const { return std::nullopt; }
};

/// The stand-in for the mesh as it is registered; null if it needs none. Throws
/// INSITU_ERROR_UNSUPPORTED for a kind of mesh in a frame that it cannot be located in.
std::unique_ptr<StandIn> make_stand_in(const mesh::Mesh& mesh, const insitu_frame& frame,
                                       core::Memory& memory);

} // namespace insitu::commit
