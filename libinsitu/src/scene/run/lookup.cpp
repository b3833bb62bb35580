#include "scene/run/lookup.h"

#include <algorithm>
#include <map>

#include "core/status.h"
#include "core/suggest.h"
#include "core/text.h"

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

commit::CommittedMesh& find_host_mesh(MeshList meshes, const Name& name,
                                      const std::string& scene_file) {
  commit::CommittedMesh& mesh = find_mesh(meshes, name, scene_file);
  if (mesh.lies_on_device())
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "mesh '" + mesh.mesh().name() +
                          "' lies in device memory; scenes read host memory");
  return mesh;
}

mesh::FieldView find_field(const commit::CommittedMesh& mesh, const Name& name,
                           const std::string& scene_file) {
  return at_line_of(name, scene_file, [&] { return mesh.mesh().field(name.text); });
}

mesh::FieldView find_own_field(const commit::CommittedMesh& mesh, const Name& name,
                               const std::string& scene_file) {
  return at_line_of(name, scene_file, [&] { return mesh.mesh().own_field(name.text); });
}

std::vector<mesh::FieldView> find_fields(const commit::CommittedMesh& mesh,
                                         std::span<const Name> names, const std::string& scene_file,
                                         parallel::World& world, CellsOf cells) {
  std::vector<mesh::FieldView> views;
  std::vector<std::int64_t> known; // components and association, as one number; -1: not known here
  world.agree_after([&] {
    const bool has_cells = mesh.mesh().own_view().own_cell_count() > 0;
    known.assign(names.size(), -1);
    for (std::size_t i = 0; i < names.size(); ++i) {
      views.push_back({names[i].text.c_str()});
      if (world.size() > 1 && !has_cells && !mesh.mesh().has_field(names[i].text))
        continue;
      views[i] = cells == CellsOf::view ? find_field(mesh, names[i], scene_file)
                                        : find_own_field(mesh, names[i], scene_file);
      known[i] = std::int64_t(views[i].components) << 1 | std::int64_t(views[i].association);
    }
  });
  world.reduce(known, parallel::Reduction::greatest);
  world.agree_after([&] {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (known[i] < 0) // on all processes: says it as one of them would
        find_field(mesh, names[i], scene_file);
      views[i].components = int(known[i] >> 1);
      views[i].association = insitu_association(known[i] & 1);
    }
  });
  return views;
}

std::vector<std::string> field_names_of_all(const commit::CommittedMesh& mesh,
                                            parallel::World& world) {
  std::vector<std::string> names = mesh.mesh().field_names();
  if (world.size() == 1)
    return names;
  std::string mine, all;
  world.agree_after([&] {
    for (const std::string& name : names)
      core::join(mine, name);
  });
  std::map<int, std::string> lists;
  world.gather(std::as_bytes(std::span(mine.data(), mine.size())), std::size_t(1) << 20,
               [&](int rank, std::span<const std::byte> bytes) {
                 lists[rank].append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
               });
  world.agree_after([&] {
    names.clear();
    for (const auto& [rank, list] : lists)
      for (const std::string& name : core::parted(list))
        if (std::find(names.begin(), names.end(), name) == names.end()) {
          names.push_back(name);
          core::join(all, name);
        }
  });
  all = world.broadcast(all);
  world.agree_after([&] { names = core::parted(all); });
  return names;
}

std::int64_t cells_of_all(const mesh::Mesh& mesh, parallel::World& world) {
  std::int64_t count = mesh.own_view().own_cell_count();
  world.reduce(std::span(&count, 1), parallel::Reduction::sum);
  return count;
}

} // namespace insitu::scene
