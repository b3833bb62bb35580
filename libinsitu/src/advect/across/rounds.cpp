#include "advect/across/rounds.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>

#include "core/status.h"
#include "parallel/bytes.h"

namespace insitu::advect {

using math::Vec3d;

namespace {

/// At a time of one process.
constexpr std::size_t most_travellers = std::size_t(1) << 15;
constexpr std::size_t most_questions = std::size_t(1) << 14;
/// So often the same step is begun again in another process; then its values are asked for.
constexpr std::int32_t most_tries = 2;

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

std::string text_of(const Vec3d& x) {
  return "(" + std::to_string(x.x) + ", " + std::to_string(x.y) + ", " + std::to_string(x.z) + ")";
}

} // namespace

Rounds::Rounds(const Across& across, const query::Sampler& sampler, insitu_accuracy accuracy,
               OtherCells& others, Particles& particles, Snapshots* snapshots)
    : world_(across.world), homes_(across.homes), sampler_(sampler), accuracy_(accuracy),
      others_(others), particles_(particles), snapshots_(snapshots) {}

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

std::span<const FarValue> Rounds::far_of(std::size_t particle) const {
  const auto far = far_.find(particle);
  return far != far_.end() ? std::span<const FarValue>(far->second) : std::span<const FarValue>();
}

/// Of a cell of the particle's mark, which may be one of those of its far values.
CellName Rounds::name_for(std::size_t particle, std::int64_t cell) const {
  if (cell >= 0)
    return homes_.name(cell);
  const std::span<const FarValue> far = far_of(particle);
  const std::int64_t k = -2 - cell;
  return k >= 0 && k < std::int64_t(far.size()) ? far[std::size_t(k)].cell : CellName();
}

void Rounds::moves(std::size_t particle, const OnTheWay& way) {
  const CellName& given = way.mark.to;
  const int to = given.rank >= 0 ? given.rank : name_for(particle, way.mark.cell).rank;
  const std::lock_guard lock(mutex_);
  moving_.push_back({particle, to, way});
}

void Rounds::waits(std::size_t particle, const OnTheWay& way, const query::Elsewhere& at) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back({particle, way, at});
}

void Rounds::ends_far(std::size_t particle, std::int64_t cell) {
  const CellName name = name_for(particle, cell);
  const std::lock_guard lock(mutex_);
  ends_far_[particle] = name;
}

void Rounds::run(core::FunctionRef<void(std::span<const std::size_t>)> carry, Evaluate velocity) {
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
      ask(velocity);
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
      t.name_cells([&](std::int64_t cell) { return name_for(m.particle, cell); });
      if (const auto far = ends_far_.find(m.particle); left && far != ends_far_.end())
        t.cell = far->second;
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
    far_.erase(particle);
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
      t.find_cells(homes_);
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

/// Questions of some of those that wait are answered by the processes that may hold their places.
void Rounds::ask(Evaluate velocity) {
  const std::size_t now = std::min(waiting_.size(), most_questions);
  std::vector<parallel::Parcel> parcels, answers;
  world_.agree_after([&] {
    for (std::size_t k = 0; k < now; ++k) {
      Waiting& w = waiting_[k];
      const CellName cell = w.way.is_marked ? name_for(w.particle, w.way.mark.cell) : CellName();
      const Question question{w.at.point,      w.at.alpha,        cell,
                              std::int64_t(k), w.at.is_for_value, w.at.time};
      for (const int rank : others_.ranks_at(w.at.point))
        append(parcels, rank, question);
    }
    questions_ += std::int64_t(now);
  });
  const std::vector<parallel::Parcel> asked = exchange(parcels);
  world_.agree_after([&] {
    for (const parallel::Parcel& parcel : asked)
      for (const Answer& answer : answers_to(parallel::items_of<Question>(parcel.bytes), velocity))
        append(answers, parcel.rank, answer);
  });
  const std::vector<parallel::Parcel> answered = exchange(answers);
  world_.agree_after([&] {
    for (const parallel::Parcel& parcel : answered)
      for (const Answer& answer : parallel::items_of<Answer>(parcel.bytes))
        if (answer.holds) {
          Waiting& w = waiting_[std::size_t(answer.number)];
          if (w.holder < 0) { // the lowest, where cells overlap
            w.holder = parcel.rank;
            // From a place in no cell it does not go on within a step.
            w.knows_cell = answer.knows_cell && !(w.way.is_marked && w.way.mark.cell == -1);
            w.value = answer.value;
          }
        }
    for (std::size_t k = 0; k < now; ++k) {
      if (waiting_[k].way.is_new_step)
        far_.erase(waiting_[k].particle);
      go_on(waiting_[k]);
    }
    waiting_.erase(waiting_.begin(), waiting_.begin() + std::ptrdiff_t(now));
  });
}

std::vector<Answer> Rounds::answers_to(std::span<const Question> questions,
                                       Evaluate velocity) const {
  std::vector<Answer> answers;
  for (const Question& q : questions) {
    const query::Location at = sampler_.locate(q.point, -1, {accuracy_, q.alpha});
    Answer& a = answers.emplace_back(Answer{
        q.number, at && homes_.is_own(at.cell), q.cell.rank < 0 || homes_.find(q.cell) >= 0, {}});
    if (!a.holds || !q.is_for_value)
      continue;
    a.value.x = q.point;
    a.value.t = q.time;
    a.value.cell = homes_.name(at.cell);
    a.value.sampled = velocity(q.point, q.time, a.value.v);
  }
  return answers;
}

/// A particle whose question was answered makes its step here, where nobody holds the place; else
/// in the process that does, or with the value that is there.
void Rounds::go_on(const Waiting& w) {
  OnTheWay way = w.way;
  const bool goes = w.holder >= 0 && w.knows_cell && way.tries < most_tries;
  if (goes) {
    ++way.tries;
    way.stays = way.is_marked;
    moving_.push_back({w.particle, w.holder, way});
    return;
  }
  if (w.holder < 0)
    others_.know_outside(w.at.point, w.at.alpha);
  else if (w.at.is_for_value && way.is_marked)
    far_[w.particle].push_back(w.value);
  else
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "tracer: a step of particle " + std::to_string(particles_.ids[w.particle]) +
                          " goes from " + text_of(particles_.positions[w.particle]) + " to " +
                          text_of(w.at.point) +
                          ", over cells of several processes: shorter steps, such as "
                          "'integrator: {max_step}', do not");
  way.stays = way.stays_here;
  ways_[w.particle] = way;
  todo_.push_back(w.particle);
}

void Rounds::bring_home(std::vector<LeftAt>& left) {
  world_.agree_after([&] {
    ways_.clear();
    std::ranges::sort(left, {}, &LeftAt::particle);
    const auto goes = [&](std::size_t i) {
      const std::int64_t cell = particles_.cells[i];
      if (const auto far = ends_far_.find(i); far != ends_far_.end())
        moving_.push_back({i, far->second.rank, {}});
      else if (cell >= 0 && !homes_.is_own(cell))
        moving_.push_back({i, homes_.name(cell).rank, {}});
    };
    for (std::size_t i = 0; i < particles_.size(); ++i)
      if (particles_.endings[i] == INSITU_END_ALIVE || ends_far_.contains(i) || find_left(left, i))
        goes(i);
  });
  while (sum(std::int64_t(moving_.size())) > 0)
    send(&left);
}

} // namespace insitu::advect
