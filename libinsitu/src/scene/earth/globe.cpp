#include "scene/earth/globe.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "geo/reference_frames.h"
#include "parallel/bytes.h"
#include "scene/earth/reference_frames.h"

namespace insitu::scene {

namespace {

using math::Vec3d;

// WGS84, National Geospatial-Intelligence Agency standard 0036 (2014).
constexpr double equatorial = 6378137.0;
constexpr double polar = equatorial * (1 - 1 / 298.257223563);

constexpr std::int64_t rows_at_once = 64; ///< so that scratch is bounded
constexpr std::int64_t grain = 1 << 12;

/// How far along the ray the ellipsoid is first met from outside; infinite if it is not.
double distance_to_ellipsoid(const render::Ray& ray) {
  const Vec3d o{ray.origin.x / equatorial, ray.origin.y / equatorial, ray.origin.z / polar};
  const Vec3d d{ray.direction.x / equatorial, ray.direction.y / equatorial,
                ray.direction.z / polar};
  const double dd = dot(d, d), od = dot(o, d);
  const double root = od * od - dd * (dot(o, o) - 1);
  const double distance = root < 0 ? HUGE_VAL : (-od - std::sqrt(root)) / dd;
  return distance > 0 ? distance : HUGE_VAL;
}

/// Of what is drawn, along one ray.
struct Seen {
  double distance; ///< to the ellipsoid
  double facing;   ///< cosine between the way back to the viewer and the vertical
  Vec3d place;     ///< longitude, latitude, height 0
};

class GlobePainter {
public:
  GlobePainter(const Geocentric& frame, const commit::CommittedMesh& own,
               const render::FrameSettings& settings, parallel::World& world,
               core::Context& context, render::FrameImages& images)
      : frame_(frame), own_(own), width_(settings.width), height_(settings.height),
        rays_(settings.camera, settings.width, settings.height), world_(world), context_(context),
        images_(images), has_volume_(settings.volume.has_value()),
        seen_(context.memory, INSITU_MEMORY_FRAME), points_(context.memory, INSITU_MEMORY_FRAME),
        locations_(context.memory, INSITU_MEMORY_FRAME) {
    if (frame_.globe)
      land_ = *frame_.globe;
  }

  void paint() {
    for (std::int64_t row = 0; row < height_; row += rows_at_once) {
      const std::int64_t rows = std::min(rows_at_once, height_ - row);
      world_.agree_after([&] {
        if (world_.is_root() || frame_.globe)
          look(row, std::min(rows + 1, height_ - row)); // and the row below, for lines between them
        if (frame_.globe)
          locate(rows);
      });
      if (frame_.globe)
        add_covered();
      if (world_.is_root())
        context_.threads.parallel_for(rows * width_, grain,
                                      [&](std::int64_t begin, std::int64_t end) {
                                        for (std::int64_t i = begin; i < end; ++i)
                                          paint_pixel(row, i);
                                      });
      rows_seen_ = 0;
    }
  }

private:
  void look(std::int64_t row, std::int64_t rows) {
    seen_.resize_discard(std::size_t(rows * width_));
    rows_seen_ = rows;
    context_.threads.parallel_for(rows * width_, grain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const render::Ray ray = rays_(int(i % width_), int(row + i / width_));
        Seen& seen = seen_[std::size_t(i)];
        seen.distance = distance_to_ellipsoid(ray);
        seen.place = {NAN, NAN, NAN};
        if (!std::isfinite(seen.distance))
          continue;
        const Vec3d p = ray.origin + seen.distance * ray.direction;
        const Vec3d normal{p.x / (equatorial * equatorial), p.y / (equatorial * equatorial),
                           p.z / (polar * polar)};
        seen.facing = -dot(ray.direction, normal) / std::sqrt(dot(normal, normal));
        seen.place = p;
        const std::span<Vec3d> one(&seen.place, 1);
        geo::from_geocentric(geo::Frame::geodetic(), one, one);
        seen.place.z = 0;
      }
    });
  }

  /// Which places this process's cells cover.
  void locate(std::int64_t rows) {
    const auto count = std::size_t(rows * width_);
    insitu_frame geodetic = insitu_frame_default();
    geodetic.kind = INSITU_FRAME_GEODETIC;
    points_.resize_discard(count);
    context_.threads.parallel_for(
        std::int64_t(count), grain, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i)
            points_[std::size_t(i)] = seen_[std::size_t(i)].place;
          convert_points({points_.data() + begin, std::size_t(end - begin)}, geodetic,
                         own_.reference_frame);
        });
    locations_.resize_discard(count);
    own_.own_sampler().locate(context_.threads, {points_.data(), count},
                              {locations_.data(), count});
    covered_.assign((count + 63) / 64, 0);
    const std::int64_t cells = own_.mesh().view().own_cell_count();
    for (std::size_t i = 0; i < count; ++i)
      covered_[i / 64] |= std::uint64_t(locations_[i] && locations_[i].cell < cells) << (i % 64);
  }

  /// Gives the root the places that other processes cover, a bit each.
  void add_covered() {
    if (world_.size() == 1)
      return;
    std::vector<parallel::Parcel> mine;
    world_.agree_after([&] {
      if (!world_.is_root())
        mine.push_back({0, parallel::bytes_of(covered_)});
    });
    for (const parallel::Parcel& parcel : world_.exchange(mine)) {
      const auto theirs = parallel::items_of<std::uint64_t>(parcel.bytes);
      std::ranges::transform(covered_, theirs, covered_.begin(), std::bit_or());
    }
  }

  void paint_pixel(std::int64_t row, std::int64_t i) {
    const Seen& seen = seen_[std::size_t(i)];
    if (!std::isfinite(seen.distance))
      return;
    const auto at = std::size_t(row * width_ + i);
    // Before the ellipsoid by more than the depth image's rounding.
    if (double(images_.depth[at]) < seen.distance * (1 - 1e-6))
      return;
    float* pixel = images_.color.pixel(int(i % width_), int(row + i / width_));
    // Edges of facets sag, and surfaces in the sea need not fill it: what is behind is land as
    // well.
    const bool nothing = !has_volume_ && !std::isfinite(images_.depth[at]);
    if (frame_.globe && (nothing || !covers(std::size_t(i)))) {
      const render::Color color = float(0.35 + 0.65 * seen.facing) * land_;
      set(pixel, color, 1);
      pixel[3] = 1;
      images_.depth[at] = float(seen.distance);
      if (!images_.cell.empty())
        images_.cell[at] = -1;
    }
    if (frame_.graticule && has_line(i))
      set(pixel, {0.02f, 0.02f, 0.02f}, 0.5f);
  }

  static void set(float* pixel, const render::Color& color, float opacity) {
    pixel[0] += opacity * (color.r - pixel[0]);
    pixel[1] += opacity * (color.g - pixel[1]);
    pixel[2] += opacity * (color.b - pixel[2]);
  }

  /// Between this pixel and the one to the right, or the one below, a multiple is passed.
  bool has_line(std::int64_t i) const {
    const auto differs = [&](std::int64_t j) {
      const Vec3d &a = seen_[std::size_t(i)].place, &b = seen_[std::size_t(j)].place;
      return std::isfinite(b.x) && (step(a.x) != step(b.x) || step(a.y) != step(b.y));
    };
    return (i % width_ + 1 < width_ && differs(i + 1)) ||
           (i / width_ + 1 < rows_seen_ && differs(i + width_));
  }
  bool covers(std::size_t i) const { return covered_[i / 64] >> (i % 64) & 1U; }
  double step(double angle) const { return std::floor(angle / *frame_.graticule); }

  const Geocentric& frame_;
  const commit::CommittedMesh& own_;
  const std::int64_t width_, height_;
  const render::RayGenerator rays_;
  parallel::World& world_;
  core::Context& context_;
  render::FrameImages& images_;
  const bool has_volume_;
  render::Color land_;
  std::int64_t rows_seen_ = 0;
  core::Buffer<Seen> seen_;
  core::Buffer<Vec3d> points_;
  core::Buffer<query::Location> locations_;
  std::vector<std::uint64_t> covered_; ///< a bit a place
};

} // namespace

const std::int64_t globe_bytes_a_pixel = sizeof(Seen) + sizeof(Vec3d) + sizeof(query::Location);

void draw_globe(const Geocentric& frame, const commit::CommittedMesh& own,
                const render::FrameSettings& settings, parallel::World& world,
                core::Context& context, render::FrameImages& images) {
  GlobePainter(frame, own, settings, world, context, images).paint();
}

} // namespace insitu::scene
