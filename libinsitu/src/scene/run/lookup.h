#pragma once

#include <span>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "parallel/world.h"
#include "scene/parse/names.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// "file:line: " for messages about what a scene names; empty for line 0.
std::string at_line(const std::string& scene_file, int line);

/// Returns the mesh of that name, or the first mesh if the name is empty. Throws INSITU_ERROR_SCENE
/// if there is no such mesh.
commit::CommittedMesh& find_mesh(MeshList meshes, const Name& name, const std::string& scene_file);

/// The same, and throws INSITU_ERROR_UNSUPPORTED for a mesh in device memory.
commit::CommittedMesh& find_host_mesh(MeshList meshes, const Name& name,
                                      const std::string& scene_file);

/// Returns the field of that name. If there is none, the message of the error starts with
/// "file:line: ".
mesh::FieldView find_field(const commit::CommittedMesh& mesh, const Name& name,
                           const std::string& scene_file);
/// Returns the field of that name on the own cells of the solver, which on an adaptive mesh are not
/// those of its dual.
mesh::FieldView find_own_field(const commit::CommittedMesh& mesh, const Name& name,
                               const std::string& scene_file);

/// Whose cells a field's values are wanted on: those of mesh().view(), or the solver's own.
enum class CellsOf { view, own_view };
/// Returns the fields of these names as all processes have them. On a process that has no cells and
/// lacks a field, its view has no pieces, and the components and the association that the field
/// has elsewhere. Collective. Throws parallel::AgreedError (INSITU_ERROR_FIELD) if a process that
/// has cells lacks a field, or nobody has it. Names of the views are those of `names`, which stay.
std::vector<mesh::FieldView> find_fields(const commit::CommittedMesh& mesh,
                                         std::span<const Name> names, const std::string& scene_file,
                                         parallel::World& world, CellsOf cells = CellsOf::view);
/// Returns the names of the fields of all processes: those of the first process that has any, then
/// those that further processes have besides. Collective.
std::vector<std::string> field_names_of_all(const commit::CommittedMesh& mesh,
                                            parallel::World& world);
/// Returns how many cells the mesh has on all processes. Collective.
std::int64_t cells_of_all(const mesh::Mesh& mesh, parallel::World& world);

} // namespace insitu::scene
