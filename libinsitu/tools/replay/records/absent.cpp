/// Of a build without HDF5.
#include "file_error.h"
#include "records/meshes.h"

namespace insitu_replay {

bool is_record(const std::string&) {
  return false;
}

std::unique_ptr<RecordSource> open_record(const std::string& path) {
  throw FileError(path, "this build has no HDF5 (INSITU_WITH_HDF5)");
}

Record read_record(const RecordSource&) {
  return {};
}

void RecordedMeshes::give(insitu::Session&, const RecordSource&, const Record&) {}

Record RecordedMeshes::give(insitu::Session&, const std::string& path) {
  (void)open_record(path);
  return {};
}

std::vector<std::pair<std::string, insitu::Mesh>> RecordedMeshes::meshes() const {
  return {};
}

} // namespace insitu_replay
