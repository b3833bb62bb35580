#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "advect/particles.h"
#include "output/files/checkpoint.h"
#include "scene/checkpoint/kept_mesh.h"
#include "scene/parse/description.h"
#include "scene/record/records.h"
#include "scene/run/action.h"
#include "scene/run/environment.h"
#include "scene/run/step.h"

namespace insitu::scene {

class ProbeAction;

/// Executes a scene, cycle by cycle. Holds the tracers' particles and the open tables. execute(),
/// write_checkpoint() and restart() are collective over the processes of the World.
class Runner {
public:
  /// output: overrides the scene's folder if not empty. Throws core::Error for what this build
  /// lacks.
  Runner(const SceneDescription& scene, const std::string& output, core::Context& context,
         parallel::World& world, Statistics& statistics);
  ~Runner();

  /// Does what is due. The meshes are committed, and of the same names in the same order on all
  /// processes. Failures are counted and skipped, and the root logs them; the returned text, the
  /// same on all processes, holds one line each, empty if all went well. A call with cycle and time
  /// of the call before, of which something failed, does that step again: what failed, and nothing
  /// of what was done.
  std::string execute(MeshList meshes, std::int64_t cycle, double time);
  /// What the session does after execute() has failed, so that the step can be done again.
  void fail_step() { live_.is_failed = true; }

  /// Does what is due by this cycle and time at a step that is held, whose meshes these are, but
  /// for the actions that go on with live steps, which the root's log names once. Nothing else is
  /// told of it: the next live step follows the last one. Otherwise as execute().
  std::string execute_held(MeshList meshes, std::int64_t cycle, double time);
  /// The meshes of the next execute_held() may be others.
  void show_other() { held_.is_failed = false; }
  /// Meshes whose structures frames keep, by their ids, whichever are executed.
  void keep_structures_of(std::vector<std::uint64_t> meshes) {
    structures_.keep_also(std::move(meshes));
  }

  /// From the next execute on all processes keep what probes answer, or none does any more.
  void keep_answers(bool keep);
  /// The scene's probes, in its order.
  const std::vector<ProbeAction*>& probes() const { return probes_; }

  /// What its items need of the meshes, which are committed, and what they do without.
  Plan plan(MeshList meshes) const;

  /// Writes the state of all tracers and moving probes, as it is after the last execute(), to a
  /// file, which is the root's and the same on any number of processes but for the parts of meshes.
  /// The meshes are as they were then. Throws parallel::AgreedError.
  void write_checkpoint(const std::string& path, MeshList meshes);
  /// Takes it up again, on as many processes or on others, before the first execute(). Throws
  /// core::Error (INSITU_ERROR_FILE) on all processes alike for a file that is not of this scene;
  /// this runner is then of no use.
  void restart(const std::string& path);

  /// Writes the meshes to a file, which is the root's, as what was committed at that cycle. Throws
  /// parallel::AgreedError.
  void write_record(const std::string& path, MeshList meshes, std::int64_t cycle, double time);

  /// Ends tracers and closes tables. Returns failures like execute().
  std::string finish();
  /// Before finish(), if messages can still be sent: what actions need of other processes then.
  /// Collective. Returns what failed, on all processes alike.
  std::string meet_end();

  /// Particles of all tracers, as far as this process has them.
  advect::Counts particle_counts() const;

  /// How often the structures of frames were made.
  render::Structures::Counts structure_counts() const { return structures_.counts(); }
  render::Structures::Seconds structure_seconds() const { return structures_.seconds(); }

  /// How often the vertices of meshes were made geocentric, for frames.
  std::int64_t geocentric_conversions() const { return structures_.geocentric_conversions(); }

  const LocatorOptions& locator() const { return locator_; }
  double seam_tolerance() const { return seam_tolerance_; }
  /// All texts of the scene, so also the names of all fields that it asks for but for probes of all
  /// fields, which own cells alone answer. Null of the default scene.
  const std::shared_ptr<const std::string>& words() const { return words_; }
  const std::string& output() const { return environment_.output; }

private:
  /// How far a step came.
  struct Attempt {
    enum class State : std::uint8_t { none, begun, done };
    std::int64_t cycle = 0;
    double time = 0.0;
    bool is_first = false;  ///< execution of the session
    bool is_failed = false; ///< in something, so that it can be done again
    bool any_due = false;
    bool has_entry = false;     ///< on the page
    bool is_kept = false;       ///< for the next step
    std::vector<State> actions; ///< by action
    std::vector<double> times;  ///< of the executions before it, the latest first

    bool is_again(std::int64_t of_cycle, double at) const {
      return is_failed && cycle == of_cycle && time == at;
    }
  };

  bool is_due(const Action& action, const commit::CommittedMesh& mesh, const Step& step) const;
  void execute(Action& action, const Step& step, Attempt::State& state, bool& any_due);
  void execute_actions(const Step& step, Attempt& attempt, std::string& failures);
  void execute_all(const Step& step, Attempt& attempt, std::string& failures);
  void begin(Attempt& attempt, std::int64_t cycle, double time);
  void leave_out(const Action& action);
  void failed(std::string& failures, const std::string& of, const core::Error& error,
              std::int64_t cycle);
  bool is_for_want_of_cells(const Action& action, const core::Error& error, MeshList meshes) const;
  void keep_earlier(MeshList meshes);
  void keep_step(const Step& step, std::string& failures);
  void note_tracers();
  void log_particles(const Action& action, std::int64_t cycle) const;
  void end_page_cycle(const Step& step, Attempt& attempt);
  void finish_page(const std::string& failures);
  void note_cycle(std::int64_t cycle);
  void report(const std::string& what, const std::string& of, std::int64_t cycle);
  void keep(core::Archive& archive, const std::string& path);
  void write_mesh(const commit::CommittedMesh& mesh, output::CheckpointWriter* file);
  void read_mesh(core::Archive& shared, output::CheckpointReader* file, const std::string& path);
  void take_up_meshes(MeshList meshes);
  void write_due_checkpoint(MeshList meshes);
  void write_step_files(MeshList meshes, std::string& failures);

  const bool with_page_;
  std::unique_ptr<PageRecord> page_; ///< at the root
  ProcessSeconds seconds_;           ///< of the page's entries
  FrameStructures structures_;
  FieldReductions reductions_;
  CinemaTable table_;
  Environment environment_;
  LocatorOptions locator_;
  double seam_tolerance_;
  std::shared_ptr<const std::string> words_;
  std::vector<std::unique_ptr<Action>> actions_;
  std::vector<ProbeAction*> probes_; ///< of the actions
  std::map<std::string, std::set<std::string>>
      reported_; ///< failures logged, by action, so that a log is not flooded
  std::set<std::string> left_out_; ///< actions that were named as going on with live steps
  Attempt live_, held_;            ///< the last step of each kind
  const Attempt* last_ = nullptr;  ///< of both
  bool executed_ = false;
  std::int64_t cycle_ = 0;                            ///< the last one executed
  std::int64_t lowest_cycle_ = 0, highest_cycle_ = 0; ///< of this session
  bool told_cycles_ = false;                          ///< that cycles come again
  bool descends_ = false;                             ///< it was less than the one before
  std::vector<double> times_;                         ///< of the last executions, the latest first
  CheckpointOptions checkpoint_;
  RecordOptions record_;
  std::string scene_text_; ///< for records
  Records records_;
  std::vector<KeptMesh> kept_meshes_; ///< of a restart, until the first execute()
};

} // namespace insitu::scene
