#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <mutex>
#include <string>
#include <unistd.h>

#include "api/session.h"
#include "fixtures/parts.h"
#include "unit/parallel/threaded_world.h"

/// Sessions of solvers whose mesh is cut into parts, with processes as threads.
namespace insitu::test {

/// Fields of a whole mesh at a cycle: one at vertices, a vector there, one of cells.
struct WholeFields {
  std::vector<double> p, u, c;

  WholeFields(const TestMesh& whole, std::int64_t cycle) {
    const double t = 0.37 * double(cycle);
    for (const Vec3d& x : whole.vertices) {
      p.push_back(std::sin(3 * x.x + t) + x.y * x.z);
      u.insert(u.end(), {-x.y, x.x, 0.1 * std::cos(t)});
    }
    for (std::size_t i = 0; i < whole.cells.size(); ++i)
      c.push_back(std::cos(0.1 * double(i) + t));
  }
};

/// One process of a solver: its part of the mesh 'm', and a session.
class PartSession {
public:
  struct Options {
    std::string scene, folder;
    bool ids = true; ///< whether the solver gives global ids
    bool scene_is_file = false;
    insitu_frame frame = insitu_frame_default(); ///< of the mesh
  };
  PartSession(parallel::World& world, const TestMesh& whole, const fixtures::Partition& partition,
              const Options& options)
      : whole_(&whole), ids_(options.ids), frame_(options.frame),
        part_(std::in_place, whole, partition, world.rank()),
        session_(options_of(options), std::shared_ptr<parallel::World>(&world, [](auto*) {})) {
    session_.open(options_of(options));
    give();
  }

  api::Session& session() { return session_; }
  fixtures::Part& part() { return *part_; }
  commit::CommittedMesh& mesh() { return session_.mesh("m").mesh; }
  const std::vector<std::string>& messages() const { return messages_; }

  /// The solver deals its cells anew, or those of another mesh.
  void deal(const fixtures::Partition& partition, int rank, const TestMesh* whole = nullptr) {
    mesh().mesh().drop_pieces(0);
    if (whole)
      whole_ = whole;
    part_.emplace(*whole_, partition, rank);
    give();
  }
  void give_fields(std::int64_t cycle) {
    if (part_->empty())
      return;
    const WholeFields fields(*whole_, cycle);
    mesh::Mesh& to = mesh().mesh();
    part_->give_field(to, "p", INSITU_VERTEX, 1, fields.p);
    part_->give_field(to, "u", INSITU_VERTEX, 3, fields.u);
    part_->give_field(to, "c", INSITU_CELL, 1, fields.c);
  }
  std::string execute(std::int64_t cycle) {
    give_fields(cycle);
    return session_.execute(cycle, 0.25 * double(cycle));
  }

private:
  insitu_session_options options_of(const Options& options) {
    insitu_session_options o = insitu_session_options_default();
    (options.scene_is_file ? o.scene : o.scene_text) = options.scene.c_str();
    o.output = options.folder.c_str();
    o.threads = 1;
    o.log = [](insitu_log_level, const char* message, void* user) {
      static_cast<PartSession*>(user)->messages_.push_back(message);
    };
    o.log_user = this;
    return o;
  }
  void give() {
    if (part_->empty())
      return;
    part_->give(mesh().mesh(), ids_);
    mesh().reference_frame = frame_;
  }

  const TestMesh* whole_;
  const bool ids_;
  const insitu_frame frame_;
  std::vector<std::string> messages_;
  std::optional<fixtures::Part> part_;
  api::Session session_;
};

/// One more mesh of a process's session, cut into parts of its own. A process without cells of it
/// lacks it.
class FurtherMesh {
public:
  FurtherMesh(PartSession& process, std::string name, const TestMesh& whole,
              const fixtures::Partition& partition, int rank,
              const insitu_frame& frame = insitu_frame_default())
      : process_(&process), name_(std::move(name)), whole_(&whole), part_(whole, partition, rank) {
    if (part_.empty())
      return;
    part_.give(mesh().mesh(), true);
    mesh().reference_frame = frame;
  }
  void give_fields(std::int64_t cycle) {
    if (part_.empty())
      return;
    const WholeFields fields(*whole_, cycle);
    part_.give_field(mesh().mesh(), "p", INSITU_VERTEX, 1, fields.p);
    part_.give_field(mesh().mesh(), "c", INSITU_CELL, 1, fields.c);
  }

private:
  commit::CommittedMesh& mesh() { return process_->session().mesh(name_.c_str()).mesh; }

  PartSession* process_;
  std::string name_;
  const TestMesh* whole_;
  fixtures::Part part_;
};

/// A session of one process: opened, given to act(session), and closed. Warnings are failures.
template <class Act>
void with_session(parallel::World& world, const char* scene, const std::string& out, Act&& act) {
  insitu_session_options o = insitu_session_options_default();
  o.scene_text = scene;
  o.output = out.c_str();
  o.threads = 1;
  o.log = [](insitu_log_level level, const char* message, void*) {
    if (level <= INSITU_LOG_WARNING)
      ADD_FAILURE() << message;
  };
  api::Session session(o, std::shared_ptr<parallel::World>(&world, [](auto*) {}));
  session.open(o);
  act(session);
  EXPECT_EQ(session.finish(), "");
}

/// A folder of a test's own, which goes with it.
class OwnFolder {
public:
  OwnFolder() {
    static std::atomic<int> number{0};
    path_ = std::filesystem::temp_directory_path() /
            ("insitu-processes-" + std::to_string(::getpid()) + "-" + std::to_string(number++));
    std::filesystem::create_directories(path_);
  }
  ~OwnFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

private:
  std::filesystem::path path_;
};

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The files of a folder and what they hold, without the page, whose seconds differ.
inline std::map<std::string, std::string> files_of(const std::string& folder) {
  std::map<std::string, std::string> files;
  if (std::filesystem::exists(folder))
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      const std::string name = std::filesystem::relative(entry.path(), folder).string();
      if (entry.is_regular_file() && name != "run.js" && name != "index.html" &&
          name.find("lock") == std::string::npos)
        files[name] = read_file(entry.path());
    }
  return files;
}

/// Runs a solver of several processes, and returns the files that it left.
using Act = std::function<void(PartSession&, parallel::World&)>;
inline std::map<std::string, std::string> run_parts(const TestMesh& whole,
                                                    const fixtures::Partition& partition,
                                                    PartSession::Options options, const Act& act) {
  const OwnFolder folder;
  options.folder = folder / "out";
  run_processes(partition.processes, [&](parallel::World& world) {
    PartSession process(world, whole, partition, options);
    act(process, world);
    EXPECT_EQ(process.session().finish(), "");
  });
  return files_of(options.folder);
}

inline void expect_same(const std::map<std::string, std::string>& expected,
                        const std::map<std::string, std::string>& found, const std::string& what) {
  for (const auto& [name, text] : expected) {
    const auto at = found.find(name);
    if (at == found.end())
      ADD_FAILURE() << what << ": no file " << name;
    else if (at->second != text) {
      const auto first = std::size_t(std::ranges::mismatch(text, at->second).in1 - text.begin());
      const std::size_t from = first - std::min<std::size_t>(first, 300);
      ADD_FAILURE() << what << ": " << name << " differs from byte " << first << " on:\n"
                    << text.substr(from, 900) << "\n-----\n"
                    << at->second.substr(from, 900);
    }
  }
  for (const auto& [name, text] : found)
    EXPECT_TRUE(expected.contains(name)) << what << ": a file " << name;
}

/// What a call of all processes throws: the same everywhere.
template <class Call>
std::string failure_of(Call&& call) {
  try {
    call();
  } catch (const core::Error& e) {
    return e.what();
  }
  return {};
}

inline TestMesh jittered_cubes(int size = 5) {
  MeshOptions options;
  options.size = size;
  options.jitter = 0.15;
  return make_mesh(options, 11);
}

} // namespace insitu::test
