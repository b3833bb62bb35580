/// The numbers of cells and vertices in the mesh of all processes.
#include <algorithm>
#include <limits>

#include "core/status.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

using core::Error;

namespace {

const char* const items[2] = {"vertices", "cells"}; ///< [association]

std::int64_t load_id(const ExternalArray& ids, std::int64_t item) {
  return load_index(ids.at(item, 0), ids.type == INSITU_INT32);
}

/// What a run of ids tells.
struct IdRun {
  std::int64_t negative = -1; ///< the first item whose id is below 0; -1: none
  std::int64_t descends = -1; ///< the first item whose id is not above that of the one before
  std::int64_t first = -1, last = -1; ///< ids of the first and the last item that counts; -1: none
};

template <class Counts>
IdRun look_at(const ExternalArray& ids, std::int64_t begin, std::int64_t end, Counts&& counts) {
  IdRun run;
  for (std::int64_t i = begin; i < end && run.negative < 0; ++i) {
    if (!counts(i))
      continue;
    const std::int64_t id = load_id(ids, i);
    if (id < 0)
      run.negative = i;
    if (run.first < 0)
      run.first = id;
    else if (id <= run.last && run.descends < 0)
      run.descends = i;
    run.last = id;
  }
  return run;
}

/// The same of all items, a slice of them a thread.
template <class Counts>
IdRun look_at(const ExternalArray& ids, std::int64_t count, Counts&& counts,
              const core::Threads* threads) {
  constexpr std::int64_t slice = 1 << 16;
  std::vector<IdRun> runs(std::size_t((count + slice - 1) / slice));
  const auto look = [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t from = begin; from < end; from += slice)
      runs[std::size_t(from / slice)] = look_at(ids, from, std::min(from + slice, end), counts);
  };
  if (threads)
    threads->parallel_for(count, slice, look);
  else if (count > 0)
    look(0, count);
  IdRun all;
  for (std::size_t r = 0; r < runs.size() && all.negative < 0; ++r) {
    const IdRun& run = runs[r];
    all.negative = run.negative;
    if (run.first < 0)
      continue;
    if (all.descends < 0)
      all.descends =
          all.first >= 0 && run.first <= all.last ? std::int64_t(r) * slice : run.descends;
    all.first = all.first < 0 ? run.first : all.first;
    all.last = run.last;
  }
  return all;
}

} // namespace

void Mesh::set_global_ids(std::int32_t piece, insitu_association association,
                          const insitu_array* array) {
  const std::string where = "mesh '" + name_ + "', piece " + std::to_string(piece);
  if (association != INSITU_VERTEX && association != INSITU_CELL)
    throw Error(INSITU_ERROR_ARGUMENT,
                where + ", global ids: unknown association " + std::to_string(int(association)));
  const std::string name = where + ", global ids of " + items[association];
  if (association == INSITU_VERTEX)
    refuse_if_adaptive(name);
  ExternalArray adopted;
  if (array) {
    adopted = adopt(array, name);
    require_integer(adopted, name);
    if (adopted.components != 1)
      throw Error(INSITU_ERROR_ARGUMENT,
                  name + ": " + std::to_string(adopted.components) + " components, 1 expected");
    if (adopted.memory != INSITU_HOST)
      throw Error(INSITU_ERROR_UNSUPPORTED, name + ": in device memory; the host reads them");
  }
  piece_for(piece).global_ids[association] = adopted;
  pending_ |= INSITU_CHANGED_TOPOLOGY;
}

std::int64_t Mesh::global_id(insitu_association association, std::int64_t flat) const {
  if (!has_global_ids_[association])
    return -1;
  const std::vector<std::int64_t>& first = association == INSITU_CELL ? first_cell_ : first_vertex_;
  const std::size_t p =
      std::size_t(std::upper_bound(first.begin(), first.end(), flat) - first.begin()) - 1;
  const ExternalArray& ids = pieces_[p].global_ids[association];
  const std::int64_t item = flat - first[p];
  if (association == INSITU_CELL || !pieces_[p].flat)
    return load_id(ids, item);
  const std::int64_t vertex = piece_views_[p].solver_vertex(item);
  return 2 * load_id(ids, vertex) + ((vertex == item) == pieces_[p].flat->top_first());
}

/// Checks the ids of a piece, if they may be others than at the last update, and whether those of
/// its cells ascend from `last` on, the id of the cell before.
void Mesh::check_global_ids(std::size_t p, insitu_association of, std::int64_t& last,
                            const core::Threads* threads) {
  const Piece& piece = pieces_[p];
  const ExternalArray& ids = piece.global_ids[of];
  const std::int64_t count = of == INSITU_CELL ? cells_of(p) : vertices_of(piece);
  const std::string name =
      "mesh '" + name_ + "', piece " + std::to_string(p) + ", global ids of " + items[of];
  if (ids.layout.count != count)
    throw Error(INSITU_ERROR_MESH, name + ": " + std::to_string(ids.layout.count) + " for " +
                                       std::to_string(count) + " " + items[of]);
  if (!(pending_ & INSITU_CHANGED_TOPOLOGY))
    return;
  const auto counts = [&](std::int64_t i) { return of == INSITU_VERTEX || piece.view.owns(i); };
  const IdRun run = look_at(ids, count, counts, threads);
  if (run.negative >= 0)
    throw Error(INSITU_ERROR_MESH, name + ": item " + std::to_string(run.negative) + " has " +
                                       std::to_string(load_id(ids, run.negative)) +
                                       ", 0 or above expected");
  if (of != INSITU_CELL || run.first < 0)
    return;
  if (global_ids_descend_.empty() && run.first <= last)
    global_ids_descend_ = name + " do not ascend: the first is " + std::to_string(run.first) +
                          ", after " + std::to_string(last) + " in a piece before";
  if (global_ids_descend_.empty() && run.descends >= 0)
    global_ids_descend_ = name + " do not ascend at cell " + std::to_string(run.descends);
  last = run.last;
}

/// Of the pieces as they were registered, whose views may not be made yet.
void Mesh::check_global_ids(const core::Threads* threads) {
  if (pending_ & INSITU_CHANGED_TOPOLOGY)
    global_ids_descend_.clear();
  for (const insitu_association of : {INSITU_VERTEX, INSITU_CELL}) {
    std::ptrdiff_t with = -1, without = -1; // the last such piece
    std::int64_t last = -1;
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      if (cells_of(p) == 0)
        continue;
      const bool given = pieces_[p].global_ids[of].given();
      (given ? with : without) = std::ptrdiff_t(p);
      if (given)
        check_global_ids(p, of, last, threads);
    }
    if (with >= 0 && without >= 0)
      throw Error(INSITU_ERROR_MESH, "mesh '" + name_ + "', piece " + std::to_string(without) +
                                         ": no global ids of " + items[of] + ", which piece " +
                                         std::to_string(with) +
                                         " has; all pieces that have cells, or none, expected");
    has_global_ids_[of] = with >= 0;
  }
}

} // namespace insitu::mesh
