#include "scene/run/runner.h"

#include <algorithm>
#include <new>

#include "core/status.h"
#include "core/timer.h"
#include "scene/expression/reduce.h"
#include "scene/frames/frame_action.h"
#include "scene/probes/probe_action.h"
#include "scene/run/lookup.h"
#include "scene/run/mesh_plan.h"
#include "scene/tracers/tracer_action.h"

namespace insitu::scene {

Runner::Runner(const SceneDescription& scene, const std::string& output, core::Context& context,
               parallel::World& world, Statistics& statistics)
    : structures_(context),
      table_(scene.frames, output.empty() ? scene.output : output), environment_{context,
                                                                                 world,
                                                                                 statistics,
                                                                                 structures_,
                                                                                 table_,
                                                                                 scene.file,
                                                                                 output.empty()
                                                                                     ? scene.output
                                                                                     : output},
      locator_(scene.locator), checkpoint_(scene.checkpoint) {
  if (locator_.choice.backend || locator_.choice.method) { // what can never be had is said at once
    try {
      query::pick_locator(locator_.choice, false);
    } catch (const core::Error& e) {
      throw core::Error(e.status(),
                        scene.file + ":" + std::to_string(locator_.line) + ": " + e.what());
    }
  }
  if (scene.page) {
    page_ = std::make_unique<PageRecord>(scene, environment_.output, context, statistics);
    environment_.page = page_.get();
  }
  for (const Probe& p : scene.probes)
    actions_.push_back(std::make_unique<ProbeAction>(p, environment_));
  for (const Tracer& t : scene.tracers)
    actions_.push_back(make_tracer_action(t, environment_));
  for (const Frame& f : scene.frames)
    actions_.push_back(make_frame_action(f, environment_));
}

Runner::~Runner() = default;

bool Runner::is_due(const Action& action, const commit::CommittedMesh& mesh,
                    const Step& step) const {
  const core::Timer timer;
  const bool due = action.trigger().due(
      step.cycle, step.time, [&](Reduction reduction, const std::string& field) {
        return reduce_field(mesh, {field, action.trigger().line}, environment_.scene_file,
                            reduction, environment_.context.threads);
      });
  environment_.statistics.query_s += timer.seconds();
  return due;
}

/// Counts a failure, and logs it unless it was logged before. Texts that carry the cycle or a
/// number differ each time, so that of one action the first few are logged.
void Runner::report(const std::string& what, const std::string& of, std::int64_t cycle) {
  constexpr std::size_t most = 8;
  ++environment_.statistics.failures;
  std::set<std::string>& known = reported_[of];
  if (known.size() > most || !known.insert(what).second)
    return;
  const std::string text =
      known.size() <= most ? what + " (skipped)"
                           : of + ": fails again and again; its failures are counted from here on";
  environment_.context.log.error("cycle " + std::to_string(cycle) + ": " + text);
  if (page_)
    page_->add_failure(text);
}

namespace {

/// A mesh without cells may lack the fields that it will have: there is nothing to do for it yet.
bool is_for_want_of_cells(const commit::CommittedMesh* mesh, const std::exception& e) {
  const auto* error = dynamic_cast<const core::Error*>(&e);
  return error && error->status() == INSITU_ERROR_FIELD && mesh &&
         mesh->mesh().own_view().cell_count() == 0;
}

} // namespace

/// Files are named by cycles: says once that some may be of an earlier execution's name.
void Runner::note_cycle(std::int64_t cycle) {
  if (executed_ && !told_cycles_ && cycle >= lowest_cycle_ && cycle <= highest_cycle_) {
    told_cycles_ = true;
    environment_.context.log.warning(
        "cycle " + std::to_string(cycle) + " follows cycle " + std::to_string(cycle_) +
        ": numbers of cycles come again, and files named by them (images, .vtp, .json, "
        "streamlines, checkpoints) replace those of the execution before");
  }
  lowest_cycle_ = executed_ ? std::min(lowest_cycle_, cycle) : cycle;
  highest_cycle_ = executed_ ? std::max(highest_cycle_, cycle) : cycle;
}

std::string Runner::execute(MeshList meshes, std::int64_t cycle, double time) {
  const std::span<const double> times(times_);
  const Step step{meshes,
                  cycle,
                  time,
                  !executed_,
                  times.empty() ? 0.0 : times.front(),
                  times.empty() ? times : times.subspan(1)};
  std::string failures;
  bool any_due = false;
  const auto failed = [&](const std::string& of, const std::exception& e) {
    const bool memory = dynamic_cast<const std::bad_alloc*>(&e) != nullptr;
    const std::string what = of + ": " + (memory ? "out of memory" : e.what());
    failures += (failures.empty() ? "" : "\n") + what;
    report(what, of, cycle);
  };
  note_cycle(cycle);
  bring_back_earlier(meshes);
  for (const auto& action : actions_) {
    const commit::CommittedMesh* found = nullptr;
    try {
      commit::CommittedMesh& mesh = find_mesh(meshes, action->mesh_name(), environment_.scene_file);
      found = &mesh;
      if (mesh.lies_on_device())
        throw core::Error(INSITU_ERROR_UNSUPPORTED,
                          "mesh '" + mesh.mesh().name() +
                              "' lies in device memory; scenes read host memory");
      const bool due = is_due(*action, mesh, step);
      any_due = any_due || due;
      action->execute(mesh, step, due);
      if (due)
        log_particles(*action, cycle);
    } catch (const std::exception& e) {
      if (!is_for_want_of_cells(found, e))
        failed(std::string(action->kind()) + " '" + action->name() + "'", e);
    }
  }
  structures_.end_cycle(meshes);
  try {
    keep_earlier(meshes);
  } catch (const std::exception& e) { // no memory: pathlines take the next velocity as steady
    for (commit::CommittedMesh* mesh : meshes)
      mesh->release_earlier();
    failed("the earlier step", e);
  }
  try {
    if (page_)
      end_page_cycle(step, any_due);
  } catch (const std::exception& e) {
    failed("page", e);
  }
  descends_ = executed_ && cycle < cycle_;
  executed_ = true;
  cycle_ = cycle;
  times_.insert(times_.begin(), time);
  times_.resize(std::min(times_.size(), std::size_t(advect::most_steps - 1)));
  const core::Timer timer;
  try {
    write_due_checkpoint(meshes);
  } catch (const std::exception& e) {
    failed("checkpoint", e);
  }
  environment_.statistics.output_s += timer.seconds();
  return failures;
}

/// Copies what pathlines will need of this step, and only then.
void Runner::keep_earlier(MeshList meshes) {
  const core::Timer timer;
  for (commit::CommittedMesh* mesh : meshes) {
    std::vector<mesh::KeptField> fields;
    bool with_cells = false;
    for (const auto& action : actions_) {
      if (mesh->lies_on_device())
        continue;
      const Name& of = action->mesh_name();
      const bool here = of.empty() ? mesh == meshes.front() : of.text == mesh->mesh().name();
      for (const mesh::KeptField& need : action->needs_earlier()) {
        if (!here || !mesh->mesh().has_field(need.name))
          continue;
        const auto known = std::find_if(fields.begin(), fields.end(),
                                        [&](const auto& f) { return f.name == need.name; });
        if (known == fields.end())
          fields.push_back(need);
        else
          known->steps = std::max(known->steps, need.steps);
        with_cells = with_cells || action->goes_on_to_other_cells();
      }
    }
    mesh->keep_earlier(fields, with_cells, environment_.context.threads);
  }
  environment_.statistics.advect_s += timer.seconds();
}

/// What became of a tracer's particles.
void Runner::log_particles(const Action& action, std::int64_t cycle) const {
  if (!environment_.context.log.wants(INSITU_LOG_INFO))
    return;
  if (const std::optional<advect::Counts> counts = action.particles())
    environment_.context.log.info("cycle " + std::to_string(cycle) + ": " + action.kind() + " '" +
                                  action.name() + "': " + advect::describe(*counts));
}

void Runner::note_tracers() {
  for (const auto& action : actions_)
    if (const std::optional<advect::Counts> counts = action->particles())
      page_->add_tracer(action->name(), *counts);
}

/// Its seconds are in the page's next entry.
void Runner::end_page_cycle(const Step& step, bool due) {
  const core::Timer timer;
  if (page_->wanted(due)) {
    note_tracers();
    if (!page_->begun())
      page_->add_plan(plan(step.meshes).text());
  }
  page_->end_cycle(step.cycle, step.time, due, timer);
  environment_.statistics.output_s += timer.seconds();
}

/// The last entry: what became of the particles, and what failed at the end.
void Runner::finish_page(const std::string& failures) {
  if (!page_)
    return;
  note_tracers();
  if (!failures.empty())
    page_->add_failure(failures);
  page_->finish();
}

Plan Runner::plan(MeshList meshes) const {
  Plan plan;
  for (const commit::CommittedMesh* mesh : meshes) {
    plan.begin({}, mesh->mesh().name());
    plan_mesh(*mesh, plan);
  }
  for (const auto& action : actions_) {
    const std::string of = std::string(action->kind()) + " '" + action->name() + "'";
    plan.begin(of, action->mesh_name().text);
    try {
      const commit::CommittedMesh& mesh =
          find_mesh(meshes, action->mesh_name(), environment_.scene_file);
      plan.begin(of, mesh.mesh().name());
      action->plan(mesh, plan);
    } catch (const core::Error& e) {
      plan.skip("all of it", e.what());
    }
  }
  return plan;
}

std::string Runner::finish() {
  std::string failures;
  for (const auto& action : actions_) {
    try {
      action->finish();
    } catch (const std::exception& e) {
      failures += std::string(action->kind()) + " '" + action->name() + "': " + e.what() + "\n";
    }
  }
  try {
    table_.finish();
  } catch (const std::exception& e) {
    failures += std::string("the table of frames: ") + e.what() + "\n";
  }
  try {
    finish_page(failures);
  } catch (const std::exception& e) {
    failures += std::string("page: ") + e.what() + "\n";
  }
  return failures;
}

advect::Counts Runner::particle_counts() const {
  advect::Counts sum;
  for (const auto& action : actions_)
    if (const std::optional<advect::Counts> counts = action->particles())
      sum += *counts;
  return sum;
}

} // namespace insitu::scene
