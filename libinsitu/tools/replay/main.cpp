/// insitu-replay: runs a scene over mesh files as if they were the steps of a simulation.

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>
#include <unistd.h>
#include <vtkDataSet.h>

#include "insitu/insitu.hpp"
#include "insitu/vtk.hpp"

#include "options.h"
#include "steps.h"

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

std::string plural(std::int64_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
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
      : options_(options), steps_(steps_of(options.files)), session_(session_options()),
        mesh_(session_.mesh(options.mesh)) {
    mesh_.frame(options.frame);
  }

  ExitCode run() {
    if (numbers_run_backwards(options_.files))
      say("note: the numbers in the files' names do not ascend; steps are taken in the order "
          "given");
    ExitCode code = done;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const std::size_t s = options_.reverse ? steps_.size() - 1 - i : i;
      read_step(s, i);
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
        if (!session_.execute(cycle_, time_))
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
      say(plural(std::int64_t(steps_.size()), "step") + ": " + plural(r.rebuilds, "rebuild") +
          ", " + plural(r.refits, "refit") + ", " + plural(r.keeps, "keep") + "; " +
          plural(r.probe_rows, "probe row") + ", " + plural(r.frames, "frame"));
    return code;
  }

private:
  insitu::Options session_options() {
    insitu::Options o;
    o.scene = options_.scene;
    if (!options_.probe.empty())
      o.scene_text = probe_scene(options_.probe);
    o.default_scene = o.scene.empty() && o.scene_text.empty() && !options_.validate;
    o.output = options_.out;
    o.threads = options_.threads;
    o.strict = options_.strict;
    o.log = [this](insitu::LogLevel level, const char* message) {
      say((level == insitu::LogLevel::error ? "" : "note: ") + std::string(message));
    };
    return o;
  }

  void say(const std::string& message) {
    progress_.clear();
    std::fprintf(stderr, "insitu-replay: %s\n", message.c_str());
  }

  /// Gives the files of a step, the i-th that is read, to the mesh.
  void read_step(std::size_t s, std::size_t i) {
    const Step& step = steps_[s];
    const std::string& first = step.files.front();
    progress_.show("[" + std::to_string(i + 1) + "/" + std::to_string(steps_.size()) + "] " +
                   first);
    if (adaptive_ && step.files.size() > 1)
      throw FileError(first, std::to_string(step.files.size()) +
                                 " parts after an adaptive mesh, which is one file a step");
    if (step.files.size() < pieces_.size())
      throw FileError(first, std::to_string(step.files.size()) + " parts, " +
                                 std::to_string(pieces_.size()) +
                                 " in the step before; parts cannot go");
    const double earlier = time_; // of the step read before
    for (std::size_t p = 0; p < step.files.size(); ++p) {
      const vtkSmartPointer<vtkDataObject> data = read(step.files[p]);
      if (p == 0) {
        cycle_ = cycle_of(data).value_or(std::int64_t(s));
        time_ = step.time ? *step.time : time_of(data).value_or(double(cycle_));
      }
      const std::vector<insitu::vtk::Note>& skipped = give(data, step, p);
      if (i == 0)
        for (const insitu::vtk::Note& n : skipped)
          say("note: " + step.files[p] + ": " + n.array + " is left out: " + n.reason);
    }
    if (i > 0 && (options_.reverse ? time_ > earlier : time_ < earlier))
      throw FileError(first, "time " + std::to_string(time_) + " follows " +
                                 std::to_string(earlier) + "; give the files in the order of time");
  }

  /// Gives part p of a step to the mesh. Returns what of it is left out.
  const std::vector<insitu::vtk::Note>& give(vtkDataObject* data, const Step& step, std::size_t p) {
    const std::string& file = step.files[p];
    vtkDataSet* const part = vtkDataSet::SafeDownCast(data);
    if (part ? adaptive_.has_value() : !pieces_.empty() || step.files.size() > 1)
      throw FileError(file, std::string(part ? "is no adaptive mesh" : "is an adaptive mesh") +
                                "; all steps are adaptive meshes, a file each, or none");
    try {
      if (!part) {
        if (adaptive_)
          adaptive_->update(data);
        else
          adaptive_ = insitu::vtk::attach_adaptive(mesh_, data);
        return adaptive_->skipped();
      }
      if (p < pieces_.size()) {
        pieces_[p].update(part);
      } else {
        insitu::vtk::AttachOptions o;
        o.piece = int(p);
        pieces_.push_back(insitu::vtk::attach(mesh_, part, o));
      }
      return pieces_[p].skipped();
    } catch (const insitu::Error& e) {
      throw FileError(file, e.what());
    }
  }

  bool validate(std::size_t s) {
    const insitu::Validation v = mesh_.validate();
    progress_.clear();
    const insitu_validation& c = v.counts;
    std::cout << steps_[s].files.front() << ": " << (v.accepted ? "accepted" : "refused") << ", "
              << plural(c.cells, "cell") << ", " << c.ghost_cells << " ghost, " << c.inverted_cells
              << " inverted, " << c.zero_volume_cells << " of zero volume, " << c.folded_cells
              << " folded, " << c.collapsed_cells << " collapsed; " << c.coincident_vertices
              << " vertices coincide, " << c.crowded_faces << " faces of more than two cells, "
              << c.split_faces << " quads against other faces, " << c.hanging_vertices
              << " vertices on faces or edges of other cells, " << c.covered_vertices
              << " inside other cells\n";
    if (!v.accepted)
      std::cout << v.findings << "\n";
    return v.accepted;
  }

  const ReplayOptions& options_;
  std::vector<Step> steps_;
  Progress progress_;
  // The session reads the arrays that the pieces hold, and is closed before they go.
  std::vector<insitu::vtk::Attachment> pieces_;
  std::optional<insitu::vtk::AdaptiveAttachment> adaptive_; ///< then no pieces
  insitu::Session session_;
  insitu::Mesh mesh_;
  std::int64_t cycle_ = 0;
  double time_ = 0;
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
    silence_vtk();
    return Replay(options).run();
  } catch (const UsageError& e) {
    std::fprintf(stderr, "insitu-replay: %s\nTry insitu-replay --help.\n", e.what());
    return wrong_usage;
  } catch (const std::exception& e) {
    if (isatty(STDERR_FILENO) == 1)
      std::fprintf(stderr, "\r\033[K");
    std::fprintf(stderr, "insitu-replay: %s\n", e.what());
    return failed;
  }
}

} // namespace

} // namespace insitu_replay

int main(int argc, char** argv) {
  return insitu_replay::run(argc, argv);
}
