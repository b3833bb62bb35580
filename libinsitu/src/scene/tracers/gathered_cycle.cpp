#include "scene/tracers/gathered_cycle.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "parallel/bytes.h"

namespace insitu::scene {

using parallel::ByteReader;
using parallel::ByteWriter;

namespace {

constexpr std::size_t most_bytes = std::size_t(1) << 20; ///< of a process at a time

/// A row, and the particle as it is.
struct Packed {
  TrackRow row;
  advect::Particles::Record particle;
};
/// A row of a particle at one of the tracer's own times.
struct PackedTime {
  TrackRow row;
  math::Vec3d position; ///< with the signs of zeros
  std::int32_t hops;    ///< of the particle by then
};

/// All bytes of each process, at the root.
std::map<int, std::vector<std::byte>> gather(std::span<const std::byte> mine,
                                             parallel::World& world) {
  std::map<int, std::vector<std::byte>> all;
  world.gather(mine, most_bytes, [&](int rank, std::span<const std::byte> bytes) {
    all[rank].insert(all[rank].end(), bytes.begin(), bytes.end());
  });
  return all;
}

/// The order of some rows by a key.
template <class Key>
std::vector<std::size_t> order_of(std::size_t count, Key&& key) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::ranges::sort(order, {}, key);
  return order;
}

} // namespace

/// What came to the root.
struct GatheredCycle::Parts {
  std::vector<Packed> rows;
  std::vector<double> values;
  std::vector<std::vector<PackedTime>> at_times; ///< [time]
  std::vector<std::vector<double>> values_at;
};

GatheredCycle::GatheredCycle(ParticleCycle& here, bool all, const Geodesics& geodesics,
                             parallel::World& world, const core::Threads& threads,
                             core::Memory& memory)
    : here_(here), memory_(memory), particles_(memory) {
  std::vector<std::byte> mine;
  Parts parts;
  const std::size_t times = here.times().size();
  const advect::Particles& p = here.particles();
  std::vector<std::size_t> indices;
  if (!geodesics.are_there)
    geodesics.of_all.forget_snapshots();
  world.agree_after([&] {
    for (std::size_t i = 0; i < p.size(); ++i)
      if (p.endings[i] != advect::Particles::gone && (all || p.endings[i] != INSITU_END_ALIVE))
        indices.push_back(i);
    all_ = here.rows(indices);
  });
  here.add_values_of_others(indices, all_, world);
  world.agree_after([&] {
    ByteWriter to;
    const TrackRows& rows = all_;
    to.value(std::int64_t(indices.size()));
    for (std::size_t r = 0; r < indices.size(); ++r)
      to.value(Packed{rows.rows[r], p.record(indices[r])});
    to.array(std::span<const double>(rows.values));
    at_times_.resize(times);
    parts.at_times.resize(times);
    parts.values_at.resize(times);
    for (std::size_t k = 0; k < times; ++k) {
      const TrackRows& at = here.rows_at(k);
      at_times_[k] = at;
      to.value(std::int64_t(at.rows.size()));
      std::size_t r = 0;
      const advect::Snapshots& shots = here.snapshots();
      for (std::size_t i = 0; i < shots.particles; ++i)
        if (const std::size_t item = shots.item(k, i); shots.present[item])
          to.value(PackedTime{at.rows[r++], shots.positions[item], shots.hops[i]});
      to.array(std::span<const double>(at.values));
    }
    mine = to.bytes();
  });
  const auto gathered = gather(mine, world);
  world.agree_after([&] {
    const std::size_t width = all_.columns.size();
    const auto read = [&](ByteReader& from, auto& rows, std::vector<double>& values) {
      const auto count = std::size_t(from.value<std::int64_t>());
      using Row = typename std::remove_reference_t<decltype(rows)>::value_type;
      const std::vector<Row> more = from.array<Row>(count);
      rows.insert(rows.end(), more.begin(), more.end());
      const std::vector<double> with = from.array<double>(count * width);
      values.insert(values.end(), with.begin(), with.end());
    };
    for (const auto& [rank, bytes] : gathered) {
      ByteReader from(bytes);
      read(from, parts.rows, parts.values);
      for (std::size_t k = 0; k < times; ++k)
        read(from, parts.at_times[k], parts.values_at[k]);
    }
    merge(parts);
    merge_times(parts);
    if (world.is_root() && !geodesics.of_all.columns().empty())
      follow(geodesics, threads);
  });
}

/// The particles, and their numbers in all rows: the last columns.
void GatheredCycle::follow(const Geodesics& of, const core::Threads& threads) {
  TrackGeodesics& geodesics = of.of_all;
  if (!of.are_there) {
    geodesics.begin(particles_, all_.frame);
    geodesics.follow(particles_, snapshots_ ? &*snapshots_ : nullptr, all_.frame, threads);
  }
  const std::size_t width = all_.columns.size(), fields = width - geodesics.columns().size();
  for (std::size_t r = 0; r < all_.rows.size(); ++r)
    geodesics.put(all_.rows[r].particle, all_.values.data() + r * width + fields);
  for (std::size_t k = 0; k < at_times_.size(); ++k) {
    std::size_t r = 0;
    for (std::size_t i = 0; i < particles_.size(); ++i)
      if (const std::size_t item = snapshots_->item(k, i); snapshots_->present[item])
        geodesics.put_snapshot(item, at_times_[k].values.data() + r++ * width + fields);
  }
}

void GatheredCycle::merge(Parts& parts) {
  const std::size_t width = all_.columns.size();
  all_.rows.clear();
  all_.values.clear();
  for (const std::size_t r :
       order_of(parts.rows.size(), [&](std::size_t i) { return parts.rows[i].row.particle; })) {
    all_.rows.push_back(parts.rows[r].row);
    particles_.arrive(parts.rows[r].particle);
    const double* from = parts.values.data() + r * width;
    all_.values.insert(all_.values.end(), from, from + width);
  }
}

/// Of a particle that was at a time on two processes, since what it did there was undone, the last
/// counts; and none from its end on, which tells of itself.
void GatheredCycle::merge_times(Parts& parts) {
  if (at_times_.empty())
    return;
  std::map<std::int64_t, std::size_t> places; // of particles
  for (std::size_t i = 0; i < particles_.size(); ++i)
    places[particles_.ids[i]] = i;
  const advect::Snapshots& own = here_.snapshots();
  snapshots_.emplace(own.times, memory_);
  snapshots_->begin(particles_.size());
  const std::size_t width = all_.columns.size();
  for (std::size_t k = 0; k < at_times_.size(); ++k) {
    const std::vector<PackedTime>& rows = parts.at_times[k];
    TrackRows& to = at_times_[k];
    to.rows.clear();
    to.values.clear();
    for (const std::size_t r : order_of(rows.size(), [&](std::size_t i) {
           return std::pair(rows[i].row.particle, -rows[i].hops);
         })) {
      const PackedTime& packed = rows[r];
      const auto place = places.find(packed.row.particle);
      if (!to.rows.empty() && to.rows.back().particle == packed.row.particle)
        continue;
      if (place == places.end())
        continue;
      const std::size_t i = place->second;
      if (particles_.endings[i] != INSITU_END_ALIVE &&
          !own.is_before(own.times[k], particles_.times[i]))
        continue;
      to.rows.push_back(packed.row);
      const double* from = parts.values_at[k].data() + r * width;
      to.values.insert(to.values.end(), from, from + width);
      const std::size_t item = snapshots_->item(k, i);
      snapshots_->positions[item] = packed.position;
      snapshots_->places[item] = {packed.row.cell.flat, {}};
      snapshots_->present[item] = 1;
    }
  }
}

const TrackRows& GatheredCycle::rows(const std::vector<std::size_t>& indices) {
  if (indices.size() == all_.rows.size())
    return all_;
  asked_ = all_;
  asked_.rows.clear();
  asked_.values.clear();
  const std::size_t width = all_.columns.size();
  for (const std::size_t i : indices) {
    asked_.rows.push_back(all_.rows[i]);
    const double* from = all_.values.data() + i * width;
    asked_.values.insert(asked_.values.end(), from, from + width);
  }
  return asked_;
}

void gather_particles(const advect::Particles& here, parallel::World& world,
                      advect::Particles& all) {
  std::vector<std::byte> mine;
  world.agree_after([&] {
    ByteWriter to;
    for (std::size_t i = 0; i < here.size(); ++i)
      if (here.endings[i] != advect::Particles::gone)
        to.value(here.record(i));
    mine = to.bytes();
  });
  const auto gathered = gather(mine, world);
  world.agree_after([&] {
    std::vector<advect::Particles::Record> records;
    for (const auto& [rank, bytes] : gathered) {
      ByteReader from(bytes);
      while (!from.at_end())
        records.push_back(from.value<advect::Particles::Record>());
    }
    std::ranges::sort(records, {}, &advect::Particles::Record::id);
    for (const advect::Particles::Record& record : records)
      all.arrive(record);
  });
}

} // namespace insitu::scene
