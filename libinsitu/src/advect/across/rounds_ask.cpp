// Places that no cell of the asker holds, and what others have there: see Rounds.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "advect/across/rounds.h"
#include "parallel/bytes.h"
#include "parallel/parcels.h"

namespace insitu::advect {

using parallel::ByteReader;
using parallel::ByteWriter;

namespace {

/// Of one process at a time.
constexpr std::size_t most_questions = std::size_t(1) << 14;
/// So often the same step is begun again in another process; then cells are asked for.
constexpr std::int32_t most_tries = 2;

} // namespace

/// Whether its step may be made where the place is held. From a place in no cell it does not go on
/// within a step.
bool Rounds::Waiting::may_go() const {
  return at.reach == 0.0 && way.tries < most_tries && !(way.is_marked && way.mark.cell == -1);
}

/// Of several processes the lowest counts, where cells overlap.
void Rounds::Waiting::note(int rank, const Answer& answer) {
  if (answer.holds && holder < 0) {
    holder = rank;
    goes = answer.goes != 0;
  }
  is_near = is_near || answer.is_near;
  const auto far = [&](const math::Vec3d& x) {
    const math::Vec3d d = x - at.point;
    return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  };
  if (at.reach > 0.0 && answer.is_near && (!nearest || far(answer.nearest) < far(*nearest)))
    nearest = answer.nearest;
}

/// Questions of some of those that wait are answered by the processes that may hold their places.
void Rounds::ask() {
  const std::size_t now = std::min(waiting_.size(), most_questions);
  std::vector<parallel::Parcel> parcels, answers;
  world_.agree_after([&] {
    std::vector<ByteWriter> to(std::size_t(world_.size()));
    for (std::size_t k = 0; k < now; ++k) {
      const Waiting& w = waiting_[k];
      const bool is_before = w.at.outlook != &cells_, goes = !is_before && w.may_go();
      Question question{w.at.point, w.at.alpha, w.at.reach, {}, std::int64_t(k), is_before, goes};
      if (goes && w.way.is_marked)
        question.cell = homes_.name(w.way.mark.cell);
      for (const int rank : w.at.outlook->ranks_at(w.at.point, w.at.reach))
        to[std::size_t(rank)].value(question);
    }
    parcels = parallel::parcels_of(to);
    questions_ += std::int64_t(now);
  });
  const std::vector<parallel::Parcel> asked = exchange(parcels);
  world_.agree_after([&] {
    std::vector<ByteWriter> to(std::size_t(world_.size()));
    for (const parallel::Parcel& parcel : asked)
      for (const Question& question : parallel::items_of<Question>(parcel.bytes))
        answer(question, to[std::size_t(parcel.rank)]);
    answers = parallel::parcels_of(to);
  });
  const std::vector<parallel::Parcel> answered = exchange(answers);
  world_.agree_after([&] {
    for (const parallel::Parcel& parcel : answered)
      take_answers(parcel);
    cells_.set_views();
    if (before_)
      before_->set_views();
    for (std::size_t k = 0; k < now; ++k)
      go_on(waiting_[k]);
    waiting_.erase(waiting_.begin(), waiting_.begin() + std::ptrdiff_t(now));
  });
}

void Rounds::answer(const Question& q, ByteWriter& to) const {
  const FarCells* const cells = q.before ? before_ : &cells_;
  const FarCells::Answer found =
      cells ? cells->answer(q.point, q.alpha, q.reach, accuracy_) : FarCells::Answer{};
  Answer a{q.number, found.at.parametric, {}, found.holds, 0, found.is_near};
  a.goes = q.goes && found.holds && (q.cell.rank < 0 || homes_.find(q.cell) >= 0);
  if (found.nearest)
    a.nearest = *found.nearest;
  to.value(a);
  if (found.holds && !a.goes)
    cells->tell(found.at.cell, accuracy_, to);
}

void Rounds::take_answers(const parallel::Parcel& parcel) {
  ByteReader from(parcel.bytes);
  while (!from.at_end()) {
    const auto answer = from.value<Answer>();
    Waiting& w = waiting_[std::size_t(answer.number)];
    const bool is_first = w.holder < 0;
    w.note(parcel.rank, answer);
    if (!answer.holds || answer.goes)
      continue;
    FarCells& cells = w.at.outlook == &cells_ ? cells_ : *before_;
    const std::int64_t cell = cells.take(parcel.rank, from);
    if (is_first)
      w.found = {cell, answer.parametric};
  }
}

/// A particle whose question was answered makes its step in the process that holds the place, if
/// that has the particle's cell; else here, with what was said.
void Rounds::go_on(const Waiting& w) {
  OnTheWay way = w.way;
  if (w.goes) {
    ++way.tries;
    way.stays = way.is_marked;
    moving_.push_back({w.particle, w.holder, way});
    return;
  }
  FarCells& cells = w.at.outlook == &cells_ ? cells_ : *before_;
  if (w.at.reach > 0.0)
    cells.know_nearest(w.at.point, w.at.alpha, w.at.reach, w.nearest);
  else
    cells.know(w.at.point, w.at.alpha, w.found, w.is_near);
  way.stays = way.stays_here;
  ways_[w.particle] = way;
  todo_.push_back(w.particle);
}

namespace {

/// A snapshot whose place is another process's.
struct Shot {
  Particles::Record particle;
  std::uint64_t number; ///< of its time
  math::Vec3d position;
  CellName cell;
  math::Vec3d parametric;
  std::int32_t hops, padding = 0;
};

} // namespace

void Rounds::bring_home(std::vector<LeftAt>& left) {
  world_.agree_after([&] {
    ways_.clear();
    std::ranges::sort(left, {}, &LeftAt::particle);
    for (std::size_t i = 0; i < particles_.size(); ++i) {
      const std::int64_t cell = particles_.cells[i];
      const std::uint8_t ending = particles_.endings[i];
      if (cell < 0 || ending == Particles::gone || homes_.is_own(cell))
        continue;
      const bool is_left = std::ranges::binary_search(left, i, {}, &LeftAt::particle);
      if (ending == INSITU_END_ALIVE || is_left || cells_.is_far(cell))
        moving_.push_back({i, homes_.name(cell).rank, {}});
    }
  });
  while (sum(std::int64_t(moving_.size())) > 0)
    send(&left);
  std::int64_t any = snapshots_ != nullptr; // alike on all
  world_.reduce(std::span(&any, 1), parallel::Reduction::least);
  if (any)
    send_snapshots();
}

/// Those in cells that are not here any more once the interval is over go to who owns these, as
/// of a particle that left there.
void Rounds::send_snapshots() {
  std::vector<parallel::Parcel> parcels;
  std::vector<std::pair<std::size_t, std::size_t>> sent; // times and particles
  world_.agree_after([&] {
    std::vector<ByteWriter> to(std::size_t(world_.size()));
    for (std::size_t k = 0; k < snapshots_->times.size(); ++k)
      for (std::size_t i = 0; i < std::min(snapshots_->particles, particles_.size()); ++i) {
        const std::size_t item = snapshots_->item(k, i);
        const query::Location& place = snapshots_->places[item];
        if (!snapshots_->present[item] || place.cell < 0 || !cells_.is_far(place.cell))
          continue;
        const CellName name = homes_.name(place.cell);
        Shot shot;
        std::memset(static_cast<void*>(&shot), 0, sizeof shot); // padding, too
        shot = Shot{particles_.record(i), k, snapshots_->positions[item], name, place.parametric,
                    snapshots_->hops[i]};
        shot.particle.cell = -1;
        to[std::size_t(name.rank)].value(shot);
        sent.emplace_back(k, i);
      }
    parcels = parallel::parcels_of(to);
  });
  const std::vector<parallel::Parcel> received = exchange(parcels);
  const std::size_t before = particles_.size();
  try {
    world_.agree_after([&] {
      for (const parallel::Parcel& parcel : received)
        for (const Shot& shot : parallel::items_of<Shot>(parcel.bytes)) {
          const std::size_t i = particles_.size();
          particles_.arrive(shot.particle);
          snapshots_->grow(particles_.size());
          const std::size_t item = snapshots_->item(std::size_t(shot.number), i);
          snapshots_->positions[item] = shot.position;
          snapshots_->places[item] = {homes_.find(shot.cell), shot.parametric};
          snapshots_->present[item] = 1;
          snapshots_->hops[i] = shot.hops;
        }
    });
  } catch (...) {
    particles_.take_back_to(before);
    throw;
  }
  for (std::size_t i = before; i < particles_.size(); ++i)
    particles_.leave(i);
  for (const auto& [k, i] : sent)
    snapshots_->present[snapshots_->item(k, i)] = 0;
}

} // namespace insitu::advect
