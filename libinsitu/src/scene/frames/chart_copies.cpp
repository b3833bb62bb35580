#include "scene/frames/chart_copies.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace insitu::scene {

namespace {

/// The place of a piece's first cell; of a piece without cells that of the solver's.
std::int32_t chart_of(const commit::CommittedMesh& mesh, std::int32_t piece) {
  const mesh::MeshView& view = mesh.mesh().view();
  return view.pieces[piece].cell_count > 0 ? mesh.stand_in()->place(view.first_cell[piece]).chart
                                           : 0;
}

} // namespace

bool has_chart_copies(const commit::CommittedMesh& mesh) {
  return mesh.mesh().has_stand_in() && mesh.stand_in()->chart();
}

render::ChartCopies find_chart_copies(const commit::CommittedMesh& mesh,
                                      const core::Threads& threads) {
  const mesh::MeshView& view = mesh.mesh().view();
  const mesh::MeshView& own = mesh.mesh().own_view();
  const commit::StandIn& stand_in = *mesh.stand_in();
  render::ChartCopies found;
  found.turn = stand_in.chart()->units.turn();
  // The solver's vertices that are one with others, and the first of those that they are one with.
  std::vector<std::pair<std::int64_t, std::int64_t>> first_of;
  if (own.join_pieces && own.piece_count > 1) {
    const mesh::JoinedVertices joined = mesh::join_pieces(own, threads);
    for (std::size_t g = 0, at = 0; g < joined.end.size(); ++g)
      for (const std::size_t begin = at; at < std::size_t(joined.end[g]); ++at)
        first_of.emplace_back(joined.flat[at], joined.flat[begin]);
  }
  std::vector<std::int64_t> copied; // vertices of the solver's
  for (std::int32_t p = 0; p < view.piece_count; ++p) {
    if (chart_of(mesh, p) == 0)
      continue;
    for (std::int64_t v = view.first_vertex[p]; v < view.first_vertex[p + 1]; ++v)
      copied.push_back(stand_in.own_vertex(v));
    for (std::int64_t c = view.first_cell[p]; c < view.first_cell[p + 1]; ++c)
      if (stand_in.place(c).copy > 0)
        found.second.push_back(c);
  }
  std::sort(copied.begin(), copied.end());
  copied.erase(std::unique(copied.begin(), copied.end()), copied.end());
  std::sort(first_of.begin(), first_of.end());
  for (const std::int64_t v : copied)
    if (!std::ranges::binary_search(first_of, v, {}, [](const auto& of) { return of.first; }))
      first_of.emplace_back(v, v);
  std::sort(first_of.begin(), first_of.end());
  // The same by the view's numbers, group by group.
  std::vector<std::pair<std::int64_t, std::int64_t>> groups;
  for (std::int64_t v = 0; v < view.vertex_count(); ++v) {
    const std::int64_t of = stand_in.own_vertex(v);
    const auto at =
        std::ranges::lower_bound(first_of, of, {}, [](const auto& one) { return one.first; });
    if (at != first_of.end() && at->first == of)
      groups.emplace_back(at->second, v);
  }
  std::sort(groups.begin(), groups.end());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    found.joined.flat.push_back(groups[i].second);
    if (i + 1 == groups.size() || groups[i + 1].first != groups[i].first)
      found.joined.end.push_back(std::int64_t(i + 1));
  }
  return found;
}

std::optional<double> first_west(std::span<const commit::CommittedMesh* const> meshes) {
  std::optional<double> west;
  for (const commit::CommittedMesh* const mesh : meshes)
    if (const commit::ChartFacts* const facts =
            mesh->stand_in() ? mesh->stand_in()->whole_chart() : nullptr)
      west = std::min(west.value_or(facts->west), facts->west);
  return west;
}

bool begins_further_east(std::span<const commit::CommittedMesh* const> meshes, std::size_t mesh) {
  const std::optional<double> all = first_west(meshes), own = first_west(meshes.subspan(mesh, 1));
  return own && *own > *all &&
         std::ranges::any_of(meshes, [](const auto* of) { return has_chart_copies(*of); });
}

void end_at_chart(const mesh::Box& all, render::FrameSettings& settings) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double slack = 1e-6 * (all.high.x - all.low.x);
  settings.clips.push_back({render::Clip::Kind::box,
                            {all.low.x - slack, -infinity, -infinity},
                            {all.high.x + slack, infinity, infinity}});
}

void refresh_vertex_values(const commit::CommittedMesh& mesh, parallel::World& world,
                           std::span<double> values) {
  const bool has_copies = has_chart_copies(mesh);
  std::vector<double> own;
  world.agree_after([&] {
    if (!has_copies)
      return;
    own.resize(std::size_t(mesh.mesh().own_view().vertex_count()));
    for (std::size_t v = 0; v < values.size(); ++v)
      own[std::size_t(mesh.stand_in()->own_vertex(std::int64_t(v)))] = values[v];
  });
  mesh.halo()->refresh_values(mesh, world, has_copies ? std::span(own) : values);
  for (std::size_t v = 0; has_copies && v < values.size(); ++v)
    values[v] = own[std::size_t(mesh.stand_in()->own_vertex(std::int64_t(v)))];
}

} // namespace insitu::scene
