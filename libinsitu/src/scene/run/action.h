#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "advect/particles.h"
#include "core/archive.h"
#include "scene/checkpoint/kept_cells.h"
#include "scene/expression/trigger.h"
#include "scene/parse/names.h"
#include "scene/run/plan.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// An action is something that a scene asks for: a probe, a tracer, a frame. An action that fails
/// throws core::Error from execute(), and the runner tries it again when it is next due.
///
/// Where a session has several processes (Environment::world), all of them execute an action at the
/// same cycles, due or not alike, each with its own cells of the mesh or none. An action exchanges
/// what it needs meanwhile, as a row of phases (World::agree_after), and the root alone writes its
/// files; whatever it throws there is a parallel::AgreedError, on all processes alike.
class Action {
public:
  virtual ~Action() = default;
  virtual const char* kind() const = 0;
  virtual const std::string& name() const = 0;
  virtual const Trigger& trigger() const = 0;
  virtual const Name& mesh_name() const = 0;
  /// Whether the action is of this mesh, which is one of the session's.
  bool is_of(const commit::CommittedMesh& mesh, MeshList meshes) const {
    const Name& name = mesh_name();
    return name.empty() ? &mesh == meshes.front() : name.text == mesh.mesh().name();
  }
  /// Runs the action. The runner calls this at every cycle; due says whether the trigger holds.
  virtual void execute(commit::CommittedMesh& mesh, const Step& step, bool due) = 0;
  /// The session is about to close, and messages can still be sent. Collective; throws
  /// parallel::AgreedError.
  virtual void meet_end() {}
  /// Whether the action can be done at a step that is held, in the midst of live ones: not if it
  /// goes on from one step to the next.
  virtual bool serves_held_steps() const { return true; }
  /// Ends the action when the session closes. Not collective: MPI may have been finalised.
  virtual void finish() {}
  /// Returns the name by which a checkpoint knows the state of the action, in words that hold
  /// everything that the state depends on. An empty name means that the action has no state.
  virtual std::string state_name() const { return {}; }
  /// A checkpoint is about to be written: gathers at the root what the two functions below write
  /// there. mesh: the action's; null if there is none. Collective; throws parallel::AgreedError.
  virtual void meet_checkpoint(const commit::CommittedMesh* /*mesh*/) {}
  /// Writes the state that all processes have alike to a checkpoint, at the root, or reads it from
  /// one, on all processes.
  virtual void keep(core::Archive& /*archive*/) {}
  /// Writes further state to a checkpoint, at the root, or reads it from one, there alone.
  virtual void keep_at_root(core::Archive& /*archive*/) {}
  /// The runner calls this before the first cycle after a restart, with what is known of the cells
  /// of the checkpoint in the action's mesh; not if the checkpoint does not have the mesh. Not
  /// collective.
  virtual void take_up_cells(const std::shared_ptr<const KeptCells>& /*cells*/) {}
  /// Adds to the plan what the action needs of the mesh beyond the tree, and what it does without;
  /// the same of others of the session's that it needs besides. May throw as execute() does.
  virtual void plan(const commit::CommittedMesh& mesh, MeshList meshes, Plan& plan) const = 0;
  /// Returns what became of the particles of the action; an empty optional means that it has no
  /// particles.
  virtual std::optional<advect::Counts> particles() const { return std::nullopt; }
  /// Of several processes, the share of this one: the sum over all is particles().
  virtual std::optional<advect::Counts> particles_here() const { return particles(); }
  /// Returns the axes of the mesh's box over whose sides the action's particles come in again.
  virtual commit::PeriodicAxes periodic_axes() const { return {}; }
  /// Returns the fields whose earlier steps the action needs at the next cycle.
  virtual std::vector<mesh::KeptField> needs_earlier() const { return {}; }
  /// Returns whether these earlier steps serve the action over a change of topology as well.
  virtual bool goes_on_to_other_cells() const { return false; }
};

} // namespace insitu::scene
