/// insitu-replay: runs a scene over mesh files as if they were the steps of a simulation.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <unistd.h>
#include <vtkDataObject.h>

#include "insitu/insitu.hpp"

#include "catalyst/run.h"
#include "check.h"
#include "dumps.h"
#include "options.h"
#include "parts.h"
#include "read.h"
#include "records/meshes.h"
#include "runs/runs_of_others.h"
#include "steps.h"
#include "vtk_mesh.h"

namespace insitu_replay {

namespace {

enum ExitCode { done = 0, failed = 1, wrong_usage = 2, skipped = 3 };

/// One line on the terminal that goes on; nothing in a pipe or a file.
class Progress {
public:
  void show(const std::string& line) {
    if (!terminal_)
      return;
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
    std::fflush(stderr);
    open_ = true;
  }
  /// Before anything else is printed.
  void clear() {
    if (open_)
      std::fprintf(stderr, "\r\033[K");
    open_ = false;
  }
  bool terminal() const { return terminal_; }

private:
  bool terminal_ = isatty(STDERR_FILENO) == 1;
  bool open_ = false;
};

/// What the session logged last as an error: an exception that says the same is not printed again.
std::string& last_error() {
  static std::string text;
  return text;
}

/// A scene that samples all fields at the points of a file.
std::string probe_scene(const std::string& points) {
  std::string path;
  for (const char c : std::filesystem::absolute(points).string())
    path += c == '\'' ? "''" : std::string(1, c);
  return "insitu: 1\nprobes:\n  - {name: probe, points: '" + path + "'}\n";
}

class Replay {
public:
  explicit Replay(const ReplayOptions& options)
      : options_(options), steps_(ordered(steps_of(options.files))), first_(first_record()),
        session_(session_options()) {
    if (first_)
      return; // records name their meshes
    mesh_ = session_.mesh(options.mesh);
    mesh_.frame(options.has_frame ? options.frame : frame_of_files());
    mesh_.separate_pieces(options.separate_pieces);
  }

  ExitCode run() {
    if (!first_ && numbers_run_backwards(options_.files))
      say("note: the numbers in the files' names do not ascend; steps are taken in the order "
          "given");
    ExitCode code = done;
    if (options_.hold > 0)
      session_.hold(options_.hold);
    const std::vector<std::size_t> places = places_of(options_, steps_.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      const std::size_t s = places[i];
      progress_.show("[" + std::to_string(i + 1) + "/" + std::to_string(places.size()) + "] " +
                     steps_[s].files.front());
      const auto before = given_.find(s);
      if (before == given_.end())
        read_step(s);
      if (options_.validate) {
        if (!validate(s))
          code = failed;
        continue;
      }
      try {
        if (options_.plan) {
          std::cout << session_.plan();
          break;
        }
        if (options_.check)
          return check();
        if (!(before == given_.end() ? execute(s) : execute_again(s, before->second)))
          code = skipped; // the log has said what and why
      } catch (const insitu::Error& e) {
        throw FileError(steps_[s].files.front(), e.what());
      }
    }
    progress_.clear();
    if (!options_.summary.empty())
      session_.write_summary(options_.summary);
    const insitu::Report r = session_.report();
    session_.close();
    if (progress_.terminal() && !options_.validate && !options_.plan)
      say(plural(std::int64_t(places.size()), "step") + ": " + plural(r.rebuilds, "rebuild") +
          ", " + plural(r.refits, "refit") + ", " + plural(r.keeps, "keep") + "; " +
          plural(r.probe_rows, "probe row") + ", " + plural(r.frames, "frame"));
    return code;
  }

private:
  /// What a step was executed as.
  struct Given {
    std::int64_t cycle;
    double time;
  };

  /// The step that was read last.
  bool execute(std::size_t s) {
    given_[s] = {cycle_, time_};
    return session_.execute(cycle_, time_);
  }

  /// A step that was executed before, from what is held of it.
  bool execute_again(std::size_t s, const Given& step) {
    session_.show(step.cycle);
    const std::int64_t cycle = unused_cycle(steps_[s].files.front(), step.cycle, 0);
    const bool well = session_.execute(cycle, step.time);
    session_.show_live();
    return well;
  }

  /// What files of other programs say, or the option's default.
  insitu::Frame frame_of_files() const {
    const Step& first = steps_.front();
    return first.is_of_run ? frame_of_run(first.files.front()).value_or(options_.frame)
                           : options_.frame;
  }

  /// Records tell their times, and go by these, then by their names, however they were given.
  static std::vector<Step> ordered(std::vector<Step> steps) {
    for (Step& step : steps)
      if (!step.time && !step.is_of_run && is_record(step.files.front()))
        step.time = read_record(*open_record(step.files.front())).time;
    if (!steps.front().time || !is_record(steps.front().files.front()))
      return steps;
    std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) {
      return a.time != b.time ? a.time < b.time : a.files < b.files;
    });
    return steps;
  }

  /// Of steps that are records, what the first one says besides its arrays.
  std::optional<Record> first_record() const {
    const std::string& first = steps_.front().files.front();
    if (!is_record(first))
      return std::nullopt;
    if (options_.mesh != ReplayOptions().mesh || options_.separate_pieces ||
        !options_.blanks.empty() || options_.has_frame)
      throw UsageError("records hold the meshes' names, frames, pieces and blank values: give no "
                       "--mesh, --frame, --pieces and --blank");
    return read_record(*open_record(first));
  }

  /// The recorded scene: in its place, where points' files beside it are found, if it is still
  /// there.
  void choose_recorded_scene(insitu::Options& o) const {
    if (!first_->scene_text.empty() && text_of(first_->scene_file) == first_->scene_text)
      o.scene = first_->scene_file;
    else
      o.scene_text = first_->scene_text;
  }

  insitu::Options session_options() {
    insitu::Options o;
    o.scene = options_.scene;
    if (!options_.probe.empty())
      o.scene_text = probe_scene(options_.probe);
    else if (first_ && o.scene.empty())
      choose_recorded_scene(o);
    o.default_scene = o.scene.empty() && o.scene_text.empty() && !options_.validate;
    o.output = options_.out;
    o.threads = options_.threads;
    o.strict = options_.strict;
    o.preview = options_.preview;
    o.log = [this](insitu::LogLevel level, const char* message) {
      say((level == insitu::LogLevel::error ? "" : "note: ") + std::string(message));
      if (level == insitu::LogLevel::error)
        last_error() = message;
    };
    return o;
  }

  void say(const std::string& message) {
    progress_.clear();
    std::fprintf(stderr, "insitu-replay: %s\n", message.c_str());
  }

  /// Gives the files of a step to the mesh.
  void read_step(std::size_t s) {
    const Step& step = steps_[s];
    const std::string& first = step.files.front();
    const bool is_first = cycles_.empty();
    const double earlier = time_; // of the step read before
    if (first_)
      give_record(step);
    else
      give_files(step, std::int64_t(s));
    if (!is_first && (options_.reverse ? time_ > earlier : time_ < earlier))
      throw FileError(first, "time " + std::to_string(time_) + " follows " +
                                 std::to_string(earlier) + "; give the files in the order of time");
  }

  void give_record(const Step& step) {
    const Record record = records_.give(session_, step.files.front());
    cycle_ = unused_cycle(step.files.front(), record.cycle, 0);
    time_ = record.time;
  }

  void give_files(const Step& step, std::int64_t s) {
    const std::string& first = step.files.front();
    std::vector<Part> parts;
    for (const std::string& file : step.files)
      for (Part& part : read_parts(file, step))
        parts.push_back(std::move(part));
    if (step.is_of_run)
      for (const std::string& note : notes_of_run(first))
        say_once(note);
    if (!parts.empty()) {
      drop_surfaces(parts, [this](const std::string& what) { say_once(what); });
      // Steps of one file are told apart by their places, whatever its field data says.
      cycle_ = unused_cycle(first, step.is_of_run ? std::nullopt : cycle_of(parts[0].data), s);
      time_ = step.time ? *step.time : time_of(parts[0].data).value_or(double(cycle_));
    }
    vtk_mesh_.give(mesh_, parts, first, most_parts());
  }

  /// What the file says, or its place in the order; but if a step had that number before (exporters
  /// that do not know it write 0), the steps are counted on from there, as files are named by it.
  std::int64_t unused_cycle(const std::string& file, std::optional<std::int64_t> said,
                            std::int64_t place) {
    std::int64_t cycle = said.value_or(place);
    if (!counts_ && cycles_.count(cycle)) {
      counts_ = true;
      say("note: " + file + ": cycle " + std::to_string(cycle) +
          " was there before; from here on steps are counted on");
    }
    if (counts_)
      cycle = *cycles_.rbegin() + 1;
    cycles_.insert(cycle);
    return cycle;
  }

  std::size_t most_parts() const {
    std::size_t most = 0;
    for (const Step& step : steps_)
      most = std::max(most, step.files.size());
    return most;
  }

  void say_once(const std::string& what) { say_once(what, what); }
  void say_once(const std::string& what, const std::string& key) {
    if (said_.insert(key).second)
      say("note: " + what);
  }

  /// The meshes of the step that was read last.
  NamedMeshes meshes() const {
    return first_ ? records_.meshes() : NamedMeshes{{options_.mesh, mesh_}};
  }

  /// Says what a run would do; writes nothing.
  ExitCode check() {
    const std::vector<std::string> problems =
        check_run(session_, meshes(), steps_.size(), scene_text(), options_.out);
    for (const std::string& problem : problems)
      say(problem);
    return problems.empty() ? done : skipped;
  }

  std::string scene_text() const {
    if (!options_.probe.empty())
      return probe_scene(options_.probe);
    if (options_.scene.empty())
      return first_ ? first_->scene_text : std::string();
    return text_of(options_.scene);
  }

  bool validate(std::size_t s) {
    progress_.clear();
    return validate_meshes(meshes(), steps_[s].files.front());
  }

  const ReplayOptions& options_;
  std::vector<Step> steps_;
  Progress progress_;
  // The session reads the arrays that these hold, and is closed before they go.
  VtkMesh vtk_mesh_{
      options_, [this](const std::string& what, const std::string& key) { say_once(what, key); }};
  std::optional<Record> first_; ///< of records, the first
  RecordedMeshes records_;
  insitu::Session session_;
  insitu::Mesh mesh_;
  std::int64_t cycle_ = 0;
  double time_ = 0;
  std::set<std::int64_t> cycles_; ///< of the steps so far
  bool counts_ = false;           ///< steps are counted on, whatever the files say
  std::map<std::size_t, Given> given_; ///< by place
  std::set<std::string> said_;    ///< what is said once
};

int run(int argc, char** argv) {
  try {
    const ReplayOptions options = parse_arguments(argc, argv);
    if (options.help) {
      std::cout << help_text;
      return done;
    }
    if (options.version) {
      const auto v = insitu::version();
      std::cout << "insitu-replay " << v[0] << '.' << v[1] << '.' << v[2] << "\n";
      return done;
    }
    if (are_dumps(options.files))
      return replay_dumps(options) ? done : options.validate ? failed : skipped;
    silence_vtk();
    return Replay(options).run();
  } catch (const insitu::catalyst::Logged&) {
    return failed;
  } catch (const UsageError& e) {
    std::fprintf(stderr, "insitu-replay: %s\nTry insitu-replay --help.\n", e.what());
    return wrong_usage;
  } catch (const std::exception& e) {
    if (isatty(STDERR_FILENO) == 1)
      std::fprintf(stderr, "\r\033[K");
    if ("insitu_session_open: " + std::string(e.what()) != last_error())
      std::fprintf(stderr, "insitu-replay: %s\n", e.what());
    return failed;
  }
}

} // namespace

} // namespace insitu_replay

int main(int argc, char** argv) {
  return insitu_replay::run(argc, argv);
}
