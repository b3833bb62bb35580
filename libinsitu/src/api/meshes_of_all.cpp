#include "api/meshes_of_all.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/status.h"
#include "core/text.h"

namespace insitu::api {

namespace {

const std::string at_vertices = " at vertices", scalar_words = "1 component";

/// Adds texts to a list.
void put(std::string& list, std::initializer_list<std::string_view> texts) {
  for (const std::string_view text : texts)
    core::join(list, text);
}

} // namespace

/// Of each mesh its name with nothing behind, and of each field the mesh, the name, and what it is.
std::string list_meshes(std::span<commit::CommittedMesh* const> meshes) {
  std::string all;
  for (const commit::CommittedMesh* const m : meshes) {
    put(all, {m->mesh().name(), "", ""});
    for (const std::string& name : m->mesh().field_names()) {
      const mesh::FieldView field = m->mesh().field(name);
      const std::string components =
          field.components == 1 ? scalar_words : std::to_string(field.components) + " components";
      put(all, {m->mesh().name(), name,
                components + (field.association == INSITU_VERTEX ? at_vertices : " at cells")});
    }
  }
  return all;
}

void MeshesOfAll::add(int rank, const std::string& list) {
  const std::vector<std::string> texts = core::parted(list);
  for (std::size_t i = 0; i + 3 <= texts.size(); i += 3) {
    const std::string &mesh = texts[i], &name = texts[i + 1], &what = texts[i + 2];
    if (what.empty()) {
      if (std::find(meshes_.begin(), meshes_.end(), mesh) == meshes_.end())
        meshes_.push_back(mesh);
      continue;
    }
    const auto [known, is_new] = known_.try_emplace({mesh, name}, fields_.size());
    if (is_new) {
      fields_.push_back({mesh, name, what, rank});
      continue;
    }
    const Field& first = fields_[known->second];
    if (first.what != what)
      throw core::Error(INSITU_ERROR_FIELD, "processes differ: field '" + name + "' of mesh '" +
                                                mesh + "' has " + first.what + " on process " +
                                                std::to_string(first.rank) + ", " + what +
                                                " on process " + std::to_string(rank));
  }
}

std::string MeshesOfAll::names() const {
  std::string all;
  for (const std::string& name : meshes_)
    put(all, {name});
  return all;
}

std::pair<std::string, std::string> MeshesOfAll::scalar() const {
  for (const std::string& mesh : meshes_)
    for (const Field& field : fields_)
      if (field.mesh == mesh && field.what.starts_with(scalar_words + " "))
        return {field.name, mesh};
  return {};
}

} // namespace insitu::api
