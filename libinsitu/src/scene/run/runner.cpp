#include "scene/run/runner.h"

#include <algorithm>
#include <new>

#include "core/status.h"
#include "core/timer.h"
#include "output/hdf/hdf_writer.h"
#include "scene/expression/reduce.h"
#include "scene/frames/frame_action.h"
#include "scene/probes/probe_action.h"
#include "scene/run/lookup.h"
#include "scene/run/mesh_plan.h"
#include "scene/tracers/tracer_action.h"

namespace insitu::scene {

Runner::Runner(const SceneDescription& scene, const std::string& given, core::Context& context,
               parallel::World& world, Statistics& statistics)
    : with_page_(scene.page), structures_(context), reductions_(world, context.threads),
      table_(scene.frames, given.empty() ? scene.output : given),
      environment_{context,     world,  statistics, structures_,
                   reductions_, table_, scene.file, given.empty() ? scene.output : given},
      locator_(scene.locator), seam_tolerance_(scene.seam_tolerance),
      words_(scene.words.empty() ? nullptr : std::make_shared<const std::string>(scene.words)),
      checkpoint_(scene.checkpoint), record_(scene.record), scene_text_(scene.text),
      records_(context, world, statistics) {
  if (locator_.choice.backend || locator_.choice.method) { // what can never be had is said at once
    try {
      query::pick_locator(locator_.choice, false);
    } catch (const core::Error& e) {
      throw core::Error(e.status(),
                        scene.file + ":" + std::to_string(locator_.line) + ": " + e.what());
    }
  }
  if (record_.every)
    output::HdfWriter::require_hdf5(scene.file + ": record");
  if (with_page_ && world.is_root()) {
    page_ = std::make_unique<PageRecord>(scene, environment_.output, context, statistics);
    environment_.page = page_.get();
  }
  for (const Probe& p : scene.probes) {
    auto probe = std::make_unique<ProbeAction>(p, environment_);
    probes_.push_back(probe.get());
    actions_.push_back(std::move(probe));
  }
  for (const Tracer& t : scene.tracers)
    actions_.push_back(make_tracer_action(t, environment_));
  for (const Frame& f : scene.frames)
    actions_.push_back(make_frame_action(f, environment_));
}

Runner::~Runner() = default;

void Runner::keep_answers(bool keep) {
  for (ProbeAction* probe : probes_)
    probe->keep_answers(keep);
}

bool Runner::is_due(const Action& action, const commit::CommittedMesh& mesh,
                    const Step& step) const {
  const core::Timer timer;
  const bool due = action.trigger().due(
      step.cycle, step.time, [&](Reduction reduction, const std::string& field) {
        return environment_.reductions(mesh, {field, action.trigger().line},
                                       environment_.scene_file, reduction);
      });
  environment_.statistics.query_s += timer.seconds();
  return due;
}

/// Counts a failure, and logs it at the root unless it was logged before. Texts that carry the
/// cycle or a number differ each time, so that of one action the first few are logged.
void Runner::report(const std::string& what, const std::string& of, std::int64_t cycle) {
  constexpr std::size_t most = 8;
  ++environment_.statistics.failures;
  if (!environment_.world.is_root())
    return;
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

/// A mesh without cells may lack the fields that it will have: there is nothing to do for it yet.
/// Collective.
bool Runner::is_for_want_of_cells(const Action& action, const core::Error& error,
                                  MeshList meshes) const {
  if (error.status() != INSITU_ERROR_FIELD)
    return false;
  std::int64_t cells = 1;
  for (const commit::CommittedMesh* mesh : meshes)
    if (action.is_of(*mesh, meshes)) {
      cells = cells_of_all(mesh->mesh(), environment_.world);
      break;
    }
  return cells == 0;
}

/// Files are named by cycles: says once that some may be of an earlier execution's name.
void Runner::note_cycle(std::int64_t cycle) {
  if (environment_.world.is_root() && executed_ && !told_cycles_ && cycle >= lowest_cycle_ &&
      cycle <= highest_cycle_) {
    told_cycles_ = true;
    environment_.context.log.warning(
        "cycle " + std::to_string(cycle) + " follows cycle " + std::to_string(cycle_) +
        ": numbers of cycles come again, and files named by them (images, .vtp, .json, "
        "streamlines, checkpoints) replace those of the execution before");
  }
  lowest_cycle_ = executed_ ? std::min(lowest_cycle_, cycle) : cycle;
  highest_cycle_ = executed_ ? std::max(highest_cycle_, cycle) : cycle;
}

void Runner::failed(std::string& failures, const std::string& of, const core::Error& error,
                    std::int64_t cycle) {
  const std::string what = of + ": " + error.what();
  failures += (failures.empty() ? "" : "\n") + what;
  report(what, of, cycle);
}

/// Says once that an action does nothing at steps that are held.
void Runner::leave_out(const Action& action) {
  const std::string of = std::string(action.kind()) + " '" + action.name() + "'";
  if (environment_.world.is_root() && left_out_.insert(of).second)
    environment_.context.log.warning(
        of + " goes on with live steps alone, and does nothing at steps that are held");
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

/// Its seconds are in the page's next entry. Collective.
void Runner::end_page_cycle(const Step& step, Attempt& attempt) {
  if (!with_page_)
    return;
  const core::Timer timer;
  parallel::World& world = environment_.world;
  std::int64_t has_entry = 0;
  world.agree_after([&] {
    if (!page_)
      return;
    page_->take_warnings();
    has_entry = page_->wanted(attempt.any_due);
  });
  world.reduce(std::span(&has_entry, 1), parallel::Reduction::greatest);
  if (!has_entry)
    return;
  const SecondsOfAll seconds = seconds_.since_last(environment_.statistics, world);
  attempt.has_entry = true;
  world.agree_after([&] {
    if (!page_)
      return;
    note_tracers();
    if (!page_->begun())
      page_->add_plan(plan(step.meshes).text());
    page_->end_cycle(step.cycle, step.time, seconds, timer);
  });
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
      action->plan(mesh, meshes, plan);
    } catch (const core::Error& e) {
      plan.skip("all of it", e.what());
    }
  }
  return plan;
}

std::string Runner::meet_end() {
  std::string failures;
  for (const auto& action : actions_) {
    try {
      action->meet_end();
    } catch (const parallel::AgreedError& e) {
      failures += std::string(action->kind()) + " '" + action->name() + "': " + e.what() + "\n";
    }
  }
  return failures;
}

void Runner::write_record(const std::string& path, MeshList meshes, std::int64_t cycle,
                          double time) {
  records_.write(path, {cycle, time, environment_.scene_file, scene_text_}, meshes, descends_);
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
    if (const std::optional<advect::Counts> counts = action->particles_here())
      sum += *counts;
  return sum;
}

} // namespace insitu::scene
