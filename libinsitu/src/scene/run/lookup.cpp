#include "scene/run/lookup.h"

#include <vector>

#include "core/status.h"
#include "core/suggest.h"

namespace insitu::scene {

namespace {

template <class Find>
mesh::FieldView at_line_of(const Name& name, const std::string& scene_file, Find&& find) {
  try {
    return find();
  } catch (const core::Error& e) {
    throw core::Error(e.status(), at_line(scene_file, name.line) + e.what());
  }
}

} // namespace

std::string at_line(const std::string& scene_file, int line) {
  return line > 0 ? scene_file + ":" + std::to_string(line) + ": " : std::string();
}

commit::CommittedMesh& find_mesh(MeshList meshes, const Name& name, const std::string& scene_file) {
  if (meshes.empty())
    throw core::Error(INSITU_ERROR_SCENE, "the session has no mesh");
  if (name.empty())
    return *meshes.front();
  std::vector<std::string> names;
  for (commit::CommittedMesh* m : meshes) {
    if (m->mesh().name() == name.text)
      return *m;
    names.push_back(m->mesh().name());
  }
  throw core::Error(INSITU_ERROR_SCENE, at_line(scene_file, name.line) +
                                            "the session has no mesh '" + name.text + "'" +
                                            core::did_you_mean(name.text, names));
}

mesh::FieldView find_field(const commit::CommittedMesh& mesh, const Name& name,
                           const std::string& scene_file) {
  return at_line_of(name, scene_file, [&] { return mesh.mesh().field(name.text); });
}

mesh::FieldView find_own_field(const commit::CommittedMesh& mesh, const Name& name,
                               const std::string& scene_file) {
  return at_line_of(name, scene_file, [&] { return mesh.mesh().own_field(name.text); });
}

} // namespace insitu::scene
