#include "scene/frames/frame_structures.h"

#include <algorithm>
#include <functional>

#include "scene/frames/chart_copies.h"

namespace insitu::scene {

render::Structures& FrameStructures::of(const commit::CommittedMesh& mesh) {
  Entry& entry = by_mesh_[mesh.id()];
  if (!entry.structures)
    entry.structures = std::make_unique<render::Structures>(context_->memory);
  // A frame that takes cells of other processes may find a mesh without them.
  if (!entry.begun || entry.tree != mesh.tree_version() || entry.fields != mesh.fields_version())
    entry.structures->begin(
        mesh.sampler(), mesh.tree_version(), mesh.fields_version(), context_->threads,
        has_chart_copies(mesh)
            ? [this, &mesh] { return find_chart_copies(mesh, context_->threads); }
            : std::function<render::ChartCopies()>());
  entry.begun = true;
  entry.tree = mesh.tree_version();
  entry.fields = mesh.fields_version();
  return *entry.structures;
}

commit::CommittedMesh& FrameStructures::geocentric(const commit::CommittedMesh& mesh,
                                                   double exaggeration) {
  Geocentric& entry = geocentric_[{mesh.id(), exaggeration}];
  if (!entry.mesh)
    entry.mesh =
        std::make_unique<GeocentricMesh>(mesh.mesh().name(), exaggeration, context_->memory);
  commit::CommittedMesh& drawn = entry.mesh->update(mesh, *context_);
  entry.id = drawn.id();
  return drawn;
}

commit::CommittedMesh& FrameStructures::on_chart(const commit::CommittedMesh& mesh, double west) {
  OnChart& entry = on_chart_[{mesh.id(), west}];
  if (!entry.mesh) {
    entry.mesh = std::make_unique<SharedMesh>(mesh.mesh().name(), context_->memory);
    entry.mesh->drawn().reference_frame = mesh.reference_frame;
    entry.mesh->drawn().chart_west = west;
    entry.id = entry.mesh->drawn().id();
  }
  entry.is_asked_for = true;
  return entry.mesh->update(mesh, *context_, [] { return nullptr; });
}

/// Whether a mesh, or the one that it draws in other coordinates, is among these.
bool FrameStructures::is_there(std::uint64_t id,
                               std::span<commit::CommittedMesh* const> meshes) const {
  for (const auto& [key, drawn] : geocentric_)
    if (drawn.id == id)
      id = key.first;
  for (const auto& [key, drawn] : on_chart_)
    if (drawn.id == id)
      id = key.first;
  if (std::find(kept_.begin(), kept_.end(), id) != kept_.end())
    return true;
  return std::any_of(meshes.begin(), meshes.end(),
                     [&](const commit::CommittedMesh* mesh) { return mesh->id() == id; });
}

void FrameStructures::end_cycle(std::span<commit::CommittedMesh* const> meshes) {
  const bool any =
      std::ranges::any_of(on_chart_, [](const auto& entry) { return entry.second.is_asked_for; });
  std::erase_if(on_chart_, [&](const auto& entry) {
    return (any && !entry.second.is_asked_for) || !is_there(entry.first.first, meshes);
  });
  for (auto& [key, drawn] : on_chart_)
    drawn.is_asked_for = false;
  for (auto it = by_mesh_.begin(); it != by_mesh_.end();) {
    Entry& entry = it->second;
    if (!is_there(it->first, meshes)) {
      gone_ += entry.structures->counts();
      gone_seconds_ += entry.structures->seconds();
      it = by_mesh_.erase(it);
      continue;
    }
    if (entry.begun)
      entry.structures->end();
    entry.begun = false;
    ++it;
  }
  std::erase_if(geocentric_, [&](const auto& entry) {
    const bool gone = !is_there(entry.first.first, meshes);
    if (gone)
      gone_conversions_ += entry.second.mesh->conversions();
    return gone;
  });
}

render::Structures::Counts FrameStructures::counts() const {
  render::Structures::Counts sum = gone_;
  for (const auto& [id, entry] : by_mesh_)
    sum += entry.structures->counts();
  return sum;
}

render::Structures::Seconds FrameStructures::seconds() const {
  render::Structures::Seconds sum = gone_seconds_;
  for (const auto& [id, entry] : by_mesh_)
    sum += entry.structures->seconds();
  return sum;
}

std::int64_t FrameStructures::geocentric_conversions() const {
  std::int64_t sum = gone_conversions_;
  for (const auto& [key, entry] : geocentric_)
    sum += entry.mesh->conversions();
  return sum;
}

} // namespace insitu::scene
