#include "api/session.h"

#include <algorithm>

#include "core/caller_struct.h"
#include "core/simd_target.h"
#include "core/timer.h"
#include "scene/frames/preview.h"
#include "scene/parse/parse.h"

namespace insitu::api {

using core::Error;

namespace {

static_assert(query::reason_count == INSITU_REASON_COUNT &&
              int(query::Reason::outside) == INSITU_REASON_OUTSIDE &&
              int(query::Reason::certified) == INSITU_REASON_CERTIFIED &&
              int(query::Reason::exact) == INSITU_REASON_EXACT &&
              int(query::Reason::on_face) == INSITU_REASON_ON_FACE &&
              int(query::Reason::on_edge) == INSITU_REASON_ON_EDGE &&
              int(query::Reason::on_vertex) == INSITU_REASON_ON_VERTEX);
static_assert(int(accel::Method::bvh) + 1 == INSITU_METHOD_BVH &&
              int(accel::Method::shared_bilinear_faces) + 1 ==
                  INSITU_METHOD_SHARED_BILINEAR_FACES &&
              accel::method_count == INSITU_METHOD_SHARED_BILINEAR_FACES &&
              int(accel::Backend::optix) + 1 == INSITU_BACKEND_OPTIX);

} // namespace

Session::Session(const insitu_session_options& options, std::shared_ptr<parallel::World> world)
    : processes_(std::move(world)),
      context_(processes_.threads(options), {options.log_level, options.log, options.log_user}),
      strict_(options.strict != 0), default_scene_(options.default_scene != 0),
      preview_(options.preview != 0), output_(options.output ? options.output : ""),
      query_points_(context_.memory, INSITU_MEMORY_QUERY), held_(context_.memory) {}

void Session::open(const insitu_session_options& options) {
  read_scene(options);
  processes_.world().agree_after([&] {
    if (core::simd_target().asked)
      context_.log.info("SIMD target " + core::simd_target().name);
    if (preview_ && !output_.empty())
      output_ = scene::preview_folder(output_);
    if (!scene_)
      return;
    for (const std::string& warning : scene_->warnings)
      if (processes_.world().is_root())
        context_.log.warning(warning);
    held_.set_most(scene_->held_steps);
    make_runner(*scene_);
  });
}

/// The root reads a scene's file for all processes; a text is that of each of them.
void Session::read_scene(const insitu_session_options& options) {
  parallel::World& world = processes_.world();
  std::string text;
  world.agree_after([&] {
    if (options.scene_text)
      scene_ = as_asked(scene::parse_scene_text(options.scene_text, "scene"));
  });
  processes_.agree_on_session(options, checked_);
  if (!options.scene)
    return;
  world.agree_after([&] {
    if (world.is_root())
      text = scene::read_scene_file(options.scene);
  });
  text = world.broadcast(text);
  world.agree_after([&] { scene_ = as_asked(scene::parse_scene_of_file(text, options.scene)); });
}

scene::SceneDescription Session::as_asked(scene::SceneDescription scene) const {
  return preview_ ? scene::preview_of(std::move(scene)) : scene;
}

void Session::make_runner(const scene::SceneDescription& scene) {
  auto runner =
      std::make_unique<scene::Runner>(scene, output_, context_, processes_.world(), statistics_);
  if (processes_.world().is_root())
    locks_.take(scene, runner->output());
  runner_ = std::move(runner);
  runner_->keep_answers(keeps_answers_);
}

Session::~Session() = default;

SessionMesh& Session::mesh(const std::string& name) {
  if (name.empty())
    throw Error(INSITU_ERROR_ARGUMENT, "a mesh's name is empty");
  for (const auto& m : meshes_)
    if (m->mesh.mesh().name() == name)
      return *m;
  SessionMesh& made = *meshes_.emplace_back(std::make_unique<SessionMesh>(name, context_.memory));
  made.mesh.mesh().set_is_part(processes_.world().size() > 1);
  return made;
}

void Session::choose_locator(SessionMesh& to, const insitu_locator* given) {
  query::LocatorChoice choice;
  if (given) {
    const insitu_locator locator = core::from_caller(given, "locator");
    if (locator.method < INSITU_METHOD_AUTO || locator.method > INSITU_METHOD_SHARED_BILINEAR_FACES)
      throw Error(INSITU_ERROR_ARGUMENT,
                  "locator: unknown method " + std::to_string(int(locator.method)));
    if (locator.backend < INSITU_BACKEND_AUTO || locator.backend > INSITU_BACKEND_OPTIX)
      throw Error(INSITU_ERROR_ARGUMENT,
                  "locator: unknown backend " + std::to_string(int(locator.backend)));
    if (locator.method != INSITU_METHOD_AUTO)
      choice.method = accel::Method(locator.method - INSITU_METHOD_BVH);
    if (locator.backend != INSITU_BACKEND_AUTO)
      choice.backend = accel::Backend(locator.backend - INSITU_BACKEND_CPU);
  } else if (runner_) {
    choice = runner_->locator().choice;
  }
  query::pick_locator(choice, to.mesh.mesh().lies_on_device()); // throws before anything is changed
  to.mesh.set_locator(choice);
  to.locator_chosen = given != nullptr;
}

void Session::note_field(SessionMesh& mesh, std::int32_t piece, const std::string& field) {
  if (checked_)
    mesh.given.note_field(mesh.mesh.mesh(), piece, field);
}

void Session::note_changed(SessionMesh& mesh, std::uint32_t what) {
  mesh.mesh.mesh().set_changed(what);
  if (checked_)
    mesh.given.told(what);
}

insitu_commit_report Session::commit(SessionMesh& to) {
  commit::CommittedMesh& mesh = to.mesh;
  mesh.expect_no_refusal(); // before any array is read
  const std::uint32_t said = mesh.mesh().pending();
  if (checked_)
    to.given.check(mesh.mesh(), context_.log);
  if (checks(to))
    to.watch.expect_unchanged(said, context_.threads);
  if (runner_) {
    mesh.set_builder(runner_->locator().builder);
    mesh.seam_tolerance = runner_->seam_tolerance();
    mesh.lent_fields_named_in = runner_->words();
    if (!to.locator_chosen)
      mesh.set_locator(runner_->locator().choice);
  }
  const insitu_commit_report report = [&] {
    try {
      return mesh.commit(context_.threads, context_.log, context_.memory, strict_);
    } catch (const Error& e) { // the tree knows pieces and cells, not whose
      const std::string what = e.what(), name = "mesh '" + mesh.mesh().name() + "'";
      if (what.find(name) != std::string::npos)
        throw;
      throw Error(e.status(), name + ", " + what);
    }
  }();
  if (checks(to) && (said & (INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_TOPOLOGY)))
    to.watch.remember(mesh.mesh(), context_.threads);
  statistics_.commit_s += report.seconds;
  switch (report.action) {
  case INSITU_KEEP:
    ++statistics_.keeps;
    break;
  case INSITU_REFIT:
    ++statistics_.refits;
    break;
  case INSITU_REBUILD:
    ++statistics_.rebuilds;
    break;
  }
  return report;
}

void Session::make_default_runner(const std::vector<commit::CommittedMesh*>& meshes) {
  const auto [field, mesh] = processes_.scalar_of_all(meshes);
  if (field.empty())
    throw Error(INSITU_ERROR_FIELD, "the default scene needs a scalar field, and no mesh has one");
  make_runner(as_asked(scene::default_scene(field, mesh)));
}

std::string Session::try_default_runner(const std::vector<commit::CommittedMesh*>& meshes) {
  try {
    processes_.world().agree_after([&] { make_default_runner(meshes); });
    return {};
  } catch (const Error& e) {
    ++statistics_.failures;
    if (default_failure_ != e.what()) {
      default_failure_ = e.what();
      if (processes_.world().is_root())
        context_.log.error(default_failure_);
    }
    return e.what();
  }
}

std::vector<commit::CommittedMesh*> Session::commit_all() {
  std::vector<commit::CommittedMesh*> meshes;
  for (const auto& m : meshes_) {
    commit(*m);
    meshes.push_back(&m->mesh);
  }
  return meshes;
}

/// Begins a collective call.
void Session::meet(const char* call) {
  processes_.world().check_usable();
  if (checked_)
    processes_.wait_for_all(call);
}

std::vector<commit::CommittedMesh*> Session::commit_on_all() {
  parallel::World& world = processes_.world();
  std::vector<commit::CommittedMesh*> meshes;
  world.agree_after([&] { meshes = commit_all(); });
  const std::vector<std::string> names = processes_.agree_on_meshes(
      meshes, [&](const std::string& name) -> commit::CommittedMesh& { return mesh(name).mesh; });
  if (world.size() == 1)
    return meshes;
  world.agree_after([&] {
    std::sort(meshes_.begin(), meshes_.end(), [&](const auto& a, const auto& b) {
      return std::find(names.begin(), names.end(), a->mesh.mesh().name()) <
             std::find(names.begin(), names.end(), b->mesh.mesh().name());
    });
    meshes.clear(); // those that are empty here, or whose frame is another now, are committed too
    for (const auto& m : meshes_) {
      if (!m->mesh.committed())
        commit(*m);
      meshes.push_back(&m->mesh);
    }
  });
  return meshes;
}

const std::string& Session::plan() {
  meet("plan");
  const std::vector<commit::CommittedMesh*> meshes = commit_on_all();
  processes_.world().agree_after([&] {
    if (!runner_ && default_scene_)
      make_default_runner(meshes);
    plan_ = runner_ ? runner_->plan(meshes).text() : std::string();
  });
  return plan_;
}

std::string Session::execute(std::int64_t cycle, double time) {
  meet("execute");
  parallel::World& world = processes_.world();
  const scene::WorkTimer working(statistics_, world);
  world.agree_after([&] {
    if (!(time - time == 0.0))
      throw Error(INSITU_ERROR_ARGUMENT, "time: not finite");
    if (cycle == INSITU_LIVE)
      throw Error(INSITU_ERROR_ARGUMENT, "cycle: INSITU_LIVE, which is no cycle's number");
    locks_.take_missing();
  });
  processes_.agree_on_time(cycle, time);
  return shown_ ? execute_shown(cycle, time) : execute_live(cycle, time);
}

std::string Session::execute_live(std::int64_t cycle, double time) {
  const std::vector<commit::CommittedMesh*> meshes = commit_on_all();
  ++statistics_.executions;
  cycle_ = cycle;
  time_ = time;
  std::string failures = run_scene(meshes, cycle, time);
  if (const std::string failure = hold_step(meshes); !failure.empty()) {
    failures += (failures.empty() ? "" : "\n") + failure;
    if (runner_)
      runner_->fail_step();
  }
  return failures;
}

/// Returns what failed.
std::string Session::run_scene(const std::vector<commit::CommittedMesh*>& meshes,
                               std::int64_t cycle, double time) {
  if (!runner_ && default_scene_) {
    std::int64_t cells = 0;
    for (const commit::CommittedMesh* const m : meshes)
      cells += m->mesh().own_view().own_cell_count();
    processes_.world().reduce(std::span(&cells, 1), parallel::Reduction::sum);
    if (cells > 0 || meshes.empty())
      if (std::string failure = try_default_runner(meshes); !failure.empty())
        return failure;
  }
  if (held_.most() > 0)
    processes_.world().agree_after([&] { keep_structures(); });
  return runner_ ? runner_->execute(meshes, cycle, time) : std::string();
}

std::string Session::finish() {
  std::optional<Error> unmet; // files are closed, whatever MPI does
  std::string failures;
  try {
    meet("close");
    if (runner_)
      failures = runner_->meet_end();
  } catch (const Error& e) {
    unmet = e;
  }
  if (runner_)
    failures += runner_->finish();
  locks_.release();
  if (unmet)
    throw *unmet; // NOLINT: as it was
  processes_.world().agree_after([&] {
    if (!failures.empty())
      throw Error(INSITU_ERROR_FILE, failures);
  });
  return failures;
}

insitu_report Session::report() const {
  insitu_report r = insitu_report_default();
  static_assert(int(INSITU_MEMORY_COUNT) <= INSITU_MEMORY_ROOM &&
                int(INSITU_END_COUNT) <= INSITU_END_ROOM &&
                int(INSITU_REASON_COUNT) <= INSITU_REASON_ROOM);
  r.purposes = INSITU_MEMORY_COUNT;
  r.endings = INSITU_END_COUNT;
  r.reasons = INSITU_REASON_COUNT;
  const scene::Statistics& s = statistics_;
  r.executions = s.executions;
  r.commit_s = s.commit_s;
  r.query_s = s.query_s;
  r.advect_s = s.advect_s;
  r.render_s = s.render_s;
  r.output_s = s.output_s;
  r.keeps = s.keeps;
  r.refits = s.refits;
  r.rebuilds = s.rebuilds + held_.builds();
  for (const auto& m : meshes_)
    r.bytes_borrowed += m->mesh.mesh().bytes_borrowed();
  r.bytes_held = context_.memory.current();
  r.bytes_peak = context_.memory.peak();
  for (int p = 0; p < INSITU_MEMORY_COUNT; ++p)
    r.bytes_by_purpose[p] = context_.memory.current(insitu_purpose(p));
  r.points_located = s.points_located;
  r.points_outside = s.points_outside;
  if (runner_) {
    const advect::Counts counts = runner_->particle_counts();
    r.particles_seeded = counts.seeded;
    for (std::size_t e = 0; e < counts.by_ending.size(); ++e)
      r.particles[e] = counts.by_ending[e];
    const render::Structures::Seconds seconds = runner_->structure_seconds();
    r.ranges_s = seconds.value_ranges + seconds.macrocells + seconds.primitive_ranges;
    r.classify_s = seconds.majorants + seconds.culled;
  }
  r.frames = s.frames;
  r.probe_rows = s.probe_rows;
  r.files = s.files;
  r.failures = s.failures;
  const auto located = held_.located();
  std::ranges::copy(located, r.located_by_reason);
  std::vector<const commit::CommittedMesh*> all = held_.meshes();
  for (const auto& m : meshes_) {
    const auto totals = m->mesh.locate_counts().totals();
    for (std::size_t reason = 0; reason < totals.size(); ++reason)
      r.located_by_reason[reason] += totals[reason];
    all.push_back(&m->mesh);
  }
  for (const commit::CommittedMesh* const m : all)
    r.halo_cells += m->halo() ? m->halo()->cell_count() : 0;
  const parallel::Traffic& sent = processes_.world().traffic();
  r.messages_sent = sent.messages;
  r.bytes_sent = sent.bytes + sent.collective_bytes;
  return r;
}

} // namespace insitu::api
