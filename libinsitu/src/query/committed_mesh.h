#pragma once

#include <cstdint>
#include <string>

#include "accel/tree.h"
#include "core/log.h"
#include "mesh/mesh.h"
#include "mesh/validate.h"
#include "query/sampler.h"

namespace insitu::query {

/// A registered mesh with its tree, and the policy that keeps the tree up to date.
class CommittedMesh {
public:
  CommittedMesh(const std::string& name, core::Memory& memory);

  mesh::Mesh& mesh() { return mesh_; }
  const mesh::Mesh& mesh() const { return mesh_; }
  const accel::Tree& tree() const { return tree_; }
  void set_builder(accel::Builder builder) { builder_ = builder; }
  /// The frame of the mesh's coordinates (an attribute; conversions are geo's).
  insitu_frame frame = insitu_frame_default();

  /// Brings the tree up to date with what changed: topology -> validate, rebuild; geometry -> refit,
  /// and rebuild once the refitted tree costs rebuild_ratio times the built one; fields -> nothing
  /// here. strict refuses converted arrays. Throws core::Error; the mesh then is not committed.
  insitu_commit_report commit(const core::Threads& threads, const core::Log& log,
                              const core::Memory& memory, bool strict);

  /// Validates the arrays as they are; the mesh need not be committed.
  mesh::Validation validate(const core::Threads& threads);

  bool committed() const { return committed_ && mesh_.pending() == 0; }
  /// Throws INSITU_ERROR_ORDER unless committed.
  void require_committed() const;
  /// Hinted queries answer fastest once it is known that no cell folds. Topology commits find out;
  /// after the vertices moved, this does, in about three refits' time (once a step): for callers
  /// with many hints.
  void look_for_folds(const core::Threads& threads);
  Sampler sampler() const { return {mesh_.view(), tree_}; }

  /// Grow with each commit that changed values, or cells and coordinates: for caches made from them.
  std::uint64_t fields_version() const { return fields_version_; }
  std::uint64_t tree_version() const { return tree_version_; }
  std::uint64_t topology_version() const { return topology_version_; }

  static constexpr double rebuild_ratio = 1.3;

private:
  mesh::Mesh mesh_;
  accel::Tree tree_;
  accel::Builder builder_ = accel::Builder::automatic;
  bool committed_ = false;
  bool folds_are_known_ = false;
  int commits_since_build_ = 0;
  std::uint64_t fields_version_ = 0, tree_version_ = 0, topology_version_ = 0;
};

} // namespace insitu::query
