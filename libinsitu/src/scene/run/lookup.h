#pragma once

#include <string>

#include "commit/committed_mesh.h"
#include "scene/parse/names.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// "file:line: " for messages about what a scene names; empty for line 0.
std::string at_line(const std::string& scene_file, int line);

/// Returns the mesh of that name, or the first mesh if the name is empty. Throws INSITU_ERROR_SCENE
/// if there is no such mesh.
commit::CommittedMesh& find_mesh(MeshList meshes, const Name& name, const std::string& scene_file);

/// Returns the field of that name. If there is none, the message of the error starts with
/// "file:line: ".
mesh::FieldView find_field(const commit::CommittedMesh& mesh, const Name& name,
                           const std::string& scene_file);
/// Returns the field of that name on the own cells of the solver, which on an adaptive mesh are not
/// those of its dual.
mesh::FieldView find_own_field(const commit::CommittedMesh& mesh, const Name& name,
                               const std::string& scene_file);

} // namespace insitu::scene
