#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "part_session.h"
#include "unit/parallel/amr_part.h"

/// Sessions of solvers of adaptive meshes, with processes as threads.
namespace insitu::test {

/// One process of a solver with leaves or patches.
class AmrSession {
public:
  AmrSession(parallel::World& world, const AmrMesh& whole, insitu_reconstruction how,
             const Deal& deal, const std::string& scene, const std::string& folder,
             bool has_mesh = true)
      : session_(options_of(scene, folder, this),
                 std::shared_ptr<parallel::World>(&world, [](auto*) {})) {
    session_.open(options_of(scene, folder, this));
    if (has_mesh)
      give(world, whole, how, deal);
  }
  /// The mesh, or another one.
  void give(parallel::World& world, const AmrMesh& whole, insitu_reconstruction how,
            const Deal& deal) {
    give(AmrPart(whole, how, deal, world.rank()));
  }
  void give(AmrPart part) {
    part_.emplace(std::move(part));
    part_->give(session_.mesh("m").mesh.mesh());
  }
  api::Session& session() { return session_; }
  const std::vector<std::string>& messages() const { return messages_; }
  std::string execute(std::int64_t cycle) {
    if (part_)
      part_->give_fields(session_.mesh("m").mesh.mesh(), 1.0 + 0.25 * double(cycle));
    return session_.execute(cycle, 0.25 * double(cycle));
  }

private:
  static insitu_session_options options_of(const std::string& scene, const std::string& folder,
                                           AmrSession* told) {
    insitu_session_options o = insitu_session_options_default();
    o.scene_text = scene.c_str();
    o.output = folder.c_str();
    o.threads = 1;
    o.log = [](insitu_log_level, const char* message, void* user) {
      static_cast<AmrSession*>(user)->messages_.push_back(message);
    };
    o.log_user = told;
    return o;
  }

  std::vector<std::string> messages_;
  std::optional<AmrPart> part_;
  api::Session session_;
};

inline std::map<std::string, std::string> run_amr(const AmrMesh& whole, insitu_reconstruction how,
                                                  int processes, const Deal& deal,
                                                  const std::string& scene, int without_mesh = -1) {
  const OwnFolder folder;
  const std::string out = folder / "out";
  run_processes(processes, [&](parallel::World& world) {
    AmrSession process(world, whole, how, deal, scene, out, world.rank() != without_mesh);
    for (int cycle = 0; cycle < 3; ++cycle)
      EXPECT_EQ(process.execute(cycle), "");
    EXPECT_EQ(process.session().finish(), "");
  });
  return files_of(out);
}

/// Of a domain from 0 to 4 along each axis.
inline Deal deal_of(int kind, int processes) {
  return [=](std::size_t number, const math::Vec3d& x) {
    if (kind == 0) // slabs
      return std::min(processes - 1, int(x.x / 4.0 * processes));
    if (kind == 1) // boxes
      return (int(x.x / 2.0) + 2 * int(x.y / 2.0) + 4 * int(x.z / 2.0)) % processes;
    if (kind == 2 && processes > 1) // none at the root
      return 1 + int(number) % (processes - 1);
    return int(core::random_unit(3, number, 0) * processes);
  };
}

} // namespace insitu::test
