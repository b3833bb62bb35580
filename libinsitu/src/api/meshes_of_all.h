#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "commit/committed_mesh.h"

namespace insitu::api {

/// Returns the meshes of this process and their fields, for MeshesOfAll::add().
std::string list_meshes(std::span<commit::CommittedMesh* const> meshes);

/// The meshes and fields of all processes, as one process sees them that is told their lists.
class MeshesOfAll {
public:
  /// Adds a process's list; ranks ascend. Throws core::Error (INSITU_ERROR_FIELD) if a field is
  /// not as a process before has it.
  void add(int rank, const std::string& list);

  /// The names in the order in which the first process that has them made the meshes, as a list
  /// for core::parted().
  std::string names() const;

  /// The first scalar field of the first mesh that has one, and that mesh; or empty names.
  std::pair<std::string, std::string> scalar() const;

private:
  struct Field {
    std::string mesh, name, what;
    int rank; ///< the first that has it
  };
  std::vector<std::string> meshes_;
  std::vector<Field> fields_;
  std::map<std::pair<std::string, std::string>, std::size_t> known_;
};

} // namespace insitu::api
