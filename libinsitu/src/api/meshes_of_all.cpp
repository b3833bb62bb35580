#include "api/meshes_of_all.h"

#include <algorithm>
#include <sstream>

#include "core/parallel.h"
#include "core/status.h"

namespace insitu::api {

namespace {

const std::string at_vertices = " at vertices", scalar_words = "1 component";

/// Adds texts to a list. Names hold any byte but 0.
void put(std::string& list, std::initializer_list<std::string> texts) {
  for (const std::string& text : texts)
    list.append(text).push_back('\0');
}

bool take(std::istringstream& in, std::string& text) {
  return bool(std::getline(in, text, '\0'));
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
  std::istringstream in(list);
  for (std::string mesh, name, what; take(in, mesh) && take(in, name) && take(in, what);) {
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

std::vector<std::string> MeshesOfAll::read_names(const std::string& list) {
  std::istringstream in(list);
  std::vector<std::string> names;
  for (std::string name; take(in, name);)
    names.push_back(name);
  return names;
}

std::pair<std::string, std::string> MeshesOfAll::scalar() const {
  for (const std::string& mesh : meshes_)
    for (const Field& field : fields_)
      if (field.mesh == mesh && field.what.starts_with(scalar_words + " "))
        return {field.name, mesh};
  return {};
}

} // namespace insitu::api
