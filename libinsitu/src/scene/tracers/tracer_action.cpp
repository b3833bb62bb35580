#include "scene/tracers/tracer_action.h"

#include <algorithm>
#include <limits>

#include "advect/field/cells_beyond.h"
#include "core/status.h"
#include "core/unsigned_zero.h"
#include "query/proof.h"
#include "scene/probes/resolve_points.h"
#include "scene/run/growing_table.h"
#include "scene/run/lookup.h"
#include "scene/run/own_cell.h"
#include "scene/tracers/tracer_effects.h"
#include "scene/tracers/track_writer.h"

namespace insitu::scene {

TracerAction::TracerAction(const Tracer& tracer, const Environment& environment)
    : tracer_(tracer), environment_(environment) {}

commit::PeriodicAxes TracerAction::periodic_axes() const {
  commit::PeriodicAxes axes{};
  if (tracer_.effects.boundary)
    std::copy(std::begin(tracer_.effects.boundary->periodic),
              std::end(tracer_.effects.boundary->periodic), axes.begin());
  return axes;
}

std::string TracerAction::state_name() const {
  const char* kinds[] = {"streamline", "pathline", "streakline"};
  const bool back =
      tracer_.kind != TracerKind::streamline && tracer_.direction == TracerDirection::backward;
  std::string text = "tracer '" + tracer_.name + "' (" + (back ? "backward " : "") +
                     kinds[int(tracer_.kind)] + " of '" + tracer_.velocity.text + "', to";
  const char* formats[] = {"csv", "vtp", "json", "netcdf"};
  for (const TableFormat format : tracer_.output)
    text += std::string(" ") + formats[int(format)];
  return text + ")";
}

void TracerAction::plan(const commit::CommittedMesh& mesh, MeshList /*meshes*/, Plan& plan) const {
  const mesh::MeshView& view = mesh.mesh().view();
  if (tracer_.attached != Attached::body && mesh.mesh().has_field(tracer_.velocity.text) &&
      mesh.mesh().field(tracer_.velocity.text).has_blanks)
    plan.need("cells in which '" + tracer_.velocity.text + "' has values",
              view.cell_count() + mesh.standing_tree().bytes(),
              "the others are walls to its particles");
  if (tracer_.kind == TracerKind::streamline) {
    find_field(mesh, tracer_.velocity, environment_.scene_file); // it must be there
    for (const mesh::KeptField& of : effect_fields(tracer_.effects, 0))
      find_field(mesh, {of.name, tracer_.line}, environment_.scene_file);
    plan.skip("earlier step of '" + tracer_.velocity.text + "'", "streamlines see one step alone");
    plan_neighbours(mesh, plan);
    return;
  }
  const int steps = advect::steps_of(tracer_.time_interpolation) - 1;
  const auto need = [&](const mesh::KeptField& kept, const char* why) {
    const mesh::FieldView field =
        find_field(mesh, {kept.name, tracer_.line}, environment_.scene_file);
    const std::int64_t items = field.association == INSITU_CELL
                                   ? view.first_cell[view.piece_count]
                                   : view.first_vertex[view.piece_count];
    plan.need((kept.steps == 1 ? "earlier step of '"
                               : std::to_string(kept.steps) + " earlier steps of '") +
                  kept.name + "'",
              kept.steps * items * field.components * std::int64_t(sizeof(double)), why);
  };
  if (has_times())
    for (const Name& name : tracer_.fields)
      need({name.text, steps}, "recorded at times between two steps");
  if (tracer_.attached == Attached::body) {
    plan.skip("velocity", "particles go with the mesh's material");
    return;
  }
  plan_neighbours(mesh, plan);
  need({tracer_.velocity.text, steps}, "particles move between two steps");
  for (const mesh::KeptField& of : effect_fields(tracer_.effects, steps))
    need(of, "an effect blends it between two steps");
  if (mesh.mesh().is_adaptive()) {
    plan.skip("earlier coordinates", "an adaptive mesh does not move its vertices");
    plan.skip("copy of the cells",
              mesh.mesh().reconstruction() == INSITU_DUAL
                  ? "at a regrid the dual itself is kept until particles crossed"
                  : "at a regrid the leaves are kept, 13 bytes each, until particles crossed");
    return;
  }
  plan.need("earlier coordinates", mesh.mesh().earlier_points_bytes(),
            "the mesh may move under the particles");
  if (const std::int64_t bytes = mesh.earlier_cells_bytes(environment_.context.threads))
    plan.need("copy of the cells", bytes, "the cells may become others under the particles");
}

void TracerAction::plan_neighbours(const commit::CommittedMesh& mesh, Plan& plan) const {
  const char* const item = "cells across faces";
  if (mesh.neighbours() || advect::CellsBeyond(mesh.sampler()).lacks_neighbours())
    plan.need(item, mesh.neighbours_bytes(environment_.context.threads),
              "once the tree was asked for one of them a cell: their numbers do not tell");
  else
    plan.skip(item,
              mesh.mesh().is_adaptive() ? "the leaves are found by their levels"
              : query::ProofRule(mesh.mesh().view(), mesh.standing_tree().odd(), {}).for_some()
                  ? "the cells' numbers tell"
                  : "cells fold, or it is not known whether: particles ask the tree");
}

advect::IntegratorSettings TracerAction::integrator() const {
  const IntegratorOptions& from = tracer_.integrator;
  advect::IntegratorSettings to;
  switch (from.method) {
  case IntegrationMethod::euler:
    to.method = advect::Method::euler;
    break;
  case IntegrationMethod::rk4:
    to.method = advect::Method::rk4;
    break;
  case IntegrationMethod::bs32:
    to.method = advect::Method::bs32;
    break;
  case IntegrationMethod::dopri5:
    to.method = advect::Method::dopri5;
    break;
  }
  // Without, a pair follows the kinks at faces by its error control, which costs more.
  to.face_aware = from.face_aware.value_or(advect::is_adaptive(to.method));
  to.step = from.step.value_or(0.0);
  to.tolerance = from.tolerance;
  to.min_step = from.min_step.value_or(0.0);
  to.at_min_step = from.at_min_step;
  to.max_step = from.max_step.value_or(0.0);
  to.max_steps = from.max_steps;
  return to;
}

const std::vector<math::Vec3d>& TracerAction::seeds(const commit::CommittedMesh& mesh) {
  if (!seeds_)
    seeds_ =
        resolve_points(tracer_.seeds, tracer_.frame, mesh, environment_.scene_file).mesh_points;
  return *seeds_;
}

const std::vector<math::Vec3d>& TracerAction::seeds_of_all(const commit::CommittedMesh& mesh) {
  parallel::World& world = environment_.world;
  if (seeds_)
    return *seeds_;
  const std::string text = read_points_for_all(tracer_.seeds, world);
  std::vector<math::Vec3d> seeds; // nobody has them unless all do
  world.agree_after([&] {
    seeds = resolve_points(tracer_.seeds, tracer_.frame, mesh, environment_.scene_file, &text)
                .mesh_points;
  });
  seeds_ = std::move(seeds);
  return *seeds_;
}

std::vector<mesh::FieldView> TracerAction::fields(const commit::CommittedMesh& mesh) const {
  std::vector<mesh::FieldView> out;
  for (const Name& name : tracer_.fields)
    out.push_back(find_field(mesh, name, environment_.scene_file));
  return out;
}

std::vector<std::string>
TracerAction::field_columns(std::span<const mesh::FieldView> fields) const {
  std::vector<std::string> columns;
  for (const mesh::FieldView& f : fields)
    for (std::string& c : component_names(f))
      columns.push_back(std::move(c));
  return columns;
}

std::vector<double> TracerAction::sample(const commit::CommittedMesh& mesh,
                                         std::span<const mesh::FieldView> fields,
                                         std::span<const math::Vec3d> points,
                                         std::span<const std::int64_t> cells) const {
  std::vector<query::Location> places(points.size());
  const query::Sampler sampler = mesh.sampler();
  query::LocateOptions options;
  options.accuracy = tracer_.accuracy;
  if (!fields.empty())
    environment_.context.threads.parallel_for(
        std::int64_t(points.size()), 512, [&](std::int64_t begin, std::int64_t end) {
          for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
            places[i] = sampler.locate(points[i], cells[i], options);
        });
  return values_at(mesh, fields, places);
}

std::vector<double> TracerAction::values_at(const commit::CommittedMesh& mesh,
                                            std::span<const mesh::FieldView> fields,
                                            std::span<const query::Location> places) const {
  std::size_t width = 0;
  for (const mesh::FieldView& f : fields)
    width += std::size_t(f.components);
  std::vector<double> values(places.size() * width, std::numeric_limits<double>::quiet_NaN());
  if (width == 0)
    return values;
  const query::Sampler sampler = mesh.sampler();
  environment_.context.threads.parallel_for(
      std::int64_t(places.size()), 512, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
          if (places[i])
            sampler.interpolate(fields, places[i], values.data() + i * width);
      });
  return values;
}

TrackRow track_row(std::int64_t particle, double time, const math::Vec3d& position, OwnCell cell,
                   insitu_ending ending) {
  const auto plain = core::unsigned_zero;
  return {particle,
          plain(time),
          {plain(position.x), plain(position.y), plain(position.z)},
          cell,
          ending};
}

std::unique_ptr<TrackWriter> make_track_writer(TableFormat format, const Tracer& tracer,
                                               const Environment& environment) {
  switch (format) {
  case TableFormat::csv:
    return make_track_csv(tracer, environment);
  case TableFormat::vtp:
    return make_track_vtp(tracer, environment);
  case TableFormat::netcdf:
    return make_track_netcdf(tracer, environment);
  case TableFormat::json:
    break;
  }
  throw core::Error(INSITU_ERROR_INTERNAL,
                    "tracer '" + tracer.name + "': no writer for this format");
}

} // namespace insitu::scene
