// clang-format off
/** @file insitu.hpp
 *  libinsitu for C++17 and later is a header-only layer over insitu.h that owns the handles, knows
 *  the types and throws insitu::Error. The rules of insitu.h hold: arrays are external and read in
 *  place, work happens in commits alone, and one thread at a time uses a session.
 *
 *      insitu::Session session({.scene = "scene.yaml"});          // C++17: set the members one by one
 *      insitu::Mesh mesh = session.mesh("hydro");
 *      mesh.points(x.data(), y.data(), z.data(), vertex_count);   // once; again when they move elsewhere
 *      mesh.hexahedra(connectivity.data(), cell_count);
 *      mesh.cell_field("density", rho.data());
 *      mesh.vertex_field("velocity", {vx.data(), vy.data(), vz.data()});
 *      while (time < end) {
 *        advance(dt);
 *        mesh.changed(insitu::geometry | insitu::fields);
 *        session.execute(cycle, time);
 *      }
 *      auto pressure = mesh.sample("pressure", points);           // any time after a commit */
// clang-format on
#ifndef INSITU_INSITU_HPP
#define INSITU_INSITU_HPP

#include <functional>
#include <map>

#include "insitu/array.hpp"
#include "insitu/mesh.hpp"
#include "insitu/types.hpp"

namespace insitu {

enum class LogLevel {
  error = INSITU_LOG_ERROR,
  warning = INSITU_LOG_WARNING,
  info = INSITU_LOG_INFO,
  debug = INSITU_LOG_DEBUG
};

/** Receives messages, on the thread that called the library. The function must not call the
 *  library; the layer drops what it throws. */
using Log = std::function<void(LogLevel level, const char* message)>;

using Report = insitu_report;

struct Options {
  std::string scene = {};      /**< path of a scene file; empty: no file */
  std::string scene_text = {}; /**< the scene itself, as text; a session takes one of scene and
                                    scene_text at most */
  std::string output = {};     /**< output folder, which overrides the scene's; empty: the
                                    scene's */
  bool default_scene = false;  /**< a session without a scene draws the first scalar field every
                                    tenth cycle */
  int threads = 0;             /**< the most threads that the session runs; 0: all that the
                                    process's affinity allows, of several processes its share
                                    of the node's cores */
  bool strict = false;         /**< commits refuse arrays that would have to be copied or
                                    converted */
  LogLevel log_level = LogLevel::warning; /**< messages up to this level reach the log */
  Log log = {};                           /**< empty: errors and warnings go to stderr */
  const void* communicator = nullptr;     /**< address of an MPI_Comm, with which opening,
                                               executing, closing and more are collective: see
                                               insitu_session_options */
  /** The communicator as a Fortran integer, if communicator is null. */
  int fortran_communicator = INSITU_NO_COMMUNICATOR;
  bool preview = false; /**< each execute draws every frame of the scene, small, into the folder
                             `preview` of the output folder, and does nothing else of the scene: see
                             insitu_session_options */
};

/** Returns the version of the library that is running: major, minor, patch. */
inline std::array<int, 3> version() {
  std::array<int, 3> v{};
  detail::check(insitu_version(&v[0], &v[1], &v[2]));
  return v;
}

/** A session owns meshes and what the scene makes of them. A Session can be moved, but not
 *  copied. */
class Session {
public:
  /** Opens a session. Throws INSITU_ERROR_SCENE for a bad scene, whose what() gives file, line, key
   *  and the nearest valid key, and INSITU_ERROR_FILE if another session writes the same files. */
  explicit Session(const Options& options = {}) {
    insitu_session_options o = insitu_session_options_default();
    o.scene = or_null(options.scene);
    o.scene_text = or_null(options.scene_text);
    o.output = or_null(options.output);
    o.default_scene = options.default_scene ? 1 : 0;
    o.threads = options.threads;
    try {
      log_ = std::make_unique<Log>(options.log);
    } catch (const std::bad_alloc&) { // other processes may wait for this one
      o.threads = INSITU_LACKS_MEMORY;
    }
    o.strict = options.strict ? 1 : 0;
    o.log_level = static_cast<insitu_log_level>(options.log_level);
    if (log_ && *log_) {
      o.log = &forward;
      o.log_user = log_.get();
    }
    o.communicator = options.communicator;
    o.fortran_communicator = options.fortran_communicator;
    o.preview = options.preview ? 1 : 0;
    detail::check(insitu_session_open(&o, &session_));
  }
  /** Closes the session; a failure then reaches the log. */
  ~Session() {
    if (session_)
      (void)insitu_session_close(&session_);
  }
  Session(Session&& other) noexcept
      : log_(std::move(other.log_)), session_(std::exchange(other.session_, nullptr)),
        meshes_(std::move(other.meshes_)) {}
  Session& operator=(Session&& other) noexcept {
    std::swap(log_, other.log_);
    std::swap(session_, other.session_);
    std::swap(meshes_, other.meshes_);
    return *this;
  }

  /** Returns the mesh of that name, which the first call makes, empty. The mesh lives as long as
   *  the session. */
  Mesh mesh(const std::string& name) {
    std::shared_ptr<detail::MeshState>& state = meshes_[name];
    if (!state) {
      auto fresh = std::make_shared<detail::MeshState>();
      detail::check(insitu_session_mesh(session_, name.c_str(), &fresh->handle));
      state = std::move(fresh);
    }
    return Mesh(state);
  }

  /** Commits every mesh, then runs the probes, tracers and frames that the scene asks for at this
   *  cycle. time: the solver's, which must not decrease while tracers live (see
   *  insitu_session_execute()). Returns false if a probe, tracer or frame failed: the library
   *  logged and skipped it and ran all others, and the solver can go on; insitu_last_message()
   *  tells which one failed. Throws Error for any other failure, such as a mesh that was
   *  refused. */
  bool execute(std::int64_t cycle, double time) {
    const insitu_status status = insitu_session_execute(session_, cycle, time);
    if (status != INSITU_ERROR_ACTION)
      detail::check(status);
    return status == INSITU_OK;
  }

  /** Writes the state of the scene's tracers after the last execute to a file; see
   *  insitu_session_checkpoint(). */
  void checkpoint(const std::string& path) {
    detail::check(insitu_session_checkpoint(session_, path.c_str()));
  }
  /** Takes up a checkpoint's file before the first execute; see insitu_session_restart(). */
  void restart(const std::string& path) {
    detail::check(insitu_session_restart(session_, path.c_str()));
  }

  /** Writes what the last execute committed to a VTKHDF file; see insitu_session_record(). */
  void record(const std::string& path) {
    detail::check(insitu_session_record(session_, path.c_str()));
  }

  /** Holds the last `steps` executed steps from now on, with copies of their arrays and their
   *  trees; 0: none. See insitu_session_hold(). */
  void hold(int steps) { detail::check(insitu_session_hold(session_, steps)); }
  /** Returns the cycles that are held, the oldest first. */
  std::vector<std::int64_t> held() const {
    std::int32_t count = 0;
    detail::check(insitu_session_held(session_, nullptr, &count));
    std::vector<std::int64_t> cycles(static_cast<std::size_t>(count));
    detail::check(insitu_session_held(session_, cycles.data(), &count));
    return cycles;
  }
  /** Has queries, records and executes answer from a held step, until the next call; see
   *  insitu_session_show(). */
  void show(std::int64_t cycle) { detail::check(insitu_session_show(session_, cycle)); }
  /** Shows the live step again. */
  void show_live() { show(INSITU_LIVE); }

  /** From the next execute on all processes keep what the scene's probes answer, or none does any
   *  more; see insitu_session_keep_answers(). */
  void keep_answers(bool keep = true) {
    detail::check(insitu_session_keep_answers(session_, keep ? 1 : 0));
  }
  /** Returns what each probe of the scene answered last, in the scene's order; see
   *  insitu_session_answers(). The pointers are valid until the next execute. */
  std::vector<ProbeAnswers> answers() const {
    std::int32_t count = 0;
    detail::check(insitu_session_answers(session_, 0, nullptr, &count));
    std::vector<ProbeAnswers> all(static_cast<std::size_t>(count), insitu_probe_answers_default());
    for (std::int32_t i = 0; i < count; ++i)
      detail::check(insitu_session_answers(session_, i, &all[static_cast<std::size_t>(i)], &count));
    return all;
  }

  /** Returns totals since the session was opened. */
  Report report() const {
    Report r = insitu_report_default();
    detail::check(insitu_session_report(session_, &r));
    return r;
  }
  /** Returns a text that tells what the scene needs of the meshes, and what it does without; see
   *  insitu_session_plan(). */
  std::string plan() {
    const char* text = nullptr;
    detail::check(insitu_session_plan(session_, &text));
    return text;
  }
  /** Writes the report to a file, as JSON. solver_s: the solver's own seconds, from which the
   *  library's share of the run follows; negative: the share is left out. */
  void write_summary(const std::string& path, double solver_s = -1.0) const {
    detail::check(insitu_session_write_summary(session_, path.c_str(), solver_s));
  }

  /** Ends tracers, closes files and releases the meshes. The destructor does the same, but cannot
   *  throw. */
  void close() { detail::check(insitu_session_close(&session_)); }

  /** Returns the handle for calls of insitu.h; it belongs to this Session. */
  insitu_session handle() const noexcept { return session_; }

private:
  static const char* or_null(const std::string& s) noexcept {
    return s.empty() ? nullptr : s.c_str();
  }
  static void forward(insitu_log_level level, const char* message, void* user) {
    try {
      (*static_cast<const Log*>(user))(static_cast<LogLevel>(level), message);
    } catch (...) { // no exception may pass through the library
    }
  }

  std::unique_ptr<Log> log_; ///< the library keeps the address of this function
  insitu_session session_ = nullptr;
  std::map<std::string, std::shared_ptr<detail::MeshState>> meshes_;
};

} // namespace insitu

#endif // INSITU_INSITU_HPP
