#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/log.h"
#include "mesh/registered/mesh.h"

namespace insitu::api {

/// Finds arrays whose memory is not the solver's any more at the commit: temporaries, as Fortran
/// makes of a section that is given to an explicit-shape dummy. For checked sessions.
class GivenWatch {
public:
  /// A field of a piece was given: keeps a sample of its values.
  void note_field(const mesh::Mesh& mesh, std::int32_t piece, const std::string& field);
  /// The solver says what it has changed (INSITU_CHANGED_*): samples of that tell nothing any more.
  void told(std::uint32_t what);
  /// At the commit, before anything is read. Throws INSITU_ERROR_ARGUMENT for an array whose memory
  /// is not mapped any more; warns of values that are not those given, once each.
  void check(const mesh::Mesh& mesh, const core::Log& log);

private:
  struct Given {
    mesh::ExternalArray array;
    std::uint64_t sample;
  };
  std::map<std::string, Given> fields_; ///< since the last commit, by the array's name
};

} // namespace insitu::api
