#include "advect/lines/streamlines.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "advect/effects/mover.h"
#include "advect/field/chart_velocity.h"
#include "advect/integrate/check.h"
#include "advect/integrate/integrations.h"
#include "advect/lanes/lanes.h"
#include "advect/lines/line_recorder.h"
#include "advect/lines/line_vertices.h"

namespace insitu::advect {

namespace {

/// A line under way.
struct Line {
  State p;
  std::vector<LineVertex> vertices;
};

} // namespace

Streamlines trace_streamlines(const query::Sampler& sampler, const mesh::FieldView& velocity,
                              std::span<const math::Vec3d> seeds,
                              const StreamlineSettings& settings, const core::Threads& threads,
                              core::Memory& memory) {
  check_velocity(velocity, sampler.mesh());
  StreamlineSettings steady = settings;
  check_settings(settings.integrator);
  check_line_effects(settings);
  steady.integrator = settings_for(velocity, settings.integrator);
  steady.integrator.ends_at_rest = true;

  Streamlines result{Polylines(memory), {}, {}, {}};
  Polylines& lines = result.lines;
  const std::int64_t per_seed = settings.direction == Direction::both ? 2 : 1;
  const std::int64_t count = std::int64_t(seeds.size()) * per_seed;
  lines.offsets.resize_discard(std::size_t(count) + 1);
  lines.particles.resize_discard(std::size_t(count));
  lines.endings.resize_discard(std::size_t(count));

  const std::int64_t grain = std::clamp<std::int64_t>(count / (4 * threads.count()), 16, 1024);
  std::vector<Work> work(std::size_t((count + grain - 1) / grain));
  std::vector<std::vector<LineVertex>> vertices_of(static_cast<std::size_t>(count));
  const auto time_of = [&](std::int64_t l) {
    const bool backward = settings.direction == Direction::backward || l % per_seed == 1;
    return backward ? -settings.duration : settings.duration;
  };
  const auto seed_of = [&](std::int64_t l) { return std::size_t(l / per_seed); };
  std::vector<Vec3d> normals(settings.exits ? std::size_t(count) : 0);
  const auto store = [&](std::int64_t l, const Line& line, insitu_ending ending) {
    vertices_of[std::size_t(l)] = line.vertices;
    lines.endings[std::size_t(l)] = std::uint8_t(ending);
    lines.particles[std::size_t(l)] = std::int64_t(seed_of(l));
    if (settings.exits)
      normals[std::size_t(l)] = line.p.exit_normal;
    lines.offsets[std::size_t(l) + 1] = std::int64_t(line.vertices.size());
  };
  const std::unique_ptr<const CellsBeyond> beyond = CellsBeyond::worth(sampler, count);
  const auto trace_on_chart = [&](std::int64_t begin, std::int64_t end) {
    ChartVelocity field(sampler, velocity, nullptr, 0.0, 0.0, settings.accuracy);
    field.walk_by(beyond.get());
    Work& cost = work[std::size_t(begin / grain)];
    Line line;
    for (std::int64_t l = begin; l < end; ++l) {
      field.begin(-1);
      line.p = {};
      line.p.x = field.enter(seeds[seed_of(l)]);
      LineVertices vertices(field, sampler, steady, line.vertices);
      const auto run = [&](auto& visit) {
        return integrate(field, steady.integrator, time_of(l), settings.length, line.p, cost,
                         visit);
      };
      const insitu_ending ending = vertices.is_even() ? run(vertices.even()) : run(vertices);
      store(l, line, vertices.finish(line.p, ending));
    }
  };
  const auto trace_in_lanes = [&](std::int64_t begin, std::int64_t end) {
    Work& cost = work[std::size_t(begin / grain)];
    std::vector<Line> under_way(LaneBatch::lane_count);
    std::deque<std::optional<LineVertices<LaneVelocity>>> vertices(LaneBatch::lane_count);
    run_lanes(
        sampler, begin, end,
        [&](std::deque<LaneVelocity>& to) {
          to.emplace_back(sampler, velocity, nullptr, 0.0, 0.0, settings.accuracy)
              .walk_by(beyond.get());
        },
        [&](std::int64_t l, std::size_t slot, LaneVelocity& field) {
          Line& line = under_way[slot];
          field.begin(-1);
          line.p = {};
          line.p.x = seeds[seed_of(l)];
          vertices[slot].emplace(field, sampler, steady, line.vertices);
          const auto run = [&](auto& visit) {
            return integration(field, steady.integrator, time_of(l), settings.length, line.p, cost,
                               Visitor(visit));
          };
          return vertices[slot]->is_even() ? run(vertices[slot]->even()) : run(*vertices[slot]);
        },
        [&](std::int64_t l, std::size_t slot, LaneVelocity&, const Stepping& stepping) {
          Line& line = under_way[slot];
          store(l, line, vertices[slot]->finish(line.p, stepping.ending()));
        });
  };
  const std::optional<EffectSetup> setup =
      settings.effects.any()
          ? std::optional<EffectSetup>(std::in_place, settings.effects, sampler, threads)
          : std::nullopt;
  std::vector<EffectWork> effect_work(setup ? work.size() : 0);
  const auto trace_moved = [&]<class V>(std::type_identity<V>, std::int64_t begin,
                                        std::int64_t end) {
    V field(sampler, velocity, nullptr, 0.0, 0.0, settings.accuracy, setup->effects.drifts);
    field.walk_by(beyond.get());
    Mover<V> mover(*setup, field, steady.integrator, settings.length);
    Line line;
    for (std::int64_t l = begin; l < end; ++l) {
      line.p = {};
      line.p.x = field.enter(seeds[seed_of(l)]);
      LineRecorder<V> recorder(field, sampler, steady, setup->sides, line.vertices);
      mover.take(&recorder);
      Carried carried;
      carried.id = l;
      carried.velocity.x = std::numeric_limits<double>::quiet_NaN();
      const insitu_ending ending =
          mover.advance(line.p, -1, carried, time_of(l), work[std::size_t(begin / grain)]);
      store(l, line, recorder.finish(line.p, mover.cell(), ending));
    }
    effect_work[std::size_t(begin / grain)] = mover.effect_work();
  };
  threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    if (setup)
      return sampler.chart() ? trace_moved(std::type_identity<ChartVelocity>(), begin, end)
                             : trace_moved(std::type_identity<DriftVelocity>(), begin, end);
    sampler.chart() ? trace_on_chart(begin, end) : trace_in_lanes(begin, end);
  });

  for (std::size_t l = 0; l < normals.size(); ++l) {
    const bool seeded = lines.endings[l] == INSITU_END_SEED_OUTSIDE;
    if (!seeded && lines.endings[l] != INSITU_END_LEFT)
      continue;
    LeftAt at{l, seeds[seed_of(std::int64_t(l))], -1, normals[l], 1.0, seeded};
    if (!seeded && !vertices_of[l].empty()) {
      at.x = vertices_of[l].back().point;
      at.cell = vertices_of[l].back().cell;
    }
    lines.endings[l] = std::uint8_t(settings.exits->ending(sampler, at));
  }
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
  for (const std::vector<LineVertex>& line : vertices_of)
    for (const LineVertex& vertex : line) {
      lines.points[v] = vertex.point;
      lines.times[v] = vertex.time;
      lines.cells[v] = vertex.cell;
      ++v;
    }
  for (const Work& w : work)
    result.work += w;
  for (const EffectWork& w : effect_work)
    result.effects += w;
  return result;
}

} // namespace insitu::advect
