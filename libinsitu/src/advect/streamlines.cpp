#include "advect/streamlines.h"

#include <algorithm>
#include <type_traits>
#include <vector>

#include "advect/chart_velocity.h"
#include "advect/check.h"
#include "advect/even_spacing.h"
#include "advect/mesh_velocity.h"

namespace insitu::advect {

namespace {

struct Vertex {
  math::Vec3d point;
  double time;
  std::int64_t cell;
};

/// The lines of one chunk of particles, until all are put together.
struct Chunk {
  std::vector<Vertex> vertices;
  Work work;
};

/// One with vertices at even distances.
template <class Velocity>
insitu_ending trace_evenly(Velocity& velocity, const query::Sampler& sampler,
                           const StreamlineSettings& settings, State p, double to, Chunk& chunk) {
  const std::size_t first = chunk.vertices.size();
  const auto put = [&](const math::Vec3d& x, double time) {
    const math::Vec3d point = velocity.position(x);
    const query::Location at = sampler.locate(point, velocity.cell(), {settings.accuracy});
    chunk.vertices.push_back({point, time, at.cell});
  };
  EvenSpacing visit(velocity, settings.even_time, settings.even_length, put);
  insitu_ending ending =
      integrate(velocity, settings.integrator, to, settings.length, p, chunk.work, visit);
  if (ending == INSITU_END_ALIVE)
    ending = INSITU_END_EXPIRED;
  if (chunk.vertices.size() == first)
    return ending;
  if (chunk.vertices.size() > first + 1 && visit.since_last(p) < 1e-3)
    chunk.vertices.pop_back();
  else if (p.time == chunk.vertices.back().time)
    return ending; // it never moved
  chunk.vertices.push_back({velocity.position(p.x), p.time, velocity.cell()});
  return ending;
}

/// Appends one line to the chunk's vertices.
template <class Velocity>
insitu_ending trace(Velocity& velocity, const query::Sampler& sampler,
                    const StreamlineSettings& settings, const math::Vec3d& seed, double to,
                    Chunk& chunk) {
  State p;
  const std::size_t first = chunk.vertices.size();
  velocity.begin(-1);
  p.x = velocity.enter(seed);
  if (settings.even_time > 0.0 || settings.even_length > 0.0)
    return trace_evenly(velocity, sampler, settings, p, to, chunk);
  math::Vec3d last; // as the integrator has it; after a change of its coordinates it is far away
  const auto visit = [&](const State& s) {
    if (chunk.vertices.size() == first ||
        cells_crossed(s.x - last, velocity.extent()) >= settings.spacing) {
      chunk.vertices.push_back({velocity.position(s.x), s.time, velocity.cell()});
      last = s.x;
    }
  };
  insitu_ending ending =
      integrate(velocity, settings.integrator, to, settings.length, p, chunk.work, visit);
  if (ending == INSITU_END_ALIVE)
    ending = INSITU_END_EXPIRED;
  if (chunk.vertices.size() > first && p.x != last)
    chunk.vertices.push_back({velocity.position(p.x), p.time, velocity.cell()});
  return ending;
}

} // namespace

Streamlines trace_streamlines(const query::Sampler& sampler, const mesh::FieldView& velocity,
                              std::span<const math::Vec3d> seeds,
                              const StreamlineSettings& settings, const core::Threads& threads,
                              core::Memory& memory) {
  check_velocity(velocity);
  StreamlineSettings steady = settings;
  check_settings(settings.integrator);
  steady.integrator = settings_for(velocity, settings.integrator);
  steady.integrator.ends_at_rest = true;

  Streamlines result{Polylines(memory), {}, {}};
  Polylines& lines = result.lines;
  const std::int64_t per_seed = settings.direction == Direction::both ? 2 : 1;
  const std::int64_t count = std::int64_t(seeds.size()) * per_seed;
  lines.offsets.resize_discard(std::size_t(count) + 1);
  lines.particles.resize_discard(std::size_t(count));
  lines.endings.resize_discard(std::size_t(count));

  constexpr std::int64_t grain = 16;
  std::vector<Chunk> chunks(std::size_t((count + grain - 1) / grain));
  const auto trace_all = [&]<class Velocity>(std::type_identity<Velocity>) {
    threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      Chunk& chunk = chunks[std::size_t(begin / grain)];
      Velocity field(sampler, velocity, nullptr, 0.0, 0.0, settings.accuracy);
      for (std::int64_t l = begin; l < end; ++l) {
        const std::size_t seed = std::size_t(l / per_seed);
        const bool backward = settings.direction == Direction::backward || l % per_seed == 1;
        const std::size_t before = chunk.vertices.size();
        lines.endings[std::size_t(l)] =
            std::uint8_t(trace(field, sampler, steady, seeds[seed],
                               backward ? -settings.duration : settings.duration, chunk));
        lines.particles[std::size_t(l)] = std::int64_t(seed);
        lines.offsets[std::size_t(l) + 1] = std::int64_t(chunk.vertices.size() - before);
      }
    });
  };
  check_chart(sampler, steady.integrator);
  if (sampler.chart())
    trace_all(std::type_identity<ChartVelocity>());
  else
    trace_all(std::type_identity<MeshVelocity>());

  lines.offsets[0] = 0;
  for (std::size_t l = 0; l < std::size_t(count); ++l) {
    lines.offsets[l + 1] += lines.offsets[l];
    ++result.counts.by_ending[lines.endings[l]];
  }
  result.counts.seeded = count;
  const std::size_t vertices = std::size_t(lines.offsets[std::size_t(count)]);
  lines.points.resize_discard(vertices);
  lines.times.resize_discard(vertices);
  lines.cells.resize_discard(vertices);
  std::size_t v = 0;
  for (Chunk& chunk : chunks) {
    for (const Vertex& vertex : chunk.vertices) {
      lines.points[v] = vertex.point;
      lines.times[v] = vertex.time;
      lines.cells[v] = vertex.cell;
      ++v;
    }
    result.work += chunk.work;
    chunk.vertices = {};
  }
  return result;
}

} // namespace insitu::advect
