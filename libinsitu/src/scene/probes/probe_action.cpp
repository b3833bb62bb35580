#include "scene/probes/probe_action.h"

#include <algorithm>
#include <limits>

#include "core/timer.h"
#include "scene/run/lookup.h"

namespace insitu::scene {

ProbeAction::ProbeAction(const Probe& probe, const Environment& environment)
    : probe_(probe), environment_(environment),
      attached_(environment.world, environment.context.threads), tables_(probe, environment) {}

void ProbeAction::plan(const commit::CommittedMesh& mesh, MeshList /*meshes*/, Plan& plan) const {
  std::string fields;
  for (const Name& name : probe_.fields)
    fields += (fields.empty() ? "'" : ", '") + name.text + "'";
  for (const Name& name : probe_.fields)
    find_field(mesh, name, environment_.scene_file);
  plan.need("point queries", -1, fields.empty() ? "of all fields" : "of " + fields);
}

std::string ProbeAction::state_name() const {
  return moves() ? "probe '" + probe_.name + "' (attached: body)" : "";
}

void ProbeAction::meet_checkpoint(const commit::CommittedMesh* mesh) {
  if (moves() && points_)
    kept_ = attached_.gather(mesh, points_->mesh_points);
}

/// Names with the points: those of a file are not read again after a restart.
void ProbeAction::keep(core::Archive& archive) {
  if (!moves())
    return;
  bool placed = points_.has_value();
  archive.value("placed", placed);
  if (!placed)
    return;
  if (!points_)
    points_.emplace();
  archive.array("points", points_->mesh_points);
  archive.array("names", points_->names);
  archive.array("cells", kept_.cells);
  archive.array("parametric coordinates", kept_.parametric);
  archive.array("names of cells", kept_.names);
  if (archive.restores())
    attached_.restore(std::move(kept_));
  kept_ = {};
}

/// The root reads a file of points for all processes.
void ProbeAction::resolve(const commit::CommittedMesh& mesh) {
  parallel::World& world = environment_.world;
  const std::string text = read_points_for_all(probe_.points, world);
  std::optional<ScenePoints> points; // nobody has them unless all do
  world.agree_after([&] {
    points = resolve_points(probe_.points, probe_.frame, mesh, environment_.scene_file, &text);
  });
  points_ = std::move(points);
}

/// All of the first time: a table keeps its columns. Returns false if the fields that the mesh will
/// have are not known yet.
bool ProbeAction::name_fields(const commit::CommittedMesh& mesh) {
  if (!probe_.fields.empty())
    return true;
  const std::vector<std::string> names = field_names_of_all(mesh, environment_.world);
  if (names.empty() && cells_of_all(mesh.mesh(), environment_.world) == 0)
    return false;
  std::vector<Name> fields; // nobody has them unless all do
  environment_.world.agree_after([&] {
    for (const std::string& name : names)
      fields.push_back({name, probe_.line});
  });
  probe_.fields = std::move(fields);
  return true;
}

void ProbeAction::execute(commit::CommittedMesh& mesh, const Step& step, bool due) {
  if (!due && !moves())
    return;
  const core::Timer timer;
  parallel::World& world = environment_.world;
  Statistics& s = environment_.statistics;
  mesh.update_chart(world, environment_.context.threads, environment_.context.log);
  if (!points_)
    resolve(mesh);
  const CellNames names = name_cells(mesh.mesh(), world);
  query::LocateOptions options;
  options.accuracy = probe_.accuracy;
  followed_ = note_.again(step) && followed_;
  if (moves() && !followed_)
    attached_.follow(mesh, options, names.global, points_->mesh_points);
  followed_ = moves();
  if (!due || !name_fields(mesh)) {
    s.query_s += timer.seconds();
    return;
  }
  const std::vector<mesh::FieldView> fields =
      find_fields(mesh, probe_.fields, environment_.scene_file, world);
  std::optional<double> farthest;
  if (probe_.outside == INSITU_OUTSIDE_NEAREST)
    farthest = probe_.greatest_distance > 0.0 ? probe_.greatest_distance
                                              : std::numeric_limits<double>::infinity();
  const ProbeAnswers answers =
      answer_points({mesh, fields, options, names.global, moves() ? &attached_ : nullptr, farthest},
                    points_->mesh_points, world, environment_.context.threads);
  s.points_located += std::int64_t(answers.cells.size());
  s.points_outside += std::count_if(answers.cells.begin(), answers.cells.end(),
                                    [](const OwnCell& own) { return own.flat < 0; });
  s.query_s += timer.seconds();
  if (keeps_answers_)
    share(answers, step);
  world.agree_after([&] {
    if (world.is_root())
      write(mesh, step, answers, names);
  });
}

void ProbeAction::keep_answers(bool keep) {
  keeps_answers_ = keep;
  if (!keep)
    answers_.reset();
}

/// The root, which has the answers of all, tells all processes. Collective.
void ProbeAction::share(const ProbeAnswers& answers, const Step& step) {
  parallel::World& world = environment_.world;
  KeptAnswers now;
  world.agree_after([&] {
    now.cycle = step.cycle;
    now.time = step.time;
    now.columns = answers.columns;
    for (const std::string& column : now.columns)
      now.column_names.push_back(column.c_str());
    now.points = points_->mesh_points;
    now.inside.resize(now.points.size());
    now.values.resize(now.points.size() * now.columns.size());
    if (!world.is_root())
      return;
    now.values = answers.values;
    for (std::size_t i = 0; i < now.points.size(); ++i)
      now.inside[i] = answers.found(i);
  });
  if (moves()) // the root alone knows where all of them are
    world.broadcast(std::as_writable_bytes(std::span(now.points)));
  world.broadcast(std::as_writable_bytes(std::span(now.inside)));
  world.broadcast(std::as_writable_bytes(std::span(now.values)));
  answers_ = std::move(now);
}

void ProbeAction::write(const commit::CommittedMesh& mesh, const Step& step,
                        const ProbeAnswers& answers, const CellNames& names) {
  const core::Timer timer;
  if (environment_.page)
    environment_.page->add_probe(probe_.name, answers.columns, points_->mesh_points, points_->names,
                                 answers.values);
  tables_.write(mesh, step, *points_, answers, names);
  environment_.statistics.output_s += timer.seconds();
}

} // namespace insitu::scene
