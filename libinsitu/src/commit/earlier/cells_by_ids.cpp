#include "commit/earlier/cells_by_ids.h"

#include <algorithm>
#include <numeric>

#include "core/random.h"

namespace insitu::commit {

namespace {

constexpr int place_bits = 20; ///< of an id, for the number of a part or a copy

/// The number of a place among those of the solver's cell. A cell has less than 2^20 parts, as its
/// faces have less ids; on each of three charts it has at most two copies.
std::int64_t number_of(std::int32_t chart, std::int32_t copy) {
  return chart > 0 ? 2 * chart + copy : copy;
}
std::int64_t id_at(std::int64_t global, std::int32_t chart, std::int32_t copy) {
  return global << place_bits | number_of(chart, copy);
}
bool leaves_room(std::int64_t global, const StandIn::Place& at) {
  return global >= 0 && global < std::int64_t(1) << (63 - place_bits) &&
         number_of(at.chart, at.copy) < 1 << place_bits;
}

} // namespace

bool are_known_by_ids(const CommittedMesh& mesh) {
  if ((mesh.stand_in() && mesh.stand_in()->is_made()) || !mesh.mesh().has_global_ids(INSITU_CELL))
    return false;
  const std::int64_t count = mesh.stand_in() ? mesh.mesh().view().own_cell_count() : 0;
  for (std::int64_t flat = 0; flat < count; ++flat) {
    const StandIn::Place at = mesh.stand_in()->place(flat);
    if (!leaves_room(mesh.mesh().global_id(INSITU_CELL, at.own), at))
      return false;
  }
  return true;
}

std::int64_t id_of_cell(const CommittedMesh& mesh, std::int64_t flat) {
  if (!mesh.stand_in())
    return mesh.mesh().global_id(INSITU_CELL, flat);
  const StandIn::Place at = mesh.stand_in()->place(flat);
  return id_at(mesh.mesh().global_id(INSITU_CELL, at.own), at.chart, at.copy);
}

CellsByIds::CellsByIds(const CommittedMesh& mesh) : stand_in_(mesh.stand_in() != nullptr) {
  for_each_owner(mesh.mesh().view(),
                 [&](std::int64_t flat) { cells_.emplace_back(id_of_cell(mesh, flat), flat); });
  std::ranges::sort(cells_);
}

std::int64_t CellsByIds::find(const CellName& name) const {
  if (name.global < 0)
    return -1;
  const std::int64_t id = stand_in_ ? id_at(name.global, name.chart, name.copy) : name.global;
  const auto at = std::ranges::lower_bound(cells_, std::pair(id, std::int64_t(0)));
  return at != cells_.end() && at->first == id ? at->second : -1;
}

std::vector<std::int64_t> ids_of_cells(const CommittedMesh& mesh) {
  std::vector<std::int64_t> ids;
  if (!are_known_by_ids(mesh))
    return ids;
  ids.resize(std::size_t(mesh.mesh().view().own_cell_count()));
  for (std::size_t i = 0; i < ids.size(); ++i)
    ids[i] = id_of_cell(mesh, std::int64_t(i));
  return ids;
}

std::vector<StandIn::Place> places_of_cells(const CommittedMesh& mesh) {
  std::vector<StandIn::Place> places;
  if (!mesh.stand_in() || !mesh.stand_in()->chart() || !mesh.mesh().has_stand_in())
    return places;
  places.resize(std::size_t(mesh.mesh().view().own_cell_count()));
  for (std::size_t i = 0; i < places.size(); ++i)
    places[i] = mesh.stand_in()->place(std::int64_t(i));
  return places;
}

std::uint64_t sum_of_cells(const CommittedMesh& mesh, const core::Threads& threads) {
  if (!are_known_by_ids(mesh))
    return 0;
  constexpr std::int64_t grain = 1 << 16;
  const mesh::MeshView& view = mesh.mesh().view();
  // Of parts some vertices are made.
  const bool of_vertices = mesh.mesh().has_global_ids(INSITU_VERTEX) && !mesh.lends_parts();
  const std::int64_t count = view.own_cell_count();
  std::vector<std::uint64_t> sums(std::size_t((count + grain - 1) / grain), 0);
  threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t ids[8];
    for (std::int64_t flat = begin; flat < end; ++flat) {
      const std::int32_t p = view.piece_of(flat);
      const std::int64_t c = flat - view.first_cell[p];
      if (!view.pieces[p].owns(c))
        continue;
      std::uint64_t hash = core::splitmix64(std::uint64_t(id_of_cell(mesh, flat)) + 1);
      hash = core::splitmix64(hash ^ std::uint64_t(view.pieces[p].shape(c)));
      const int corners = of_vertices ? view.pieces[p].vertex_ids(c, ids) : 0;
      for (int k = 0; k < corners; ++k) {
        const std::int64_t vertex = view.first_vertex[p] + ids[k];
        const std::int64_t own = mesh.stand_in() ? mesh.stand_in()->own_vertex(vertex) : vertex;
        hash =
            core::splitmix64(hash ^ (std::uint64_t(mesh.mesh().global_id(INSITU_VERTEX, own)) + 1));
      }
      sums[std::size_t(begin / grain)] += hash;
    }
  });
  return std::accumulate(sums.begin(), sums.end(), std::uint64_t(0));
}

} // namespace insitu::commit
