#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "commit/held/held_mesh.h"

namespace insitu::commit {

/// A step that is held.
struct HeldStep {
  struct OfMesh {
    std::shared_ptr<HeldMesh> mesh;
    std::unique_ptr<mesh::ValuesGiven> values;
    insitu_frame frame; ///< of the mesh's coordinates, then
  };
  std::int64_t cycle;
  double time;
  std::vector<OfMesh> meshes; ///< in the order of the session's

  /// Its meshes, as they are while it is shown.
  std::vector<CommittedMesh*> shown() const;
};

/// The last steps of a session, each with its meshes apart from the solver's. What they hold is
/// given back when the last step that has it goes.
class HeldSteps {
public:
  explicit HeldSteps(core::Memory& memory) : memory_(&memory) {}

  /// How many steps are held at most; the oldest go. 0: none.
  void set_most(int steps);
  int most() const { return most_; }

  /// Holds a step of committed meshes in the place of that of the same cycle, if there is one, else
  /// of the oldest if there are as many as may be. Collective; throws parallel::AgreedError, and
  /// the step is then not held.
  void hold(std::int64_t cycle, double time, std::span<CommittedMesh* const> meshes,
            parallel::World& world, const core::Threads& threads);

  /// Of the steps held, the oldest first.
  std::vector<std::int64_t> cycles() const;
  /// The step of that cycle; valid until one is held or dropped. Throws core::Error
  /// (INSITU_ERROR_ARGUMENT) if it is not held.
  const HeldStep& find(std::int64_t cycle) const;
  /// Puts the values of a step into its meshes, which then are as that step's were.
  void put(const HeldStep& step, const core::Threads& threads);

  /// All meshes of all steps, each once.
  std::vector<const CommittedMesh*> meshes() const;
  /// How many trees holding and showing has built; none but where the solver's mesh had none.
  std::int64_t builds() const { return builds_; }
  /// Points located in them and in those that are gone.
  std::array<std::int64_t, query::reason_count> located() const;

private:
  void drop(std::vector<HeldStep>::iterator step);

  core::Memory* memory_;
  int most_ = 0;
  std::vector<HeldStep> steps_;
  std::int64_t builds_ = 0;
  std::array<std::int64_t, query::reason_count> gone_{}; ///< located in meshes that are gone
};

} // namespace insitu::commit
