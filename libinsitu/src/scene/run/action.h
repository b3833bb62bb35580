#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "advect/particles.h"
#include "commit/committed_mesh.h"
#include "core/archive.h"
#include "core/context.h"
#include "core/status.h"
#include "output/files/csv.h"
#include "output/netcdf/netcdf_table.h"
#include "scene/frames/cinema_table.h"
#include "scene/frames/frame_structures.h"
#include "scene/parse/description.h"
#include "scene/run/page_record.h"
#include "scene/run/plan.h"
#include "scene/run/statistics.h"

/// Types and functions that the parts of a runner share.
namespace insitu::scene {

using MeshList = std::span<commit::CommittedMesh* const>;

/// One cycle of the solver, as actions see it.
struct Step {
  MeshList meshes;
  std::int64_t cycle;
  double time;
  bool first;                                ///< whether this is the first execution of the session
  double earlier_time;                       ///< time of the execution before this one
  std::span<const double> times_before = {}; ///< times of the executions before earlier_time, as
                                             ///< far as fields may look back
};

/// An action is something that a scene asks for: a probe, a tracer, a frame. An action that fails
/// throws core::Error from execute(), and the runner tries it again when it is next due.
class Action {
public:
  virtual ~Action() = default;
  virtual const char* kind() const = 0;
  virtual const std::string& name() const = 0;
  virtual const Trigger& trigger() const = 0;
  virtual const Name& mesh_name() const = 0;
  /// Runs the action. The runner calls this at every cycle; due says whether the trigger holds.
  virtual void execute(commit::CommittedMesh& mesh, const Step& step, bool due) = 0;
  /// Ends the action when the session closes.
  virtual void finish() {}
  /// Returns the name by which a checkpoint knows the state of the action, in words that hold
  /// everything that the state depends on. An empty name means that the action has no state.
  virtual std::string state_name() const { return {}; }
  /// Writes the state of the action to a checkpoint, or reads it from one.
  virtual void keep(core::Archive& /*archive*/) {}
  /// The runner calls this before the first cycle after a restart, when the mesh has the cells of
  /// the checkpoint.
  virtual void take_up_cells() {}
  /// Adds to the plan what the action needs of the mesh beyond the tree, and what it does without.
  /// May throw as execute() does.
  virtual void plan(const commit::CommittedMesh& mesh, Plan& plan) const = 0;
  /// Returns what became of the particles of the action; an empty optional means that it has no
  /// particles.
  virtual std::optional<advect::Counts> particles() const { return std::nullopt; }
  /// Returns the fields whose earlier steps the action needs at the next cycle.
  virtual std::vector<mesh::KeptField> needs_earlier() const { return {}; }
  /// Returns whether these earlier steps serve the action over a change of topology as well.
  virtual bool goes_on_to_other_cells() const { return false; }
};

/// Every action is made with an Environment.
struct Environment {
  core::Context& context;
  Statistics& statistics;
  FrameStructures& structures;
  CinemaTable& table;         ///< the table of the files of frames
  std::string scene_file;     ///< path of the scene file, for messages
  std::string output;         ///< output folder
  PageRecord* page = nullptr; ///< the page of the run; null: the scene asks for no page
};

/// Returns the mesh of that name, or the first mesh if the name is empty. Throws INSITU_ERROR_SCENE
/// if there is no such mesh.
commit::CommittedMesh& find_mesh(MeshList meshes, const Name& name, const std::string& scene_file);

/// Returns the field of that name. If there is none, the message of the error starts with
/// "file:line: ".
mesh::FieldView find_field(const commit::CommittedMesh& mesh, const Name& name,
                           const std::string& scene_file);
/// Returns the field of that name on the own cells of the solver, which on an adaptive mesh are not
/// those of its dual.
mesh::FieldView find_own_field(const commit::CommittedMesh& mesh, const Name& name,
                               const std::string& scene_file);

/// The places of a curtain, in the coordinates in which the scene gives it.
struct CurtainPlaces {
  insitu_frame frame = insitu_frame_default();
  std::vector<math::Vec3d> stations; ///< (x, y, 0) of each station
  std::vector<double> distances;     ///< [station] distance along the path: metres, or lengths of
                                     ///< the frame
  std::vector<double> levels;        ///< [level] third coordinates
};

/// The points of a scene in the coordinates of the mesh.
struct ScenePoints {
  std::vector<math::Vec3d> mesh_points;
  std::vector<std::string> names;       ///< [point] names of the points; empty: the points have
                                        ///< none
  std::optional<CurtainPlaces> curtain; ///< if given, the points are [station][level]
};
ScenePoints resolve_points(const PointSource& source, const FrameOfReference& frame,
                           const commit::CommittedMesh& mesh, const std::string& scene_file);

/// Returns the minimum, maximum or mean of a field (for a vector field, of its magnitudes) over
/// owning cells, or over the vertices that they use. NaN values are left out; the result is NaN if
/// no value is left.
double reduce_field(const commit::CommittedMesh& mesh, const Name& field,
                    const std::string& scene_file, Reduction reduction,
                    const core::Threads& threads);

/// A cell of the own view of a mesh (mesh.mesh().own_view()) in the numbering of the solver; all
/// members are -1 outside.
struct OwnCell {
  std::int32_t piece = -1;
  std::int64_t cell = -1;
  std::int64_t flat = -1; ///< id counted through the pieces, which tables without pieces name
};
OwnCell own_cell(const mesh::MeshView& mesh, std::int64_t flat);
/// Returns the OwnCell of a cell of mesh.mesh().view() that holds the point.
OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at);

/// Returns whether files name pieces beside cells: they do where a mesh has several pieces, and on
/// adaptive meshes, whose patches come and go, always. A table that grows keeps the answer of the
/// time when it was opened.
bool names_pieces(const mesh::Mesh& mesh);

/// Logs once, for a table that grows and was opened for a mesh of one piece, that the mesh has
/// several pieces by now, so that the table counts cells through them.
class OnePieceNote {
public:
  void say(bool several, const std::string& path, const core::Log& log);

private:
  bool said_ = false;
};

/// Throws INSITU_ERROR_FIELD if a table that is open cannot take these columns any more, since the
/// fields changed during the run.
void require_columns(const output::AppendTable& table, const std::vector<std::string>& open,
                     const std::vector<std::string>& now);

/// Writes the rows of a table. Rows that cannot be written wait for the next flush, up to a limit:
/// a disk that stays full must not fill the memory too.
void flush_table(output::AppendTable& table);
void flush_table(output::NetcdfTable& table);

/// Collects the failures of the formats of one item, so that a format that fails does not keep the
/// other formats from being written.
class Failures {
public:
  template <class Act>
  void catch_of(Act&& act) {
    try {
      act();
    } catch (const core::Error& e) {
      text_ += (text_.empty() ? "" : "; ") + std::string(e.what());
      status_ = e.status();
    }
  }
  bool any() const { return !text_.empty(); }
  void throw_if_any() const {
    if (any())
      throw core::Error(status_, text_);
  }

private:
  std::string text_;
  insitu_status status_ = INSITU_OK;
};

insitu_accuracy to_api(Accuracy accuracy);

/// Returns the names of the components of a field: "velocity_x" and so on.
std::vector<std::string> component_names(const mesh::FieldView& field);

/// Returns the path `<output>/<name>_<cycle, six digits><extension>`.
std::string cycle_path(const Environment& environment, const std::string& name, std::int64_t cycle,
                       const std::string& extension);

} // namespace insitu::scene
