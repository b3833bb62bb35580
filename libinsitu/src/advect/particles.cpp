#include "advect/particles.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include "core/status.h"

namespace insitu::advect {

std::int64_t Counts::sum() const {
  return std::accumulate(by_ending.begin(), by_ending.end(), std::int64_t(0));
}

Counts& Counts::operator+=(const Counts& b) {
  seeded += b.seeded;
  for (std::size_t e = 0; e < by_ending.size(); ++e)
    by_ending[e] += b.by_ending[e];
  return *this;
}

std::string describe(const Counts& counts) {
  std::string text = std::to_string(counts.seeded) + " seeded = " + std::to_string(counts.alive()) +
                     " " + ending_name(INSITU_END_ALIVE);
  for (std::size_t e = 0; e < counts.by_ending.size(); ++e)
    if (e != std::size_t(INSITU_END_ALIVE) && counts.by_ending[e] > 0)
      text += " + " + std::to_string(counts.by_ending[e]) + " " + ending_name(insitu_ending(e));
  return text;
}

const char* ending_name(insitu_ending ending) {
  switch (ending) {
  case INSITU_END_ALIVE:
    return "alive";
  case INSITU_END_LEFT:
    return "left";
  case INSITU_END_STAGNATED:
    return "stagnated";
  case INSITU_END_EXPIRED:
    return "expired";
  case INSITU_END_STEP_LIMIT:
    return "step_limit";
  case INSITU_END_SEED_OUTSIDE:
    return "seed_outside";
  case INSITU_END_NOT_FINITE:
    return "not_finite";
  case INSITU_END_KILLED:
    return "killed";
  case INSITU_END_STOPPED:
    return "stopped";
  case INSITU_END_REMOVED:
    return "removed";
  case INSITU_END_STEP_TOO_SMALL:
    return "step_too_small";
  case INSITU_END_HOLE:
    return "hole";
  case INSITU_END_HIDDEN:
    return "hidden";
  case INSITU_END_BLANK:
    return "blank";
  case INSITU_END_PARTITION:
    return "partition";
  case INSITU_END_COUNT:
    break;
  }
  return "unknown";
}

Particles::Particles(core::Memory& memory)
    : ids(memory, INSITU_MEMORY_TRACER), positions(memory, INSITU_MEMORY_TRACER),
      cells(memory, INSITU_MEMORY_TRACER), times(memory, INSITU_MEMORY_TRACER),
      seeding_times(memory, INSITU_MEMORY_TRACER), lengths(memory, INSITU_MEMORY_TRACER),
      steps(memory, INSITU_MEMORY_TRACER), endings(memory, INSITU_MEMORY_TRACER),
      fresh(memory, INSITU_MEMORY_TRACER), walk_steps(memory, INSITU_MEMORY_TRACER),
      velocities(memory, INSITU_MEMORY_TRACER), parametric(memory, INSITU_MEMORY_TRACER) {}

template <class F>
void Particles::for_each_array(F&& f) {
  f(ids);
  f(positions);
  f(cells);
  f(times);
  f(seeding_times);
  f(lengths);
  f(steps);
  f(endings);
  f(fresh);
  if (keeps_walk_steps_)
    f(walk_steps);
  if (keeps_velocities_)
    f(velocities);
  if (keeps_parametric_)
    f(parametric);
}

namespace {

constexpr math::Vec3d no_velocity{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};

template <class Array, class Value>
void begin_to_keep(bool& keeps, Array& array, std::size_t size, const Value& value) {
  if (keeps)
    return;
  keeps = true;
  array.resize(size);
  std::fill(array.begin(), array.end(), value);
}

} // namespace

void Particles::keep_walk_steps() {
  begin_to_keep(keeps_walk_steps_, walk_steps, size(), std::int64_t(0));
}
void Particles::keep_velocities() {
  begin_to_keep(keeps_velocities_, velocities, size(), no_velocity);
}
void Particles::keep_parametric() {
  begin_to_keep(keeps_parametric_, parametric, size(), math::Vec3d{});
}

void Particles::reserve(std::size_t more) {
  for_each_array([&](auto& array) {
    const std::size_t n = array.size();
    array.resize(n + more);
    array.resize(n);
  });
}

void Particles::seed(std::span<const math::Vec3d> points, double time) {
  seed(points, time, {});
}

void Particles::seed(std::span<const math::Vec3d> points, double time,
                     std::span<const std::uint8_t> keeps) {
  const auto kept = [&](std::size_t p) { return keeps.empty() || keeps[p] != 0; };
  std::size_t i = size(), more = 0;
  for (std::size_t p = 0; p < points.size(); ++p)
    more += kept(p);
  reserve(more);
  for_each_array([&](auto& array) { array.resize(i + more); });
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (!kept(p))
      continue;
    set(i++, {seeded_ + std::int64_t(p), points[p], -1, time, time, 0.0, 0.0, INSITU_END_ALIVE, 1,
              0, no_velocity});
  }
  seeded_ += std::int64_t(points.size());
  here_ += std::int64_t(more);
}

void Particles::set(std::size_t i, const Record& from) {
  ids[i] = from.id;
  positions[i] = from.position;
  cells[i] = from.cell;
  times[i] = from.time;
  seeding_times[i] = from.seeding_time;
  lengths[i] = from.length;
  steps[i] = from.step;
  endings[i] = from.ending;
  fresh[i] = from.fresh;
  if (keeps_walk_steps_)
    walk_steps[i] = from.walk_steps;
  if (keeps_velocities_)
    velocities[i] = from.velocity;
  if (keeps_parametric_)
    parametric[i] = {};
}

Particles::Record Particles::record(std::size_t i) const {
  return {ids[i],
          positions[i],
          cells[i],
          times[i],
          seeding_times[i],
          lengths[i],
          steps[i],
          endings[i],
          fresh[i],
          keeps_walk_steps_ ? walk_steps[i] : 0,
          keeps_velocities_ ? velocities[i] : no_velocity};
}

void Particles::leave(std::size_t i) {
  endings[i] = gone;
  --here_;
}

void Particles::arrive(const Record& from) {
  const std::size_t i = size();
  try {
    for_each_array([&](auto& array) { array.resize(i + 1); });
  } catch (...) {
    for_each_array([&](auto& array) { array.resize(i); });
    throw;
  }
  set(i, from);
  ++here_;
}

void Particles::take_back_to(std::size_t to) {
  here_ -= std::int64_t(size() - to);
  for_each_array([&](auto& array) { array.resize(to); });
}

void Particles::drop_gone() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < size(); ++i)
    if (endings[i] != gone) {
      if (kept != i)
        for_each_array([&](auto& array) { array[kept] = array[i]; });
      ++kept;
    }
  for_each_array([&](auto& array) { array.resize(kept); });
}

void Particles::begin_all(const Particles& here, std::span<const std::int64_t> dropped) {
  keeps_walk_steps_ = here.keeps_walk_steps_;
  keeps_velocities_ = here.keeps_velocities_;
  keeps_parametric_ = here.keeps_parametric_;
  seeded_ = here.seeded_;
  std::ranges::copy(dropped, dropped_.by_ending.begin());
  here_ = dropped_.sum();
}

void Particles::keep_common(core::Archive& archive) {
  archive.value("keeps walk steps", keeps_walk_steps_);
  archive.value("keeps velocities", keeps_velocities_);
  archive.value("keeps parametric coordinates", keeps_parametric_);
  archive.value("seeded", seeded_);
}

void Particles::keep(core::Archive& archive) {
  for_each_array([&](auto& array) { archive.array("particles", array); });
  archive.value("dropped", dropped_.by_ending);
  here_ = dropped_.sum() + std::int64_t(size());
}

void Particles::kill() {
  for (std::uint8_t& ending : endings)
    if (ending == INSITU_END_ALIVE)
      ending = INSITU_END_KILLED;
}

void Particles::leave_cells_of_ended() {
  for (std::size_t i = 0; i < size(); ++i)
    if (endings[i] != INSITU_END_ALIVE)
      cells[i] = -1;
}

void Particles::drop_ended() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    if (endings[i] != INSITU_END_ALIVE) {
      if (endings[i] != gone)
        ++dropped_.by_ending[endings[i]];
      continue;
    }
    for_each_array([&](auto& array) { array[kept] = array[i]; });
    ++kept;
  }
  for_each_array([&](auto& array) { array.resize(kept); });
}

Counts Particles::counts() const {
  Counts c = dropped_;
  c.seeded = here_;
  for (const std::uint8_t ending : endings)
    if (ending < INSITU_END_COUNT)
      ++c.by_ending[ending];
  if (c.sum() != c.seeded)
    throw core::Error(INSITU_ERROR_INTERNAL, "tracer: " + std::to_string(c.seeded) +
                                                 " particles were seeded, but " +
                                                 std::to_string(c.sum()) + " are accounted for");
  return c;
}

State Particles::state(std::size_t i) const {
  State s;
  s.x = positions[i];
  s.time = times[i];
  s.step = steps[i];
  s.length = lengths[i];
  s.fresh = fresh[i] != 0;
  return s;
}

void Particles::set_state(std::size_t i, const State& s, std::int64_t cell) {
  positions[i] = s.x;
  times[i] = s.time;
  steps[i] = s.step;
  lengths[i] = s.length;
  fresh[i] = s.fresh;
  cells[i] = cell;
}

Carried Particles::carried(std::size_t i) const {
  Carried c;
  c.id = ids[i];
  if (keeps_walk_steps_)
    c.walk_steps = walk_steps[i];
  if (keeps_velocities_)
    c.velocity = velocities[i];
  return c;
}

void Particles::set_carried(std::size_t i, const Carried& carried) {
  if (keeps_walk_steps_)
    walk_steps[i] = carried.walk_steps;
  if (keeps_velocities_)
    velocities[i] = carried.velocity;
}

} // namespace insitu::advect
