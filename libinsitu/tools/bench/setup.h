#pragma once

#include <memory>
#include <vector>

#include "commit/committed_mesh.h"
#include "core/context.h"
#include "options.h"
#include "workload/mesh.h"

namespace insitu::bench {

/// The mesh's own arrays, which must outlive what they are given to.
insitu_cells cells_of(const workload::Mesh& mesh);

/// A workload mesh as a session would hold it.
class Setup {
public:
  explicit Setup(const Options& options);

  /// A new committed mesh over the arrays, with nothing built.
  std::unique_ptr<commit::CommittedMesh> register_mesh();
  insitu_commit_report commit(commit::CommittedMesh& mesh);
  /// Moves every vertex a little, there and back in turns, so that a refit has work to do.
  void wobble();
  /// Fits the field's values to moved vertices, in place.
  void update_field();

  core::Context context;
  workload::Mesh mesh;
  std::vector<double> field;

private:
  double sign_ = 1.0;
};

} // namespace insitu::bench
