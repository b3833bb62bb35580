#include "scene/run/checkpoint.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "output/files/checkpoint.h"
#include "scene/run/runner.h"
#include "scene/run/step.h"

namespace insitu::scene {

namespace {

constexpr std::string_view file_begin = "checkpoint_", file_end = ".insitu";
constexpr std::uint64_t prime = 0x100000001b3u, basis = 0xcbf29ce484222325u;

std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * prime;
  return hash ^ hash >> 32;
}

} // namespace

void KeptMesh::keep(core::Archive& archive, mesh::CellsCopy& cells) {
  archive.value("mesh", name);
  archive.value("cells", fingerprint);
  archive.value("unguided points", unguided);
  step.keep(archive);
  cells.keep(archive);
  bool has_chart = chart.has_value();
  archive.value("has a chart", has_chart);
  if (!has_chart)
    return;
  query::ChartImage image = chart.value_or(query::ChartImage{});
  archive.value("radians", image.units.radians);
  archive.value("kilometres", image.units.kilometres);
  archive.value("down", image.units.down);
  archive.value("west", image.west);
  archive.value("north", image.north_from);
  archive.value("south", image.south_from);
  chart = image;
}

std::uint64_t fingerprint(const mesh::MeshView& mesh, const core::Threads& threads) {
  constexpr std::int64_t grain = 1 << 16;
  const std::int64_t count = mesh.cell_count();
  std::vector<std::uint64_t> parts(std::size_t((count + grain - 1) / grain), basis);
  threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    std::uint64_t hash = basis;
    mesh::CellVertices cell;
    for (std::int64_t c = begin; c < end; ++c) {
      mesh::gather(mesh, c, cell);
      hash = mix(hash, std::uint64_t(cell.shape) << 32 | std::uint64_t(cell.piece));
      for (int v = 0; v < cell.count; ++v)
        hash = mix(hash, std::uint64_t(cell.ids[v]));
    }
    parts[std::size_t(begin / grain)] = hash;
  });
  std::uint64_t hash = mix(basis, std::uint64_t(count));
  for (const std::uint64_t part : parts)
    hash = mix(hash, part);
  return mix(hash, std::uint64_t(mesh.first_vertex[mesh.piece_count]));
}

std::string checkpoint_path(const std::string& folder, std::int64_t cycle) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%06lld", static_cast<long long>(cycle));
  return folder + "/" + std::string(file_begin) + digits + std::string(file_end);
}

void remove_old_checkpoints(const std::string& folder, std::int64_t cycle, std::int64_t keep,
                            bool descends) {
  std::vector<std::int64_t> cycles;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(file_begin) || !name.ends_with(file_end))
      continue;
    std::int64_t of = 0;
    const char* end = name.data() + name.size() - file_end.size();
    const auto parsed = std::from_chars(name.data() + file_begin.size(), end, of);
    if (parsed.ec == std::errc() && parsed.ptr == end && (descends ? of >= cycle : of <= cycle) &&
        entry.path().string() == checkpoint_path(folder, of))
      cycles.push_back(of);
  }
  std::sort(cycles.rbegin(), cycles.rend());
  if (descends)
    std::reverse(cycles.begin(), cycles.end());
  for (std::size_t i = std::size_t(keep); i < cycles.size(); ++i)
    std::filesystem::remove(checkpoint_path(folder, cycles[i]), error);
}

// Of the runner.

void Runner::require_one_process(const char* what) const {
  if (environment_.world.size() > 1)
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      std::string(what) + " of several processes is not there yet");
}

/// All but the meshes.
void Runner::keep(core::Archive& archive) {
  archive.value("cycle", cycle_);
  archive.array("times", times_);
  std::vector<std::string> names;
  for (const auto& action : actions_)
    if (std::string name = action->state_name(); !name.empty())
      names.push_back(std::move(name));
  std::vector<std::string> found = names;
  archive.array("tracers", found);
  if (found != names) {
    const auto listed = [](const std::vector<std::string>& list) {
      std::string text;
      for (const std::string& name : list)
        text += (text.empty() ? "" : ", ") + name;
      return text.empty() ? std::string("nothing that moves") : text;
    };
    static_cast<output::CheckpointReader&>(archive).refuse(
        "it is of another scene: it has " + listed(found) + "; the scene has " + listed(names));
  }
  for (const auto& action : actions_)
    action->keep(archive);
}

void Runner::write_checkpoint(const std::string& path, MeshList meshes) {
  require_one_process("a checkpoint");
  if (!executed_)
    throw core::Error(INSITU_ERROR_ORDER,
                      "checkpoint '" + path + "': nothing was executed yet in this session");
  output::CheckpointWriter archive;
  keep(archive);
  std::size_t count = 0;
  for (commit::CommittedMesh* mesh : meshes)
    count += !mesh->lies_on_device();
  archive.value("meshes", count);
  for (commit::CommittedMesh* mesh : meshes)
    if (!mesh->lies_on_device()) {
      KeptMesh kept{mesh->mesh().name(),
                    fingerprint(mesh->mesh().view(), environment_.context.threads),
                    mesh->unguided(), mesh->mesh().copy_earlier(), mesh->earlier_chart()};
      kept.keep(archive, mesh->earlier_cells());
    }
  archive.commit(path);
  ++environment_.statistics.files;
}

void Runner::restart(const std::string& path) {
  require_one_process("a restart");
  output::CheckpointReader archive(path);
  keep(archive);
  std::size_t count = 0;
  archive.value("meshes", count);
  for (std::size_t i = 0; i < count; ++i) {
    RestoredMesh& mesh = kept_meshes_.emplace_back(environment_.context.memory);
    mesh.kept.keep(archive, mesh.cells);
  }
  archive.require_end();
  executed_ = true;
  lowest_cycle_ = highest_cycle_ = cycle_;
}

/// The earlier step of a restart: on the solver's cells, where these are still those of the
/// checkpoint, else on its own. Of an adaptive mesh with other cells it is lost.
void Runner::bring_back_earlier(MeshList meshes) {
  const core::Threads& threads = environment_.context.threads;
  for (RestoredMesh& restored : kept_meshes_)
    for (commit::CommittedMesh* mesh : meshes) {
      const KeptMesh& kept = restored.kept;
      if (mesh->mesh().name() != kept.name || mesh->lies_on_device())
        continue;
      const bool same_cells = fingerprint(mesh->mesh().view(), threads) == kept.fingerprint;
      if (same_cells)
        mesh->restore_unguided(kept.unguided);
      if (same_cells && !kept.step.fields.empty())
        mesh->mesh().set_earlier(kept.step);
      if (!same_cells) {
        mesh->restore_earlier_mesh(kept.step, std::move(restored.cells), kept.chart, threads);
        continue;
      }
      for (const auto& action : actions_)
        if (action->is_of(*mesh, meshes))
          action->take_up_cells();
    }
  kept_meshes_.clear();
}

void Runner::write_due_checkpoint(MeshList meshes) {
  if (!checkpoint_.every || cycle_ % *checkpoint_.every != 0)
    return;
  write_checkpoint(checkpoint_path(environment_.output, cycle_), meshes);
  remove_old_checkpoints(environment_.output, cycle_, checkpoint_.keep, descends_);
}

} // namespace insitu::scene
