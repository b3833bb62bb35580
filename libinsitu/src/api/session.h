#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "insitu/c/probe.h"

#include "api/array_watch.h"
#include "api/given_watch.h"
#include "api/output_locks.h"
#include "api/processes.h"
#include "api/query_args.h"
#include "commit/committed_mesh.h"
#include "commit/held/held_steps.h"
#include "core/context.h"
#include "core/memory.h"
#include "scene/run/runner.h"

namespace insitu::api {

/// A mesh of a session, with the handle that the caller holds.
struct SessionMesh {
  SessionMesh(const std::string& name, core::Memory& memory) : mesh(name, memory), watch(memory) {}
  commit::CommittedMesh mesh;
  ArrayWatch watch; ///< used by checked sessions, and so is the next
  GivenWatch given;
  insitu_mesh handle = nullptr;
  bool locator_chosen = false; ///< by the caller, before the scene
};

/// Everything behind an insitu_session. Methods throw core::Error.
class Session {
public:
  /// Makes one of these processes, which open() opens. Not collective: a process that fails here
  /// tells the others.
  Session(const insitu_session_options& options, std::shared_ptr<parallel::World> world);
  ~Session();
  /// Agrees on the options with all processes, and reads the scene.
  void open(const insitu_session_options& options);

  SessionMesh& mesh(const std::string& name);
  std::vector<std::unique_ptr<SessionMesh>>& meshes() { return meshes_; }

  /// A field of a piece was given; what changed is told.
  void note_field(SessionMesh& mesh, std::int32_t piece, const std::string& field);
  void note_changed(SessionMesh& mesh, std::uint32_t what);

  insitu_commit_report commit(SessionMesh& mesh);
  /// Returns what failed, one line each. Collective, as finish() is.
  std::string execute(std::int64_t cycle, double time);
  /// What the scene needs of this process; kept until the next call. Collective, as are the next
  /// ones and write_summary().
  const std::string& plan();
  /// The state of all tracers, to a file and back; the latter before the first execute().
  void checkpoint(const std::string& path);
  /// What was executed last, or is shown, to a file.
  void record(const std::string& path);
  void restart(const std::string& path);
  /// Ends tracers and closes files; returns what failed.
  std::string finish();
  /// Holds the last so many steps from now on; shows one of them, or INSITU_LIVE. Collective
  /// (session_held.cpp).
  void hold(int steps);
  void show(std::int64_t cycle);
  std::vector<std::int64_t> held() const { return held_.cycles(); }
  /// Has all processes keep what probes answer, from the next execute on. Collective.
  void keep_answers(std::int32_t keep);
  /// What probe `probe` of the scene answered last; *count: how many probes the scene has. answers
  /// null: the number alone.
  void answers(std::int32_t probe, insitu_probe_answers* answers, std::int32_t* count);
  /// The mesh that queries are of: the live one, or that of the step that is shown. Throws
  /// INSITU_ERROR_ORDER if that step has none of its name.
  commit::CommittedMesh& answering(SessionMesh& mesh);

  /// locator null: the scene's.
  void choose_locator(SessionMesh& mesh, const insitu_locator* locator);
  void locate(SessionMesh& mesh, const insitu_locate_args& args);
  void sample(SessionMesh& mesh, const insitu_sample_args& args);
  void nearest_vertices(SessionMesh& mesh, const insitu_vertices_args& args);
  void advance(SessionMesh& mesh, const insitu_advance_args& args);
  bool sample_point(SessionMesh& mesh, const std::string& field, const double* point,
                    double* values);

  insitu_report report() const;
  void write_summary(const std::string& path, double solver_seconds);

  core::Context& context() { return context_; }
  /// One thread at a time; see Occupied in entry.h.
  std::atomic<bool> busy{false};
  bool closed = false; ///< read and written while busy

private:
  /// Whether its arrays are watched: not in device memory, which the host does not read.
  bool checks(const SessionMesh& mesh) const {
    return checked_ && !mesh.mesh.mesh().lies_on_device();
  }
  /// The mesh that queries are of, if it may be queried.
  commit::CommittedMesh& committed(SessionMesh& mesh);
  /// Locates the points, a slice at a time, and writes what args asks for and the fields' values.
  void answer(const commit::CommittedMesh& mesh, const insitu_locate_args& args,
              const QueryPoints& points, std::span<const mesh::FieldView> fields,
              double* const* values);
  /// The same of cells of all processes. Collective; throws parallel::AgreedError.
  void ask_everywhere(SessionMesh& to, const insitu_sample_args& args);
  void answer_in_device_memory(const commit::CommittedMesh& mesh, const insitu_locate_args& args,
                               const QueryPoints& points, std::span<const mesh::FieldView> fields,
                               double* const* values);
  void answer_by_device(const commit::CommittedMesh& mesh, const insitu_locate_args& args,
                        const QueryPoints& points, std::span<const mesh::FieldView> fields,
                        double* const* values);
  /// The points of a query in the mesh's frame.
  std::vector<math::Vec3d> points_of(const commit::CommittedMesh& mesh,
                                     const insitu_locate_args& args, const QueryPoints& given);
  /// Calls visit(first, points) for slices of points, as doubles in the mesh's frame.
  void for_each_slice(const commit::CommittedMesh& mesh, const insitu_locate_args& args,
                      const QueryPoints& points,
                      core::FunctionRef<void(std::int64_t, std::span<const math::Vec3d>)> visit);
  std::vector<commit::CommittedMesh*> commit_all();
  /// The meshes as the last execute left them, for what is named in messages. Throws
  /// INSITU_ERROR_ORDER.
  std::vector<commit::CommittedMesh*> executed_meshes(const std::string& what);
  std::string execute_live(std::int64_t cycle, double time);
  std::string execute_shown(std::int64_t cycle, double time);
  std::string run_scene(const std::vector<commit::CommittedMesh*>& meshes, std::int64_t cycle,
                        double time);
  std::string hold_step(const std::vector<commit::CommittedMesh*>& meshes);
  void keep_structures();
  /// Commits them on all processes; they then are the same meshes in the same order.
  std::vector<commit::CommittedMesh*> commit_on_all();
  void meet(const char* call);
  /// Returns the scene, or what a preview draws of it.
  scene::SceneDescription as_asked(scene::SceneDescription scene) const;
  void make_runner(const scene::SceneDescription& scene);
  void make_default_runner(const std::vector<commit::CommittedMesh*>& meshes);
  /// Makes it; returns what is in the way, logged once.
  std::string try_default_runner(const std::vector<commit::CommittedMesh*>& meshes);

  void read_scene(const insitu_session_options& options);

  Processes processes_;
  core::Context context_;
  bool strict_;
  bool default_scene_, preview_;
  bool checked_ = is_checked();
  std::string output_;
  scene::Statistics statistics_;
  core::Buffer<math::Vec3d> query_points_; ///< scratch of queries, kept from one to the next
  std::vector<std::unique_ptr<SessionMesh>> meshes_;
  std::optional<scene::SceneDescription> scene_; ///< that the caller gave
  OutputLocks locks_;                            ///< of what the runner writes
  std::unique_ptr<scene::Runner> runner_;
  std::optional<scene::Records> records_; ///< of a session without a scene
  std::int64_t cycle_ = 0;                ///< executed last, and its time
  double time_ = 0.0;
  commit::HeldSteps held_;
  const commit::HeldStep* shown_ = nullptr; ///< null: the live one
  std::string hold_failure_;                ///< the last one logged
  std::string default_failure_; ///< the last one logged
  std::string plan_;            ///< the last one
  bool keeps_answers_ = false;
};

} // namespace insitu::api
