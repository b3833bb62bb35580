#include "advect/streamlines.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "advect/chart_velocity.h"
#include "advect/check.h"
#include "advect/even_spacing.h"
#include "advect/lanes.h"

namespace insitu::advect {

namespace {

struct Vertex {
  math::Vec3d point;
  double time;
  std::int64_t cell;
};

/// A line under way.
struct Line {
  State p;
  std::vector<Vertex> vertices;
};

/// Keeps vertices of a line: those of its steps, at least `spacing` cells apart, or points at even
/// distances.
template <class Velocity>
class LineVertices {
public:
  LineVertices(Velocity& velocity, const query::Sampler& sampler,
               const StreamlineSettings& settings, std::vector<Vertex>& vertices)
      : velocity_(velocity), sampler_(sampler), settings_(settings), vertices_(vertices),
        even_(velocity, settings.even_time, settings.even_length, *this) {
    vertices.clear();
  }
  LineVertices(const LineVertices&) = delete;

  bool is_even() const { return settings_.even_time > 0.0 || settings_.even_length > 0.0; }
  EvenSpacing<Velocity, LineVertices>& even() { return even_; }

  /// As visitor of integrate().
  void operator()(const State& s) {
    if (vertices_.empty() || cells_crossed(s.x - last_, velocity_.extent()) >= settings_.spacing)
      add(s);
  }
  /// A point at an even distance.
  void operator()(const math::Vec3d& x, double time) {
    const math::Vec3d point = velocity_.position(x);
    const query::Location at = sampler_.locate(point, velocity_.cell(), {settings_.accuracy});
    vertices_.push_back({point, time, at.cell});
  }

  /// The last vertex is the line's end, p, whatever the spacing.
  insitu_ending finish(const State& p, insitu_ending ending) {
    if (!is_even()) {
      if (!vertices_.empty() && p.x != last_)
        add(p);
    } else if (vertices_.size() > 1 && even_.since_last(p) < 1e-3) {
      vertices_.back() = {velocity_.position(p.x), p.time, velocity_.cell()};
    } else if (!vertices_.empty() && p.time != vertices_.back().time) {
      add(p);
    }
    return ending == INSITU_END_ALIVE ? INSITU_END_EXPIRED : ending;
  }

private:
  void add(const State& s) {
    vertices_.push_back({velocity_.position(s.x), s.time, velocity_.cell()});
    last_ = s.x;
  }

  Velocity& velocity_;
  const query::Sampler& sampler_;
  const StreamlineSettings& settings_;
  std::vector<Vertex>& vertices_;
  EvenSpacing<Velocity, LineVertices> even_;
  math::Vec3d last_; ///< as the integrator has it; after a change of its coordinates it is far away
};

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

  const std::int64_t grain = std::clamp<std::int64_t>(count / (4 * threads.count()), 16, 256);
  std::vector<Work> work(std::size_t((count + grain - 1) / grain));
  std::vector<std::vector<Vertex>> vertices_of(static_cast<std::size_t>(count));
  const auto time_of = [&](std::int64_t l) {
    const bool backward = settings.direction == Direction::backward || l % per_seed == 1;
    return backward ? -settings.duration : settings.duration;
  };
  const auto seed_of = [&](std::int64_t l) { return std::size_t(l / per_seed); };
  const auto store = [&](std::int64_t l, const Line& line, insitu_ending ending) {
    vertices_of[std::size_t(l)] = line.vertices;
    lines.endings[std::size_t(l)] = std::uint8_t(ending);
    lines.particles[std::size_t(l)] = std::int64_t(seed_of(l));
    lines.offsets[std::size_t(l) + 1] = std::int64_t(line.vertices.size());
  };
  const auto trace_on_chart = [&](std::int64_t begin, std::int64_t end) {
    ChartVelocity field(sampler, velocity, nullptr, 0.0, 0.0, settings.accuracy);
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
          to.emplace_back(sampler, velocity, nullptr, 0.0, 0.0, settings.accuracy);
        },
        [&](std::int64_t l, std::size_t slot, LaneVelocity& field) {
          Line& line = under_way[slot];
          field.begin(-1);
          line.p = {};
          line.p.x = seeds[seed_of(l)];
          vertices[slot].emplace(field, sampler, steady, line.vertices);
          const auto run = [&](auto& visit) {
            return integration(field, steady.integrator, time_of(l), settings.length, line.p, cost,
                               std::ref(visit));
          };
          return vertices[slot]->is_even() ? run(vertices[slot]->even()) : run(*vertices[slot]);
        },
        [&](std::int64_t l, std::size_t slot, LaneVelocity&, insitu_ending ending) {
          Line& line = under_way[slot];
          store(l, line, vertices[slot]->finish(line.p, ending));
        });
  };
  threads.parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    sampler.chart() ? trace_on_chart(begin, end) : trace_in_lanes(begin, end);
  });

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
  for (const std::vector<Vertex>& line : vertices_of)
    for (const Vertex& vertex : line) {
      lines.points[v] = vertex.point;
      lines.times[v] = vertex.time;
      lines.cells[v] = vertex.cell;
      ++v;
    }
  for (const Work& w : work)
    result.work += w;
  return result;
}

} // namespace insitu::advect
