#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "insitu/insitu.hpp"

#include "records/assembly.h"
#include "records/record.h"

namespace insitu_replay {

/// Gives the meshes of records to a session, step after step, as the recorded run did: what had not
/// changed there is not given again. It holds the arrays that the session reads, and outlives it.
class RecordedMeshes {
public:
  /// Reads a record and gives it, in the place of the step before. Throws FileError, also for what
  /// the library refuses.
  Record give(insitu::Session& session, const std::string& path);
  /// Of a record that was read.
  void give(insitu::Session& session, const RecordSource& source, const Record& record);

  /// The meshes given so far, with their names.
  std::vector<std::pair<std::string, insitu::Mesh>> meshes() const;

private:
  using Bytes = std::unique_ptr<std::byte[]>;
  struct Known {
    insitu::Mesh mesh;
    bool given = false;
    std::int64_t topology = 0, geometry = 0;
    std::size_t pieces = 0;
    std::vector<PieceArrays> of_cells;                 ///< in `cells`
    std::optional<Assembly> assembly;                  ///< in the place of the pieces
    std::vector<Bytes> cells, points, values;          ///< arrays that the session reads
    std::map<std::string, std::vector<double>> blanks; ///< of the fields given
  };
  class Giver;

  std::map<std::string, Known> known_; ///< by name
  std::vector<std::string> order_;
};

} // namespace insitu_replay
