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

/// What the parts of a runner share.
namespace insitu::scene {

using MeshList = std::span<commit::CommittedMesh* const>;

/// One cycle, as actions see it.
struct Step {
  MeshList meshes;
  std::int64_t cycle;
  double time;
  bool first;                                ///< the first execution of the session
  double earlier_time;                       ///< of the execution before
  std::span<const double> times_before = {}; ///< of those before it, as far as fields may look back
};

/// Something a scene asks for: a probe, a tracer, a frame. A failed action throws core::Error from
/// execute() and is tried again when it is next due.
class Action {
public:
  virtual ~Action() = default;
  virtual const char* kind() const = 0;
  virtual const std::string& name() const = 0;
  virtual const Trigger& trigger() const = 0;
  virtual const Name& mesh_name() const = 0;
  /// Called at every cycle; due: the trigger says so.
  virtual void execute(commit::CommittedMesh& mesh, const Step& step, bool due) = 0;
  /// The session closes.
  virtual void finish() {}
  /// What a checkpoint knows it by, in words that hold all that its state depends on; empty: it has
  /// none.
  virtual std::string state_name() const { return {}; }
  /// Its state, to a checkpoint or back.
  virtual void keep(core::Archive& /*archive*/) {}
  /// Before the first cycle after a restart: the mesh has the cells of the checkpoint.
  virtual void take_up_cells() {}
  /// Adds what it needs of the mesh beyond the tree, and what it does without. May throw like
  /// execute().
  virtual void plan(const commit::CommittedMesh& mesh, Plan& plan) const = 0;
  /// What became of its particles, if it has any.
  virtual std::optional<advect::Counts> particles() const { return std::nullopt; }
  /// The fields whose earlier steps it needs at the next cycle.
  virtual std::vector<mesh::KeptField> needs_earlier() const { return {}; }
  /// Whether these steps serve it over a change of topology as well.
  virtual bool goes_on_to_other_cells() const { return false; }
};

/// What every action is made with.
struct Environment {
  core::Context& context;
  Statistics& statistics;
  FrameStructures& structures;
  CinemaTable& table;         ///< of the frames' files
  std::string scene_file;     ///< for messages
  std::string output;         ///< folder
  PageRecord* page = nullptr; ///< null: the scene has none
};

/// The mesh of that name (the first one if empty); throws INSITU_ERROR_SCENE.
commit::CommittedMesh& find_mesh(MeshList meshes, const Name& name, const std::string& scene_file);

/// The field of that name, with "file:line: " before the message if there is none.
mesh::FieldView find_field(const commit::CommittedMesh& mesh, const Name& name,
                           const std::string& scene_file);
/// The same on the solver's own cells (those of an adaptive mesh, not of its dual).
mesh::FieldView find_own_field(const commit::CommittedMesh& mesh, const Name& name,
                               const std::string& scene_file);

/// Where a curtain stands, in the coordinates it was given in.
struct CurtainPlaces {
  insitu_frame frame = insitu_frame_default();
  std::vector<math::Vec3d> stations; ///< x, y, 0
  std::vector<double> distances;     ///< [station] along its path: metres, or lengths of the frame
  std::vector<double> levels;        ///< the third coordinates
};

/// Points of a scene in the mesh's coordinates.
struct ScenePoints {
  std::vector<math::Vec3d> mesh_points;
  std::vector<std::string> names;       ///< or empty
  std::optional<CurtainPlaces> curtain; ///< then the points are [station][level]
};
ScenePoints resolve_points(const PointSource& source, const FrameOfReference& frame,
                           const commit::CommittedMesh& mesh, const std::string& scene_file);

/// Minimum, maximum or mean of a field (of a vector field's magnitudes) over owning cells, or over
/// the vertices they use. NaN values are left out; NaN if nothing is left.
double reduce_field(const commit::CommittedMesh& mesh, const Name& field,
                    const std::string& scene_file, Reduction reduction,
                    const core::Threads& threads);

/// A flat cell id of mesh.mesh().own_view() in the solver's numbering; -1 outside.
struct OwnCell {
  std::int32_t piece = -1;
  std::int64_t cell = -1;
  std::int64_t flat = -1; ///< counted through the pieces: what tables without pieces name
};
OwnCell own_cell(const mesh::MeshView& mesh, std::int64_t flat);
/// The same of a cell of mesh.mesh().view() that holds the point.
OwnCell own_cell(const commit::CommittedMesh& mesh, std::int64_t flat, const math::Vec3d& at);

/// Whether files name pieces beside cells: where there are several, and of adaptive meshes, whose
/// patches come and go, always. A table that grows keeps the answer of when it was opened.
bool names_pieces(const mesh::Mesh& mesh);

/// Of a table that grows and was opened for a mesh of one piece: says once that the mesh has
/// several by now, so that cells are counted through them.
class OnePieceNote {
public:
  void say(bool several, const std::string& path, const core::Log& log);

private:
  bool said_ = false;
};

/// Throws INSITU_ERROR_FIELD if a table that is open cannot take these columns any more: fields
/// changed during the run.
void require_columns(const output::AppendTable& table, const std::vector<std::string>& open,
                     const std::vector<std::string>& now);

/// Writes the rows. Rows that cannot be written wait for the next flush, but not without limit: a
/// disk that stays full must not fill the memory too.
void flush_table(output::AppendTable& table);
void flush_table(output::NetcdfTable& table);

/// Formats of one item, of which one that fails does not keep the others from being written.
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

/// "velocity_x" and so on for the components of a field.
std::vector<std::string> component_names(const mesh::FieldView& field);

/// `<output>/<name>_<cycle, six digits><extension>`
std::string cycle_path(const Environment& environment, const std::string& name, std::int64_t cycle,
                       const std::string& extension);

} // namespace insitu::scene
