#include "scene/tracers/kept_particles.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "parallel/parcels.h"

namespace insitu::scene {

namespace {

constexpr std::size_t most_kept_bytes = std::size_t(1) << 20; ///< of a process at a time
constexpr std::size_t most_dealt = std::size_t(1) << 16;      ///< particles dealt at a time

struct NamedParticle {
  advect::Particles::Record particle;
  mesh::CellName cell;
};
/// What all processes hear of a particle.
struct Asked {
  math::Vec3d position;
  mesh::CellName cell;
  std::int64_t is_alive;
};
struct Sent {
  advect::Particles::Record particle;
  std::int64_t number; ///< among those dealt at a time
};

/// This process's cell of a particle; -1: it has none.
std::int64_t cell_here(const Asked& asked, const Homecoming& home, const query::Sampler& sampler) {
  if (home.cells && home.cells->stand() && asked.cell.rank >= 0)
    return home.cells->find(asked.cell);
  const mesh::MeshView& view = home.mesh.mesh().view();
  if (!asked.is_alive || view.own_cell_count() == 0)
    return -1;
  const query::Location at = sampler.locate(asked.position, -1, {home.accuracy, 1.0, false});
  return at && at.cell < view.own_cell_count() ? at.cell : -1;
}

/// In one process particles stay, and their cells alone have other numbers.
void rename_cells(advect::Particles& particles, const std::vector<mesh::CellName>& names,
                  const Homecoming& home) {
  const bool stand = home.cells && home.cells->stand();
  const bool of_many =
      std::ranges::any_of(names, [](const mesh::CellName& name) { return name.rank > 0; });
  for (std::size_t i = 0; i < names.size() && (stand || of_many); ++i)
    particles.cells[i] = stand ? home.cells->find(names[i]) : -1;
}

} // namespace

void gather_kept(const advect::Particles& here, const commit::CommittedMesh* mesh,
                 parallel::World& world, core::Memory& memory, KeptParticles& kept) {
  const auto name = [&](std::size_t i) {
    return mesh ? kept_name(*mesh, here.cells[i], world.rank()) : mesh::CellName();
  };
  if (world.size() == 1) {
    for (std::size_t i = 0; i < here.size(); ++i)
      kept.cells.push_back(name(i));
    return;
  }
  std::vector<std::int64_t> dropped(here.dropped().begin(), here.dropped().end());
  world.reduce(std::span(dropped), parallel::Reduction::sum);
  std::vector<std::byte> mine;
  world.agree_after([&] {
    parallel::ByteWriter to;
    for (std::size_t i = 0; i < here.size(); ++i)
      if (here.endings[i] != advect::Particles::gone)
        to.value(NamedParticle{here.record(i), name(i)});
    mine = to.bytes();
  });
  std::vector<std::vector<std::byte>> bytes(std::size_t(world.size())); // whole at the end alone
  world.gather(mine, most_kept_bytes, [&](int rank, std::span<const std::byte> some) {
    std::vector<std::byte>& of = bytes[std::size_t(rank)];
    of.insert(of.end(), some.begin(), some.end());
  });
  world.agree_after([&] {
    std::vector<NamedParticle> all;
    for (const std::vector<std::byte>& of : bytes) {
      const std::vector<NamedParticle> more = parallel::items_of<NamedParticle>(of);
      all.insert(all.end(), more.begin(), more.end());
    }
    std::ranges::sort(all, {}, [](const NamedParticle& one) { return one.particle.id; });
    kept.all.emplace(memory).begin_all(here, dropped);
    for (const NamedParticle& one : all) {
      kept.all->arrive(one.particle);
      kept.cells.push_back(one.cell);
    }
  });
}

void deal_kept(advect::Particles& particles, const std::vector<mesh::CellName>& names,
               const Homecoming& home, parallel::World& world) {
  if (world.size() == 1)
    return rename_cells(particles, names, home);
  std::int64_t count = world.is_root() ? std::int64_t(particles.size()) : 0;
  world.broadcast(std::as_writable_bytes(std::span(&count, 1)));
  const query::Sampler sampler = home.mesh.sampler();
  for (std::size_t first = 0; first < std::size_t(count); first += most_dealt) {
    const std::size_t now = std::min(most_dealt, std::size_t(count) - first);
    std::vector<Asked> asked;
    std::vector<std::int64_t> cells, ranks;
    world.agree_after([&] {
      asked.resize(now);
      std::memset(static_cast<void*>(asked.data()), 0, now * sizeof(Asked));
      for (std::size_t k = 0; k < now && world.is_root(); ++k)
        asked[k] = {particles.positions[first + k],
                    names.empty() ? mesh::CellName() : names[first + k],
                    particles.endings[first + k] == INSITU_END_ALIVE};
      cells.resize(now);
      ranks.resize(now);
    });
    world.broadcast(std::as_writable_bytes(std::span(asked)));
    world.agree_after([&] {
      for (std::size_t k = 0; k < now; ++k) {
        cells[k] = cell_here(asked[k], home, sampler);
        ranks[k] = cells[k] >= 0 ? world.rank() : world.size();
      }
    });
    world.reduce(std::span(ranks), parallel::Reduction::least);
    std::vector<parallel::Parcel> parcels;
    world.agree_after([&] {
      std::vector<parallel::ByteWriter> to(std::size_t(world.size()));
      for (std::size_t k = 0; k < now && world.is_root(); ++k)
        if (ranks[k] > 0 && ranks[k] < world.size() &&
            particles.endings[first + k] != advect::Particles::gone)
          to[std::size_t(ranks[k])].value(Sent{particles.record(first + k), std::int64_t(k)});
      parcels = parallel::parcels_of(to);
    });
    const std::vector<parallel::Parcel> received = world.exchange(parcels);
    const std::size_t before = particles.size();
    try {
      world.agree_after([&] {
        for (const parallel::Parcel& parcel : received)
          for (Sent& sent : parallel::items_of<Sent>(parcel.bytes)) {
            sent.particle.cell = cells[std::size_t(sent.number)];
            particles.arrive(sent.particle);
          }
      });
    } catch (...) {
      particles.take_back_to(before);
      throw;
    }
    for (std::size_t k = 0; k < now && world.is_root(); ++k)
      if (particles.endings[first + k] == advect::Particles::gone)
        continue;
      else if (ranks[k] > 0 && ranks[k] < world.size())
        particles.leave(first + k);
      else
        particles.cells[first + k] = cells[k];
  }
  particles.drop_gone();
}

} // namespace insitu::scene
