#include "scene/tracers/track_geodesics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geo/geodesic.h"
#include "scene/earth/reference_frames.h"

namespace insitu::scene {

namespace {

bool is_place(const math::Vec3d& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

math::Vec3d to_degrees(const math::Vec3d& p, const geo::Frame& frame) {
  math::Vec3d out = p;
  geo::convert(frame, geo::Frame::geodetic(), {&p, 1}, {&out, 1});
  return out;
}

} // namespace

const char* geodesic_name(TrackGeodesic column) {
  switch (column) {
  case TrackGeodesic::path_length:
    return "path_length";
  case TrackGeodesic::release_distance:
    return "release_distance";
  case TrackGeodesic::release_bearing:
    break;
  }
  return "release_bearing";
}

TrackGeodesics::TrackGeodesics(const std::vector<TrackGeodesic>& columns, core::Memory& memory)
    : columns_(columns), tracks_(memory, INSITU_MEMORY_TRACER) {}

void TrackGeodesics::begin(const advect::Particles& particles, const insitu_frame& frame) {
  if (columns_.empty())
    return;
  const geo::Frame from = to_geo(frame);
  std::size_t known = 0, kept = 0;
  for (std::size_t i = 0; i < particles.size(); ++i, ++kept) {
    while (known < tracks_.size() && tracks_[known].id < particles.ids[i])
      ++known;
    if (known < tracks_.size() && tracks_[known].id == particles.ids[i]) {
      tracks_[kept] = tracks_[known];
      continue;
    }
    // New ones have the largest ids, so what is known has been gone through.
    const math::Vec3d& p = particles.positions[i];
    const math::Vec3d at = is_place(p) ? to_degrees(p, from) : p;
    tracks_.resize(kept);
    tracks_.push_back({particles.ids[i], at, at, 0.0});
    known = tracks_.size();
  }
  tracks_.resize(kept);
}

void TrackGeodesics::add(std::int64_t first, std::span<const math::Vec3d> points,
                         const insitu_frame& frame) {
  if (columns_.empty())
    return;
  const geo::Frame from = to_geo(frame);
  for (const math::Vec3d& p : points) {
    const math::Vec3d at = is_place(p) ? to_degrees(p, from) : p;
    tracks_.push_back({first++, at, at, 0.0});
  }
}

void TrackGeodesics::follow(const advect::Particles& particles, const advect::Snapshots* snapshots,
                            const insitu_frame& frame, const core::Threads& threads) {
  if (columns_.empty())
    return;
  const geo::Frame from = to_geo(frame);
  const std::size_t times = snapshots ? snapshots->times.size() : 0;
  at_snapshots_.resize(times * (snapshots ? snapshots->particles : 0) * columns_.size());
  const auto go_to = [&](GeodesicTrack& track, const math::Vec3d& p) {
    if (!is_place(p))
      return;
    const math::Vec3d at = to_degrees(p, from);
    if (at.x != track.at.x || at.y != track.at.y)
      track.length += geo::separation(track.at, at).distance;
    track.at = at;
  };
  threads.parallel_for(
      std::int64_t(tracks_.size()), 512, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
          for (std::size_t k = 0; k < times; ++k)
            if (const std::size_t item = snapshots->item(k, i); snapshots->present[item]) {
              go_to(tracks_[i], snapshots->positions[item]);
              put(tracks_[i], at_snapshots_.data() + item * columns_.size());
            }
          go_to(tracks_[i], particles.positions[i]);
        }
      });
}

void TrackGeodesics::put(std::int64_t particle, double* out) const {
  if (columns_.empty())
    return;
  const auto found =
      std::lower_bound(tracks_.begin(), tracks_.end(), particle,
                       [](const GeodesicTrack& t, std::int64_t id) { return t.id < id; });
  if (found != tracks_.end() && found->id == particle)
    put(*found, out);
  else
    std::fill(out, out + columns_.size(), std::numeric_limits<double>::quiet_NaN());
}

void TrackGeodesics::put_snapshot(std::size_t item, double* out) const {
  if (at_snapshots_.empty())
    std::fill(out, out + columns_.size(), std::numeric_limits<double>::quiet_NaN());
  else
    std::copy_n(at_snapshots_.data() + item * columns_.size(), columns_.size(), out);
}

void TrackGeodesics::put(const GeodesicTrack& track, double* out) const {
  const geo::Separation from_release = geo::separation(track.release, track.at);
  for (std::size_t c = 0; c < columns_.size(); ++c)
    out[c] = columns_[c] == TrackGeodesic::path_length        ? track.length
             : columns_[c] == TrackGeodesic::release_distance ? from_release.distance
                                                              : from_release.bearing;
}

void TrackGeodesics::keep(core::Archive& archive) {
  if (!columns_.empty())
    archive.array("geodesics", tracks_);
}

} // namespace insitu::scene
