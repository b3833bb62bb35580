#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "scene/record/piece_arrays.h"

/// The text of a record, as JSON, and the datasets that it speaks of.
namespace insitu::scene {

constexpr int record_version = 1;

/// What a process gave for a mesh.
struct RecordedPart {
  std::string text; ///< its pieces, with the arrays that they take of the datasets
  std::vector<RecordStream> streams;
};

/// folder: the mesh's group in the file. The mesh lies in host memory; the streams read its arrays.
RecordedPart recorded_part(const commit::CommittedMesh& mesh, const std::string& folder);

/// What all processes have alike of a mesh, and the parts of each of them.
std::string mesh_text(const commit::CommittedMesh& mesh, const std::vector<std::string>& parts);

/// What the name of a field's dataset begins with.
inline const char* const vertex_field = "vertex field ";
inline const char* const cell_field = "cell field ";
/// The name of a field's dataset in the mesh's group, without its type; fields' names may hold
/// slashes.
std::string field_dataset(const mesh::GivenField& field);

} // namespace insitu::scene
