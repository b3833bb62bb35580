#include "scene/frame_structures.h"

#include <algorithm>

namespace insitu::scene {

render::Structures& FrameStructures::of(const query::CommittedMesh& mesh) {
  Entry& entry = by_mesh_[mesh.id()];
  if (!entry.structures)
    entry.structures = std::make_unique<render::Structures>(*memory_);
  if (!entry.begun)
    entry.structures->begin(mesh.sampler(), mesh.tree_version(), mesh.fields_version(), *threads_);
  entry.begun = true;
  return *entry.structures;
}

void FrameStructures::end_cycle(std::span<query::CommittedMesh* const> meshes) {
  for (auto it = by_mesh_.begin(); it != by_mesh_.end();) {
    Entry& entry = it->second;
    const bool exists =
        std::any_of(meshes.begin(), meshes.end(),
                    [&](const query::CommittedMesh* mesh) { return mesh->id() == it->first; });
    if (!exists) {
      gone_ += entry.structures->counts();
      it = by_mesh_.erase(it);
      continue;
    }
    if (entry.begun)
      entry.structures->end();
    entry.begun = false;
    ++it;
  }
}

render::Structures::Counts FrameStructures::counts() const {
  render::Structures::Counts sum = gone_;
  for (const auto& [id, entry] : by_mesh_)
    sum += entry.structures->counts();
  return sum;
}

} // namespace insitu::scene
