#include "scene/checkpoint/kept_mesh.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "commit/earlier/dealt_step.h"
#include "mesh/registered/earlier_parts.h"
#include "scene/run/own_cell.h"

namespace insitu::scene {

namespace {

constexpr std::uint64_t prime = 0x100000001b3u, basis = 0xcbf29ce484222325u;

std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * prime;
  return hash ^ hash >> 32;
}

mesh::Box box_of(const mesh::MeshView& mesh, const core::Threads& threads) {
  constexpr std::int64_t grain = 1 << 16;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const mesh::Box none{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  mesh::Box box = none;
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    std::vector<mesh::Box> parts(std::size_t((piece.vertex_count + grain - 1) / grain), none);
    threads.parallel_for(piece.vertex_count, grain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t v = begin; v < end; ++v)
        parts[std::size_t(begin / grain)].extend({piece.point(v), piece.point(v)});
    });
    for (const mesh::Box& part : parts)
      box.extend(part);
  }
  return box;
}

/// add(cell, hash): the hash with a cell.
template <class F>
std::uint64_t hash_of_cells(std::int64_t count, const core::Threads& threads, F&& add) {
  constexpr std::int64_t grain = 1 << 16;
  std::vector<std::uint64_t> parts(std::size_t((count + grain - 1) / grain), basis);
  threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    std::uint64_t hash = basis;
    for (std::int64_t c = begin; c < end; ++c)
      hash = add(c, hash);
    parts[std::size_t(begin / grain)] = hash;
  });
  std::uint64_t hash = mix(basis, std::uint64_t(count));
  for (const std::uint64_t part : parts)
    hash = mix(hash, part);
  return hash;
}

/// Of the own cells' places, and of what else says which cells of the dual there are.
std::uint64_t hash_of(const mesh::AmrView& mesh, insitu_reconstruction how,
                      const core::Threads& threads) {
  std::uint64_t hash =
      hash_of_cells(mesh.own_cell_count(), threads, [&](std::int64_t flat, std::uint64_t before) {
        const auto piece =
            std::upper_bound(mesh.first_cell, mesh.first_cell + mesh.piece_count + 1, flat) -
            mesh.first_cell - 1;
        const mesh::AmrCell cell = mesh.cell(mesh.pieces[piece], flat - mesh.first_cell[piece]);
        before = mix(before, std::uint64_t(piece) << 8 | std::uint64_t(cell.depth));
        for (const std::int64_t i : cell.index)
          before = mix(before, std::uint64_t(i));
        return before;
      });
  const mesh::Lattice& lattice = mesh.lattice;
  for (const double x :
       {lattice.origin[0], lattice.origin[1], lattice.origin[2], lattice.spacing[0],
        lattice.spacing[1], lattice.spacing[2], lattice.plane, double(lattice.is_flat)})
    hash = mix(hash, std::bit_cast<std::uint64_t>(x));
  for (std::int32_t p = 0; p < mesh.piece_count - mesh.halo_piece_count; ++p)
    hash = mix(hash, mesh.pieces[p].ghost_faces);
  return mix(hash, std::uint64_t(how));
}

} // namespace

KeptPart::KeptPart(const commit::CommittedMesh& mesh, core::Memory& memory,
                   const core::Threads& threads)
    : sum(commit::sum_of_cells(mesh, threads)), unguided(mesh.unguided()),
      step(mesh.mesh().copy_earlier()), cells(memory), chart(mesh.earlier_chart()) {
  const mesh::MeshView own = mesh::own_part(mesh.mesh().view());
  fingerprint = scene::fingerprint(mesh, threads);
  box = box_of(own, threads);
  if (step.fields.empty())
    return;
  cells = mesh.copy_earlier_cells(threads);
  adaptive = mesh.copy_earlier_adaptive();
  ids = commit::ids_of_cells(mesh);
  places = commit::places_of_cells(mesh);
}

/// As cells of one shape have the same numbers in many parts, their ids and places are looked at.
bool KeptPart::is_of(const commit::CommittedMesh& mesh, bool is_part,
                     const core::Threads& threads) const {
  const mesh::MeshView own = mesh::own_part(mesh.mesh().view());
  if (scene::fingerprint(mesh, threads) != fingerprint)
    return false;
  if (!is_part)
    return true;
  return commit::sum_of_cells(mesh, threads) == sum &&
         (own.vertex_count() == 0 || box.holds(box_of(own, threads).middle()));
}

bool KeptPart::lacks_cells() const {
  return !step.fields.empty() && cells.empty() && adaptive.empty();
}

void KeptPart::keep(core::Archive& archive) {
  archive.value("cells", fingerprint);
  archive.value("box's lower corner", box.low);
  archive.value("box's upper corner", box.high);
  archive.value("sum of ids", sum);
  archive.value("unguided points", unguided);
  step.keep(archive);
  cells.keep(archive);
  adaptive.keep(archive);
  archive.array("global ids", ids);
  archive.array("places", places);
  bool has_chart = chart.has_value();
  archive.value("has a chart", has_chart);
  if (!has_chart)
    return;
  query::ChartImage image = chart.value_or(query::ChartImage{});
  archive.value("radians", image.units.radians);
  archive.value("kilometres", image.units.kilometres);
  archive.value("down", image.units.down);
  archive.value("west", image.west);
  archive.value("north", image.north_from);
  archive.value("south", image.south_from);
  chart = image;
}

/// What all processes know of the mesh and of what was kept of it.
struct KeptMesh::Found {
  bool same_numbers, same_ids;
  bool has_step; ///< some process kept fields
  bool is_adaptive;
  bool has_cells; ///< all that kept fields kept the cells, too, on which particles can go on
  bool has_ids;   ///< and ids of these
};

/// Collective.
KeptMesh::Charts KeptMesh::look_at_charts(const commit::CommittedMesh& mesh,
                                          parallel::World& world) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double least[9]; // of each number of a chart, of its negative; 0: there are cells on none
  std::ranges::fill(least, infinity);
  const auto add = [&](const query::ChartImage* chart) {
    if (!chart) {
      least[8] = 0.0;
      return;
    }
    const int units = chart->units.radians | chart->units.kilometres << 1 | chart->units.down << 2;
    const double numbers[] = {chart->west, chart->north_from, chart->south_from, double(units)};
    for (std::size_t i = 0; i < 4; ++i) {
      least[i] = std::min(least[i], numbers[i]);
      least[4 + i] = std::min(least[4 + i], -numbers[i]);
    }
  };
  if (mesh.mesh().own_view().own_cell_count() > 0)
    add(mesh.stand_in() ? mesh.stand_in()->chart() : nullptr);
  for (const Part& part : parts)
    if (!part.kept.step.fields.empty())
      add(part.kept.chart ? &*part.kept.chart : nullptr);
  world.reduce(std::span(least), parallel::Reduction::least);
  const bool any = least[3] < infinity, none = least[8] == 0.0;
  const auto is_same = [&](std::size_t i) { return least[i] == -least[4 + i]; };
  if (!any)
    return Charts::same;
  if (none || !is_same(3))
    return Charts::others;
  return is_same(0) && is_same(1) && is_same(2) ? Charts::same : Charts::of_the_same_units;
}

KeptMesh::Found KeptMesh::look_at(const commit::CommittedMesh& mesh, parallel::World& world,
                                  const core::Threads& threads) const {
  const bool by_ids = name_cells(mesh.mesh(), world).global;
  const Charts charts = look_at_charts(mesh, world);
  // Other cells; cells without ids here, and there; fields; adaptive; lost cells.
  std::int64_t any[6] = {};
  std::int64_t sums[2] = {};
  world.agree_after([&] {
    any[0] = world.size() != processes ||
             (!parts.empty() && !parts.front().kept.is_of(mesh, world.size() > 1, threads));
    any[1] = !by_ids || charts != Charts::same ||
             (mesh.mesh().own_view().own_cell_count() > 0 && !are_known_by_ids(mesh));
    any[4] = mesh.mesh().is_adaptive();
    sums[0] = std::int64_t(commit::sum_of_cells(mesh, threads));
    for (const Part& part : parts) {
      any[2] = any[2] || (!part.kept.step.fields.empty() && part.kept.ids.empty());
      any[3] = any[3] || !part.kept.step.fields.empty();
      any[5] = any[5] || part.kept.lacks_cells() || charts == Charts::others;
      sums[1] = std::int64_t(std::uint64_t(sums[1]) + part.kept.sum);
    }
  });
  world.reduce(any, parallel::Reduction::greatest);
  world.reduce(sums, parallel::Reduction::sum);
  return {!any[0], !any[1] && !any[2] && sums[0] == sums[1], any[3] != 0, any[4] != 0, !any[5],
          !any[2]};
}

KeptCells::By KeptMesh::restore(commit::CommittedMesh& mesh, parallel::World& world,
                                core::Memory& memory, const core::Threads& threads,
                                const core::Log& log) {
  mesh.update_chart(world, threads, log); // that of all cells, as it was when they were kept
  const Found found = look_at(mesh, world, threads);
  if (found.has_step && world.size() > 1)
    mesh.update_halo(world, threads, log); // to which the step is to fit
  if (found.same_numbers) {
    world.agree_after([&] {
      if (!parts.empty())
        mesh.restore_unguided(parts.front().kept.unguided);
    });
    if (found.has_step)
      restore_by_numbers(mesh, found.is_adaptive, world);
    return KeptCells::By::numbers;
  }
  if (found.same_ids && (!found.has_step || restore_by_ids(mesh, world)))
    return KeptCells::By::ids;
  if (found.has_cells)
    restore_other_cells(mesh, found.has_ids, world, memory, threads);
  else if (found.has_step && world.size() > 1 && world.is_root())
    log.warning("mesh '" + name +
                "': its cells are not known again after the restart, as they are not those of as "
                "many processes in the same order; particles go through their first interval by "
                "the velocity at its end");
  return KeptCells::By::nothing;
}

/// The first part that has fields; or null.
const mesh::EarlierStep* KeptMesh::some_step() const {
  for (const Part& part : parts)
    if (!part.kept.step.fields.empty())
      return &part.kept.step;
  return nullptr;
}

/// Of an adaptive mesh the step is whole, with what is around each process's cells.
void KeptMesh::restore_by_numbers(commit::CommittedMesh& mesh, bool is_adaptive,
                                  parallel::World& world) {
  const mesh::EarlierStep* const mine = some_step();
  mesh::EarlierStep step = commit::fields_of_all(mine, world);
  std::int64_t is_unfit = 0;
  world.agree_after([&] {
    is_unfit = (mine && !mesh::have_same_fields(*mine, step)) || (world.size() > 1 && !mesh.halo());
    if (mine)
      step = *mine;
    if (mesh.halo() && !is_adaptive)
      mesh::resize(step, mesh.mesh().view());
  });
  world.reduce(std::span(&is_unfit, 1), parallel::Reduction::greatest);
  if (is_unfit)
    return;
  if (!is_adaptive)
    commit::fill_halo(mesh, world, step);
  world.agree_after([&] {
    if (mine)
      mesh.mesh().set_earlier(step);
  });
}

bool KeptMesh::restore_by_ids(commit::CommittedMesh& mesh, parallel::World& world) {
  std::vector<mesh::MeshView> views;
  std::vector<commit::StepPart> steps;
  mesh::EarlierStep step = commit::fields_of_all(some_step(), world);
  world.agree_after([&] {
    views.reserve(parts.size());
    for (Part& part : parts)
      if (!part.kept.step.fields.empty()) {
        views.push_back(part.kept.cells.on(part.kept.step.points.data()));
        steps.push_back({&part.kept.step, &views.back(), part.kept.ids});
      }
  });
  if (!commit::deal_by_ids(steps, mesh, world, step))
    return false;
  commit::fill_halo(mesh, world, step);
  world.agree_after([&] {
    if (mesh.mesh().own_view().own_cell_count() > 0)
      mesh.mesh().set_earlier(step);
  });
  return true;
}

/// Puts the parts of a mesh that is not adaptive together in the first one. Returns what the step's
/// cells are. by_ids: known by.
commit::EarlierMesh::Own KeptMesh::join_parts(bool by_ids) {
  const bool has_places =
      std::ranges::any_of(parts, [](const Part& part) { return !part.kept.places.empty(); });
  commit::EarlierMesh::Own own;
  for (Part& part : parts) {
    KeptPart& kept = part.kept;
    const std::int64_t first = own.cells;
    own.cells += kept.cells.on(kept.step.points.data()).cell_count();
    if (by_ids)
      own.global.insert(own.global.end(), kept.ids.begin(), kept.ids.end());
    for (std::int64_t flat = first; flat < own.cells && has_places; ++flat) {
      commit::StandIn::Place place{flat};
      if (!kept.places.empty()) {
        place = kept.places[std::size_t(flat - first)];
        place.own += first;
      }
      own.places.push_back(place);
    }
    if (&part == &parts.front())
      continue;
    mesh::append(parts.front().kept.step, kept.step);
    parts.front().kept.cells.append(kept.cells);
  }
  return own;
}

/// The step of this process's parts on the cells of these; or null. by_ids: these are known by.
std::unique_ptr<commit::EarlierMesh> KeptMesh::on_its_cells(bool by_ids, bool is_part,
                                                            core::Memory& memory,
                                                            const core::Threads& threads) {
  std::vector<commit::EarlierCells> adaptive;
  auto kind = commit::CellsKind::cells;
  for (const Part& part : parts)
    if (!part.kept.adaptive.empty()) {
      kind = part.kept.adaptive.kind();
      adaptive.push_back(part.kept.adaptive.with(part.kept.step, part.process));
    }
  if (!adaptive.empty())
    return commit::EarlierMesh::restored(commit::EarlierCells::joined(adaptive), kind, is_part,
                                         memory, threads);
  if (!some_step())
    return nullptr;
  commit::EarlierMesh::Own own = join_parts(by_ids);
  KeptPart& joined = parts.front().kept;
  std::unique_ptr<commit::EarlierMesh> mesh = commit::EarlierMesh::restored(
      joined.step, std::move(joined.cells), joined.chart, memory, threads);
  if (mesh)
    mesh->set_own(std::move(own));
  return mesh;
}

/// On the checkpoint's cells. by_ids: of several cells that hold a place the lowest id counts, as
/// it did on the processes that wrote it.
void KeptMesh::restore_other_cells(commit::CommittedMesh& mesh, bool by_ids, parallel::World& world,
                                   core::Memory& memory, const core::Threads& threads) {
  std::unique_ptr<commit::EarlierMesh> before;
  world.agree_after([&] { before = on_its_cells(by_ids, world.size() > 1, memory, threads); });
  if (world.size() == 1 && parts.size() > 1 && by_ids && before && !mesh.mesh().is_adaptive())
    before = commit::EarlierMesh::gathered(before.get(), mesh.tree(),
                                           mesh.stand_in() ? mesh.stand_in()->chart() : nullptr,
                                           world, memory, threads);
  world.agree_after([&] { mesh.set_earlier_mesh(std::move(before)); });
}

std::uint64_t fingerprint(const commit::CommittedMesh& mesh, const core::Threads& threads) {
  if (mesh.mesh().is_adaptive())
    return hash_of(mesh.mesh().adaptive(), mesh.mesh().reconstruction(), threads);
  const mesh::MeshView own = mesh::own_part(mesh.mesh().view());
  const std::uint64_t hash =
      hash_of_cells(own.cell_count(), threads, [&](std::int64_t flat, std::uint64_t before) {
        mesh::CellVertices cell;
        mesh::gather(own, flat, cell);
        before = mix(before, std::uint64_t(cell.shape) << 32 | std::uint64_t(cell.piece));
        for (int v = 0; v < cell.count; ++v)
          before = mix(before, std::uint64_t(cell.ids[v]));
        return before;
      });
  return mix(hash, std::uint64_t(own.vertex_count()));
}

} // namespace insitu::scene
