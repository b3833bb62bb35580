/// Checkpoints of a runner, and restarts.
#include "output/files/checkpoint.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "scene/checkpoint/checkpoint_files.h"
#include "scene/checkpoint/shared_reader.h"
#include "scene/run/runner.h"

namespace insitu::scene {

namespace {

constexpr std::size_t most_part_bytes = std::size_t(1) << 24; ///< of a part, on its way at a time

/// The mesh of an action; null if there is none.
const commit::CommittedMesh* mesh_of(const Action& action, MeshList meshes) {
  for (const commit::CommittedMesh* mesh : meshes)
    if (action.is_of(*mesh, meshes))
      return mesh;
  return nullptr;
}

/// Whether a mesh lies in device memory on some process: nothing is kept of it. Collective.
bool lies_on_device(const commit::CommittedMesh& mesh, parallel::World& world) {
  std::int64_t any = mesh.lies_on_device();
  world.reduce(std::span(&any, 1), parallel::Reduction::greatest);
  return any != 0;
}

std::string listed(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& name : list)
    text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? std::string("nothing that moves") : text;
}

} // namespace

/// What all processes have alike, but for the meshes.
void Runner::keep(core::Archive& archive, const std::string& path) {
  archive.value("cycle", cycle_);
  archive.array("times", times_);
  std::vector<std::string> names;
  for (const auto& action : actions_)
    if (std::string name = action->state_name(); !name.empty())
      names.push_back(std::move(name));
  std::vector<std::string> found = names;
  archive.array("tracers", found);
  if (archive.restores())
    environment_.world.agree_after([&] {
      if (found != names)
        throw core::Error(INSITU_ERROR_FILE,
                          "cannot restart from '" + path + "': it is of another scene: it has " +
                              listed(found) + "; the scene has " + listed(names));
    });
  for (const auto& action : actions_)
    action->keep(archive);
}

void Runner::write_checkpoint(const std::string& path, MeshList meshes) {
  parallel::World& world = environment_.world;
  world.agree_after([&] {
    if (!executed_)
      throw core::Error(INSITU_ERROR_ORDER,
                        "checkpoint '" + path + "': nothing was executed yet in this session");
  });
  for (const auto& action : actions_)
    action->meet_checkpoint(mesh_of(*action, meshes));
  std::optional<output::CheckpointWriter> file; // at the root
  std::int64_t count = 0;
  std::vector<std::uint8_t> is_kept;
  for (const commit::CommittedMesh* mesh : meshes) {
    is_kept.push_back(!lies_on_device(*mesh, world));
    count += is_kept.back();
  }
  world.agree_after([&] {
    if (!world.is_root())
      return;
    file.emplace(path);
    keep(*file, path);
    for (const auto& action : actions_)
      action->keep_at_root(*file);
    file->value("meshes", count);
  });
  for (std::size_t m = 0; m < meshes.size(); ++m)
    if (is_kept[m])
      write_mesh(*meshes[m], file ? &*file : nullptr);
  world.agree_after([&] {
    if (!file)
      return;
    file->commit();
    ++environment_.statistics.files;
  });
}

/// A part of each process after the other. file: at the root.
void Runner::write_mesh(const commit::CommittedMesh& mesh, output::CheckpointWriter* file) {
  parallel::World& world = environment_.world;
  output::PartWriter part;
  world.agree_after([&] {
    KeptPart(mesh, environment_.context.memory, environment_.context.threads).keep(part);
    std::string name = mesh.mesh().name();
    int processes = world.size();
    if (file) {
      file->value("mesh", name);
      file->value("processes", processes);
    }
  });
  for (int rank = 0; rank < world.size(); ++rank) {
    const std::string& text = part.text();
    const auto mine = std::as_bytes(std::span(text)).first(rank == world.rank() ? text.size() : 0);
    std::int64_t bytes = std::int64_t(mine.size());
    world.reduce(std::span(&bytes, 1), parallel::Reduction::greatest);
    world.agree_after([&] {
      if (file)
        file->begin_item("part", 1, std::size_t(bytes));
    });
    world.gather(mine, most_part_bytes, [&](int, std::span<const std::byte> some) {
      file->append({reinterpret_cast<const char*>(some.data()), some.size()});
    });
  }
}

void Runner::restart(const std::string& path) {
  parallel::World& world = environment_.world;
  std::optional<output::CheckpointReader> file; // at the root
  world.agree_after([&] {
    if (world.is_root())
      file.emplace(path);
  });
  SharedReader shared(world, file ? &*file : nullptr);
  keep(shared, path);
  std::int64_t count = 0;
  world.agree_after([&] {
    if (!file)
      return;
    for (const auto& action : actions_)
      action->keep_at_root(*file);
    file->value("meshes", count);
  });
  world.broadcast(std::as_writable_bytes(std::span(&count, 1)));
  for (std::int64_t i = 0; i < count; ++i)
    read_mesh(shared, file ? &*file : nullptr, path);
  world.agree_after([&] {
    if (file)
      file->require_end();
  });
  executed_ = true;
  lowest_cycle_ = highest_cycle_ = cycle_;
}

/// The parts go to as many processes as wrote them, or are dealt in their order. file: at the root.
void Runner::read_mesh(core::Archive& shared, output::CheckpointReader* file,
                       const std::string& path) {
  parallel::World& world = environment_.world;
  KeptMesh& mesh = kept_meshes_.emplace_back();
  shared.value("mesh", mesh.name);
  shared.value("processes", mesh.processes);
  world.agree_after([&] {
    if (file && mesh.processes < 1)
      file->refuse("mesh '" + mesh.name + "' is of " + std::to_string(mesh.processes) +
                   " processes");
  });
  for (int from = 0; from < mesh.processes; ++from) {
    const auto to = int(std::int64_t(from) * world.size() / mesh.processes);
    std::vector<parallel::Parcel> parcels;
    world.agree_after([&] {
      if (!file)
        return;
      parallel::Parcel& parcel = parcels.emplace_back(parallel::Parcel{to, {}});
      file->array("part", parcel.bytes);
    });
    const std::vector<parallel::Parcel> received = world.exchange(parcels);
    world.agree_after([&] {
      for (const parallel::Parcel& parcel : received) {
        output::PartReader reader(path, parcel.bytes);
        KeptMesh::Part& part =
            mesh.parts.emplace_back(KeptMesh::Part{from, KeptPart(environment_.context.memory)});
        part.kept.keep(reader);
        reader.require_end();
      }
    });
  }
}

/// Before the first execution after a restart. Collective.
void Runner::take_up_meshes(MeshList meshes) {
  parallel::World& world = environment_.world;
  for (KeptMesh& kept : kept_meshes_)
    for (commit::CommittedMesh* mesh : meshes) {
      if (mesh->mesh().name() != kept.name || lies_on_device(*mesh, world))
        continue;
      const KeptCells::By by = kept.restore(*mesh, world, environment_.context.memory,
                                            environment_.context.threads, environment_.context.log);
      world.agree_after([&] {
        const auto cells = std::make_shared<const KeptCells>(by, *mesh, world.rank());
        for (const auto& action : actions_)
          if (action->is_of(*mesh, meshes))
            action->take_up_cells(cells);
      });
    }
  kept_meshes_.clear();
}

void Runner::write_due_checkpoint(MeshList meshes) {
  if (!checkpoint_.every || cycle_ % *checkpoint_.every != 0)
    return;
  write_checkpoint(checkpoint_path(environment_.output, cycle_), meshes);
  environment_.world.agree_after([&] {
    if (environment_.world.is_root())
      remove_old_checkpoints(environment_.output, cycle_, checkpoint_.keep, descends_);
  });
}

} // namespace insitu::scene
