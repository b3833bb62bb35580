#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "render/camera/camera.h"
#include "render/processes/frame_tiles.h"
#include "scaling/cost_model.h"

/// Frames of the cost model: rays are cut by the parts' boxes.
namespace insitu::bench::scaling {

using math::Vec3d;
using render::FrameTile;

namespace {

constexpr double hit = 80, run = 6, sample = 8, of_cell = 4 + 8, pixel = 16, parcel = 8 + 4;
constexpr double composite = 20; // a stretch of a ray in one process's cells
constexpr int round_depth = 32, composited_depth = 128, tiles_a_group = 16;

struct Stretch {
  double from, to;
};
std::optional<Stretch> stretch_in(const render::Ray& ray, const Vec3d& low, const Vec3d& high) {
  Stretch in{0, HUGE_VAL};
  for (int a = 0; a < 3; ++a) {
    const double one = (low[a] - ray.origin[a]) / ray.direction[a];
    const double other = (high[a] - ray.origin[a]) / ray.direction[a];
    in.from = std::max(in.from, std::min(one, other));
    in.to = std::min(in.to, std::max(one, other));
  }
  return in.from < in.to ? std::optional(in) : std::nullopt;
}

/// The parcels of one exchange.
class Mail {
public:
  void add(int from, int to, double bytes) {
    if (from == to)
      return;
    pairs_.insert({from, to});
    ++cost_.messages;
    cost_.bytes += bytes + parcel;
  }
  Cost cost() const {
    Cost cost = cost_;
    cost.exchanges = 1;
    cost.messages += double(pairs_.size());
    return cost;
  }

private:
  Cost cost_;
  std::set<std::pair<int, int>> pairs_;
};

/// What a process sees of a tile.
struct Seen {
  bool is_near = false;
  double hits = 0, thin = 0;
  std::vector<double> bytes; ///< [round]
};

class Frame {
public:
  Frame(const Layout& layout, const render::FrameSettings& settings)
      : layout_(layout), rays_(settings.camera, settings.width, settings.height),
        groups_(render::tile_groups(settings.width, settings.height, layout.processes,
                                    tiles_a_group)) {}

  /// see(ray, stretch, low, high, seen, cost): of each ray of a tile, each part that it crosses.
  template <class See>
  Cost draw(See&& see) const {
    Cost cost;
    for (const std::vector<FrameTile>& group : groups_) {
      Mail hits, thin, pixels;
      bool has_thin = false;
      std::vector<Mail> rounds;
      std::size_t first = SIZE_MAX;
      for (const FrameTile& tile : group) {
        for (int rank = 0; rank < layout_.processes; ++rank) {
          const Layout::Part part = layout_.part(rank);
          const Vec3d low = layout_.low(part), high = layout_.high(part);
          Seen seen;
          tile.for_each_ray([&](std::size_t, int x, int y) {
            const render::Ray ray = rays_(x, y);
            if (const auto in = stretch_in(ray, low, high)) {
              seen.is_near = true;
              see(ray, *in, low, high, seen, cost);
            }
          });
          if (seen.is_near)
            hits.add(rank, tile.owner, hit * seen.hits);
          if (seen.thin > 0)
            thin.add(rank, tile.owner, (run + of_cell + sample) * seen.thin);
          has_thin = has_thin || seen.thin > 0;
          rounds.resize(std::max(rounds.size(), seen.bytes.size()));
          for (std::size_t r = 0; r < seen.bytes.size(); ++r)
            if (seen.bytes[r] > 0) {
              rounds[r].add(rank, tile.owner, seen.bytes[r]);
              first = std::min(first, r);
            }
        }
        pixels.add(tile.owner, 0, pixel * double(tile.rays()));
      }
      cost += hits.cost();
      cost += pixels.cost();
      if (has_thin)
        cost += thin.cost();
      for (std::size_t r = first; r < rounds.size(); ++r) {
        cost += rounds[r].cost();
        if (r + 1 < rounds.size())
          ++cost.exchanges; // which rays are saturated: none
      }
    }
    return cost;
  }

private:
  const Layout& layout_;
  render::RayGenerator rays_;
  std::vector<std::vector<FrameTile>> groups_;
};

} // namespace

namespace {

/// bytes_of(count): of so many samples of a ray in a round of `depth`.
template <class BytesOf>
Cost marched(const Layout& layout, const render::FrameSettings& settings, double step, int depth,
             BytesOf&& bytes_of) {
  const Frame frame(layout, settings);
  return frame.draw([&](const render::Ray& ray, const Stretch& in, const Vec3d&, const Vec3d&,
                        Seen& seen, Cost& cost) {
    const auto first = std::int64_t(std::ceil(in.from / step - 0.5));
    const auto end = std::int64_t(std::ceil(in.to / step - 0.5));
    if (first >= end) { // if it is so in the whole mesh, there is one sample in the middle
      const Stretch whole = *stretch_in(ray, {}, layout.size());
      const double middle = 0.5 * (whole.from + whole.to);
      seen.thin += std::ceil(whole.from / step - 0.5) >= std::ceil(whole.to / step - 0.5) &&
                   middle >= in.from && middle < in.to;
    }
    for (std::int64_t from = first; from < end;) {
      const std::int64_t round = from / depth, to = std::min(end, (round + 1) * depth);
      seen.bytes.resize(std::max(seen.bytes.size(), std::size_t(round) + 1));
      seen.bytes[std::size_t(round)] += bytes_of(double(to - from));
      from = to;
    }
    cost.items += double(end - first);
  });
}

} // namespace

Cost drawn_volume(const Layout& layout, const render::FrameSettings& settings, double step) {
  return marched(layout, settings, step, round_depth,
                 [](double count) { return run + sample * count; });
}

Cost composited_volume(const Layout& layout, const render::FrameSettings& settings, double step) {
  return marched(layout, settings, step, composited_depth, [](double) { return composite; });
}

Cost drawn_sphere(const Layout& layout, const render::FrameSettings& settings, const Vec3d& centre,
                  double radius) {
  const Frame frame(layout, settings);
  return frame.draw([&](const render::Ray& ray, const Stretch&, const Vec3d& low, const Vec3d& high,
                        Seen& seen, Cost& cost) {
    const Vec3d from = ray.origin - centre;
    const double b = dot(from, ray.direction), c = dot(from, from) - radius * radius;
    if (b * b <= c)
      return;
    for (const double sign : {-1.0, 1.0}) {
      const Vec3d x = ray.origin + (sign * std::sqrt(b * b - c) - b) * ray.direction;
      bool is_here = true;
      for (int a = 0; a < 3; ++a)
        is_here = is_here && x[a] >= low[a] && x[a] < high[a];
      seen.hits += is_here;
      cost.items += is_here;
    }
  });
}

} // namespace insitu::bench::scaling
