#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "commit/committed_mesh.h"
#include "core/parallel.h"
#include "parallel/world.h"
#include "scene/expression/counted_vertices.h"
#include "scene/expression/reduction.h"
#include "scene/parse/names.h"

namespace insitu::scene {

/// Numbers made of a field's values on all processes. They depend neither on the number of
/// processes nor on threads: means are exact sums, rounded at the end.
class FieldReductions {
public:
  FieldReductions(parallel::World& world, const core::Threads& threads)
      : world_(world), threads_(threads) {}

  /// Returns the minimum, maximum or mean of a field (for a vector field, of its magnitudes) over
  /// owning cells, or over the vertices that they use, each counted once (CountedVertices). NaN
  /// values are left out; the result is NaN if no value is left. Collective, and the same number on
  /// all processes. Throws parallel::AgreedError.
  double operator()(const commit::CommittedMesh& mesh, const Name& field,
                    const std::string& scene_file, Reduction reduction);

private:
  parallel::World& world_;
  const core::Threads& threads_;
  std::map<std::string, CountedVertices> counted_; ///< by the mesh's name
};

/// The same of this process's cells alone, which is not collective.
double reduce_field(const commit::CommittedMesh& mesh, const Name& field,
                    const std::string& scene_file, Reduction reduction,
                    const core::Threads& threads);

} // namespace insitu::scene
