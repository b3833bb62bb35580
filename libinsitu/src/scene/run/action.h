#pragma once

#include <optional>
#include <string>
#include <vector>

#include "advect/particles.h"
#include "core/archive.h"
#include "scene/expression/trigger.h"
#include "scene/parse/names.h"
#include "scene/run/plan.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// Something a scene asks for: a probe, a tracer, a frame. A failed action throws core::Error from
/// execute() and is tried again when it is next due.
class Action {
public:
  virtual ~Action() = default;
  virtual const char* kind() const = 0;
  virtual const std::string& name() const = 0;
  virtual const Trigger& trigger() const = 0;
  virtual const Name& mesh_name() const = 0;
  /// Called at every cycle; due: the trigger says so.
  virtual void execute(commit::CommittedMesh& mesh, const Step& step, bool due) = 0;
  /// The session closes.
  virtual void finish() {}
  /// What a checkpoint knows it by, in words that hold all that its state depends on; empty: it has
  /// none.
  virtual std::string state_name() const { return {}; }
  /// Its state, to a checkpoint or back.
  virtual void keep(core::Archive& /*archive*/) {}
  /// Before the first cycle after a restart: the mesh has the cells of the checkpoint.
  virtual void take_up_cells() {}
  /// Adds what it needs of the mesh beyond the tree, and what it does without. May throw like
  /// execute().
  virtual void plan(const commit::CommittedMesh& mesh, Plan& plan) const = 0;
  /// What became of its particles, if it has any.
  virtual std::optional<advect::Counts> particles() const { return std::nullopt; }
  /// The fields whose earlier steps it needs at the next cycle.
  virtual std::vector<mesh::KeptField> needs_earlier() const { return {}; }
  /// Whether these steps serve it over a change of topology as well.
  virtual bool goes_on_to_other_cells() const { return false; }
};

} // namespace insitu::scene
