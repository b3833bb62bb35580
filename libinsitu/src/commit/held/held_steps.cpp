#include "commit/held/held_steps.h"

#include <algorithm>
#include <string>

#include "core/status.h"

namespace insitu::commit {

std::vector<CommittedMesh*> HeldStep::shown() const {
  std::vector<CommittedMesh*> out;
  for (const OfMesh& m : meshes)
    out.push_back(&m.mesh->mesh());
  return out;
}

void HeldSteps::set_most(int steps) {
  most_ = steps;
  while (int(steps_.size()) > most_)
    drop(steps_.begin());
}

void HeldSteps::drop(std::vector<HeldStep>::iterator step) {
  for (const HeldStep::OfMesh& m : step->meshes) {
    m.mesh->forget(*m.values);
    if (m.mesh.use_count() > 1)
      continue;
    const auto totals = m.mesh->mesh().locate_counts().totals();
    for (std::size_t r = 0; r < totals.size(); ++r)
      gone_[r] += totals[r];
  }
  steps_.erase(step);
}

void HeldSteps::hold(std::int64_t cycle, double time, std::span<CommittedMesh* const> meshes,
                     parallel::World& world, const core::Threads& threads) {
  // A mesh that stands is found before its step is dropped; all processes make it anew, or none.
  std::vector<std::shared_ptr<HeldMesh>> known;
  std::vector<std::int64_t> lacks;
  HeldStep step{cycle, time, {}};
  world.agree_after([&] {
    known.resize(meshes.size());
    step.meshes.resize(meshes.size());
    steps_.reserve(steps_.size() + 1);
    for (std::size_t m = 0; m < meshes.size(); ++m)
      for (const HeldStep& before : steps_)
        for (const HeldStep::OfMesh& held : before.meshes)
          if (held.mesh->is_of(*meshes[m]))
            known[m] = held.mesh;
    for (const auto& mesh : known)
      lacks.push_back(!mesh);
  });
  world.reduce(lacks, parallel::Reduction::greatest);
  for (std::size_t m = 0; m < meshes.size(); ++m)
    if (lacks[m])
      known[m].reset();
  const auto same =
      std::ranges::find_if(steps_, [&](const HeldStep& s) { return s.cycle == cycle; });
  if (same != steps_.end())
    drop(same);
  while (int(steps_.size()) >= most_)
    drop(steps_.begin());
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const bool is_new = lacks[m] != 0;
    HeldStep::OfMesh& held = step.meshes[m];
    held.frame = meshes[m]->reference_frame;
    if (!is_new)
      held.mesh = known[m];
    world.agree_after([&] {
      held.values = std::make_unique<mesh::ValuesGiven>(meshes[m]->mesh(), *memory_, threads);
      if (!is_new)
        return;
      held.mesh = std::make_shared<HeldMesh>(*meshes[m], *memory_);
      builds_ += held.mesh->copy(*held.values, threads);
    });
    if (is_new)
      held.mesh->meet(world, threads);
  }
  steps_.push_back(std::move(step)); // for which there is room
}

std::vector<std::int64_t> HeldSteps::cycles() const {
  std::vector<std::int64_t> out;
  for (const HeldStep& step : steps_)
    out.push_back(step.cycle);
  return out;
}

const HeldStep& HeldSteps::find(std::int64_t cycle) const {
  const auto step =
      std::ranges::find_if(steps_, [&](const HeldStep& s) { return s.cycle == cycle; });
  if (step != steps_.end())
    return *step;
  std::string held;
  for (const std::int64_t c : cycles())
    held += " " + std::to_string(c);
  throw core::Error(INSITU_ERROR_ARGUMENT,
                    "cycle " + std::to_string(cycle) + " is not held; " +
                        (held.empty() ? "none is" : "those held are" + held));
}

void HeldSteps::put(const HeldStep& step, const core::Threads& threads) {
  for (const HeldStep::OfMesh& m : step.meshes) {
    m.mesh->mesh().reference_frame = m.frame;
    builds_ += m.mesh->put(*m.values, threads);
  }
}

std::vector<const CommittedMesh*> HeldSteps::meshes() const {
  std::vector<const CommittedMesh*> out;
  for (const HeldStep& step : steps_)
    for (const HeldStep::OfMesh& m : step.meshes)
      if (std::ranges::find(out, &m.mesh->mesh()) == out.end())
        out.push_back(&m.mesh->mesh());
  return out;
}

std::array<std::int64_t, query::reason_count> HeldSteps::located() const {
  std::array<std::int64_t, query::reason_count> sum = gone_;
  for (const CommittedMesh* const mesh : meshes()) {
    const auto totals = mesh->locate_counts().totals();
    for (std::size_t r = 0; r < totals.size(); ++r)
      sum[r] += totals[r];
  }
  return sum;
}

} // namespace insitu::commit
