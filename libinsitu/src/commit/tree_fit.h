#pragma once

#include "accel/tree/tree.h"
#include "cells/checks/odd_cells.h"
#include "commit/tree_policy.h"
#include "mesh/registered/mesh.h"
#include "query/on_demand.h"

namespace insitu::commit {

/// Fits of a mesh's tree: those that commits said were due, and those that were done, most of them
/// later, when somebody asked for the tree. rebuilds: done after a refit, or put off themselves.
struct FitsDone {
  std::int64_t put_off = 0, refits = 0, rebuilds = 0;
  double seconds = 0.0;
  FitsDone& operator+=(const FitsDone& more) {
    put_off += more.put_off;
    refits += more.refits;
    rebuilds += more.rebuilds;
    seconds += more.seconds;
    return *this;
  }
};

/// The fit of a committed mesh's tree to vertices that moved: a refit, and a rebuild where the
/// policy then finds one due; or, of a mesh that is spread over processes, its build. A commit puts
/// it off, and it is done once, when the tree is first asked; a step in which nobody asks has no
/// fit.
class TreeFit final : public query::PutOff {
public:
  /// What it works on, of one CommittedMesh.
  TreeFit(accel::Tree& tree, const mesh::Mesh& mesh, TreePolicy& policy, const cells::OddCells& odd)
      : tree_(tree), mesh_(mesh), policy_(policy), odd_(odd) {}

  /// The vertices moved. threads: the most that the fit may take.
  void put_off(int threads);
  /// The cells are others.
  void put_off_build(int threads);
  /// The tree is built anew, or goes.
  void forget();
  /// What the last fit did.
  insitu_action action() const { return action_; }
  /// A build was put off, or failed for want of memory: there is no tree until one is made.
  bool lacks_tree() const { return lacks_tree_; }
  const FitsDone& done() const { return done_; }

private:
  void do_it() const override;
  void build(const core::Threads& threads) const;

  accel::Tree& tree_;
  const mesh::Mesh& mesh_;
  TreePolicy& policy_;
  const cells::OddCells& odd_;
  int threads_ = 1;
  mutable bool lacks_tree_ = false;
  mutable insitu_action action_ = INSITU_KEEP;
  mutable FitsDone done_;
};

/// How far vertices moved since the earlier step, which is asked for with the tree alone, and found
/// when it is first asked then.
class Displacement final : public query::PutOff {
public:
  explicit Displacement(mesh::Mesh& mesh) : mesh_(mesh) {}
  void put_off(int threads) {
    threads_ = threads;
    set_due(true);
  }
  void forget() { set_due(false); }

private:
  void do_it() const override { mesh_.find_displacement(core::Threads(threads_)); }

  mesh::Mesh& mesh_;
  int threads_ = 1;
};

} // namespace insitu::commit
