#include "scene/frames/frame_on_all.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "render/processes/whole_facts.h"
#include "scene/frames/chart_copies.h"
#include "scene/run/lookup.h"
#include "scene/run/own_cell.h"

namespace insitu::scene {

FieldsByName frame_fields(const FrameLayer& layer, const commit::CommittedMesh& mesh,
                          const Environment& environment) {
  std::vector<const Name*> named;
  for (const ColorBy* by : colorings_of(layer))
    named.push_back(&by->field);
  for (const Isosurface& surface : layer.isosurfaces)
    named.push_back(&surface.field);
  std::vector<Name> names;
  for (const Name* name : named)
    names.push_back(*name);
  std::vector<mesh::FieldView> views =
      find_fields(mesh, names, environment.scene_file, environment.world);
  FieldsByName fields;
  for (std::size_t i = 0; i < names.size(); ++i) {
    views[i].name = named[i]->text.c_str(); // which the frame keeps
    fields.emplace(named[i]->text, views[i]);
  }
  return fields;
}

CellsInPlace find_cells_in_place(const commit::CommittedMesh& mesh, parallel::World& world) {
  std::int64_t found[] = {has_chart_copies(mesh),
                          mesh.mesh().has_stand_in() && mesh.mesh().is_adaptive()};
  world.reduce(std::span(found), parallel::Reduction::greatest);
  return {found[0] != 0, found[1] != 0};
}

void know_whole_facts(commit::CommittedMesh& mesh, const Environment& environment) {
  parallel::World& world = environment.world;
  std::int64_t is_old = !mesh.knows_whole_facts();
  world.reduce(std::span(&is_old, 1), parallel::Reduction::greatest);
  if (!is_old)
    return;
  mesh::MeshFacts mine;
  world.agree_after([&] {
    mine = mesh::find_facts(mesh.mesh().view(), &environment.context.threads);
    if (mesh.stand_in() && mesh.stand_in()->chart())
      mesh.stand_in()->chart()->cut(mine.bounds);
  });
  mesh.set_whole_facts(render::whole_facts(world, mine));
}

void complete_averages(const LayerDecisions& decisions, const commit::CommittedMesh& mesh,
                       render::Structures& structures, parallel::World& world) {
  if (!mesh.halo())
    return;
  for (const IsosurfaceDecisions& surface : decisions.isosurfaces) {
    if (!surface.averages || !surface.gradients)
      continue;
    std::span<double> values;
    world.agree_after([&] { values = structures.average_values(surface.field); });
    refresh_vertex_values(mesh, world, values);
  }
}

RangesByColor frame_ranges(const LayerDecisions& decisions, render::Structures& structures,
                           parallel::World& world) {
  std::vector<const Coloring*> asked;
  const auto ask = [&](const std::optional<Coloring>& coloring) {
    if (coloring && coloring->pass)
      asked.push_back(&*coloring);
  };
  if (decisions.volume && decisions.volume->coloring.pass)
    asked.push_back(&decisions.volume->coloring);
  for (const IsosurfaceDecisions& surface : decisions.isosurfaces)
    ask(surface.coloring);
  ask(decisions.boundary);
  std::vector<double> low(asked.size()), high(asked.size());
  world.agree_after([&] {
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const render::ScalarRange range = structures.scalar_range(asked[i]->field);
      low[i] = range.low;
      high[i] = range.high;
    }
  });
  world.reduce(low, parallel::Reduction::least);
  world.reduce(high, parallel::Reduction::greatest);
  RangesByColor ranges;
  for (std::size_t i = 0; i < asked.size(); ++i)
    ranges[asked[i]->by] = {low[i], high[i]};
  return ranges;
}

FrameKeys::FrameKeys(const commit::CommittedMesh& mesh, parallel::World& world)
    : mesh_(&mesh), by_ids_(name_cells(mesh.mesh(), world).global) {
  const std::int64_t own = mesh.mesh().own_view().own_cell_count();
  std::vector<std::int64_t> cells(std::size_t(world.size()));
  cells[std::size_t(world.rank())] = own;
  world.reduce(cells, parallel::Reduction::sum);
  before_ = std::accumulate(cells.begin(), cells.begin() + world.rank(), std::int64_t(0));
  end_ = std::accumulate(cells.begin(), cells.end(), std::int64_t(0));
  if (!by_ids_)
    return;
  std::int64_t last = -1;
  for (std::int64_t flat = 0; mesh.stand_in() && flat < own; ++flat) // ghosts' do not ascend
    last = std::max(last, mesh.mesh().global_id(INSITU_CELL, flat));
  world.reduce(std::span(&last, 1), parallel::Reduction::greatest);
  end_ = last >= 0 ? last + 1 : std::numeric_limits<std::int64_t>::max();
}

std::int64_t FrameKeys::key(std::int64_t flat) const {
  if (mesh_->mesh().has_stand_in())
    if (const auto made = mesh_->stand_in()->made_cell(flat))
      return made->number;
  const commit::StandIn::Place at =
      mesh_->stand_in() ? mesh_->stand_in()->place(flat) : commit::StandIn::Place{flat};
  const std::int64_t own = own_key(at.own);
  switch (at.chart) {
  case 0:
    return own;
  case 1:
    return end_ + 2 * own + at.copy;
  default:
    return end_ * (1 + at.chart) + own;
  }
}

std::int64_t FrameKeys::solvers_at(const math::Vec3d& place) const {
  const query::Location own = mesh_->own_here({0, {}}, place); // whatever cell is drawn there
  return own ? own_key(own.cell) : -1;
}

std::int64_t FrameKeys::solvers(std::int64_t key) const {
  if (key < end_)
    return key;
  key -= end_;
  return key < 2 * end_ ? key / 2 : (key - 2 * end_) % end_;
}

} // namespace insitu::scene
