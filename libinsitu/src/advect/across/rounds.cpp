#include "advect/across/rounds.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "parallel/bytes.h"

namespace insitu::advect {

using math::Vec3d;

namespace {

/// At a time of one process.
constexpr std::size_t most_travellers = std::size_t(1) << 15;

template <class T>
void append(std::vector<parallel::Parcel>& parcels, int rank, const T& item) {
  auto parcel = std::ranges::find(parcels, rank, &parallel::Parcel::rank);
  if (parcel == parcels.end())
    parcel = parcels.insert(parcels.end(), {rank, {}});
  const auto* bytes = reinterpret_cast<const std::byte*>(&item);
  parcel->bytes.insert(parcel->bytes.end(), bytes, bytes + sizeof item);
}

/// Of a particle, in a list by their order; or null.
const LeftAt* find_left(std::span<const LeftAt> left, std::size_t particle) {
  const auto at = std::ranges::lower_bound(left, particle, {}, &LeftAt::particle);
  return at != left.end() && at->particle == particle ? &*at : nullptr;
}

} // namespace

Rounds::Rounds(const Across& across, insitu_accuracy accuracy, FarCells& cells, FarCells* before,
               Particles& particles, Snapshots* snapshots)
    : world_(across.world), accuracy_(accuracy), cells_(cells), before_(before),
      homes_(cells.homes()), particles_(particles), snapshots_(snapshots) {}

std::int64_t Rounds::sum(std::int64_t mine) const {
  world_.reduce(std::span(&mine, 1), parallel::Reduction::sum);
  return mine;
}

std::vector<parallel::Parcel> Rounds::exchange(std::span<const parallel::Parcel> parcels) {
  for (const parallel::Parcel& parcel : parcels)
    bytes_ += std::int64_t(parcel.bytes.size());
  return world_.exchange(parcels);
}

OnTheWay Rounds::way_of(std::size_t particle) const {
  const auto way = ways_.find(particle);
  return way != ways_.end() ? way->second : OnTheWay();
}

void Rounds::moves(std::size_t particle, const OnTheWay& way) {
  const CellName& given = way.mark.to;
  const int to = given.rank >= 0 ? given.rank : homes_.name(way.mark.cell).rank;
  const std::lock_guard lock(mutex_);
  moving_.push_back({particle, to, way});
}

void Rounds::waits(std::size_t particle, const OnTheWay& way, const query::Elsewhere& at) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back({particle, way, at});
}

void Rounds::run(core::FunctionRef<void(std::span<const std::size_t>)> carry) {
  world_.agree_after([&] {
    todo_.resize(particles_.size());
    std::iota(todo_.begin(), todo_.end(), std::size_t(0));
  });
  for (;;) {
    world_.agree_after([&] {
      carry(todo_);
      todo_.clear();
      // Whatever threads did.
      std::ranges::sort(moving_, {}, &Moving::particle);
      std::ranges::sort(waiting_, {}, &Waiting::particle);
    });
    ++rounds_;
    std::int64_t counts[] = {std::int64_t(moving_.size()), std::int64_t(waiting_.size())};
    world_.reduce(std::span(counts), parallel::Reduction::sum);
    if (counts[0] == 0 && counts[1] == 0)
      return;
    if (counts[0] > 0)
      send(nullptr);
    if (counts[1] > 0)
      ask();
  }
}

/// Some of those that move go. A particle is given up here once all processes have said that they
/// have what came to them.
void Rounds::send(std::vector<LeftAt>* left) {
  const std::size_t now = std::min(moving_.size(), most_travellers), before = particles_.size();
  std::vector<parallel::Parcel> parcels;
  world_.agree_after([&] {
    for (std::size_t k = 0; k < now; ++k) {
      const Moving& m = moving_[k];
      Traveller t;
      std::memset(static_cast<void*>(&t), 0, sizeof t); // padding, too
      t = Traveller{particles_.record(m.particle), m.way, {}, {}, left != nullptr, false, {}};
      ++t.way.hops;
      if (const auto at = left ? find_left(*left, m.particle) : nullptr) {
        t.has_left = true;
        t.left = *at;
      }
      t.name_cells([&](std::int64_t cell) { return cell >= 0 ? homes_.name(cell) : CellName(); });
      append(parcels, m.to, t);
    }
  });
  const std::vector<parallel::Parcel> received = exchange(parcels);
  try {
    world_.agree_after([&] { receive(received, left); });
  } catch (...) {
    particles_.take_back_to(before);
    throw;
  }
  for (std::size_t k = 0; k < now; ++k) {
    const std::size_t particle = moving_[k].particle;
    particles_.leave(particle);
    ways_.erase(particle);
  }
  if (left)
    std::erase_if(*left, [&](const LeftAt& at) {
      return particles_.endings[at.particle] == Particles::gone;
    });
  hops_ += std::int64_t(now);
  moving_.erase(moving_.begin(), moving_.begin() + std::ptrdiff_t(now));
}

void Rounds::receive(std::span<const parallel::Parcel> parcels, std::vector<LeftAt>* left) {
  for (const parallel::Parcel& parcel : parcels)
    for (Traveller& t : parallel::items_of<Traveller>(parcel.bytes)) {
      t.find_cells(homes_, world_.rank());
      const std::size_t particle = particles_.size();
      if (!t.is_home) {
        ways_[particle] = t.way;
        todo_.push_back(particle);
      }
      if (t.has_left) {
        t.left.particle = particle;
        left->push_back(t.left);
      }
      particles_.arrive(t.particle);
    }
  if (!snapshots_)
    return;
  snapshots_->grow(particles_.size());
  for (const std::size_t particle : todo_)
    snapshots_->hops[particle] = way_of(particle).hops;
}

} // namespace insitu::advect
