#pragma once

#include <string>

#include "commit/committed_mesh.h"
#include "scene/parse/names.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// "file:line: " for messages about what a scene names; empty for line 0.
std::string at_line(const std::string& scene_file, int line);

/// The mesh of that name (the first one if empty); throws INSITU_ERROR_SCENE.
commit::CommittedMesh& find_mesh(MeshList meshes, const Name& name, const std::string& scene_file);

/// The field of that name, with "file:line: " before the message if there is none.
mesh::FieldView find_field(const commit::CommittedMesh& mesh, const Name& name,
                           const std::string& scene_file);
/// The same on the solver's own cells (those of an adaptive mesh, not of its dual).
mesh::FieldView find_own_field(const commit::CommittedMesh& mesh, const Name& name,
                               const std::string& scene_file);

} // namespace insitu::scene
