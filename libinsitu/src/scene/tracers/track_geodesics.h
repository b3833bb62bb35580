#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "insitu/insitu.h"

#include "advect/lines/snapshots.h"
#include "advect/particles.h"
#include "core/archive.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "scene/parse/description.h"

namespace insitu::scene {

/// What is known of one particle.
struct GeodesicTrack {
  std::int64_t id;
  math::Vec3d release, at; ///< longitude, latitude (degrees), height
  double length;
};

} // namespace insitu::scene

template <>
inline constexpr bool insitu::core::has_padding<insitu::scene::GeodesicTrack> =
    sizeof(insitu::scene::GeodesicTrack) != sizeof(std::int64_t) + 7 * sizeof(double);

namespace insitu::scene {

/// How far particles have gone over the WGS84 ellipsoid, and where they are as seen from where they
/// were released, by the geodesics between their places (heights do not count). Nothing is done
/// and kept where no column is wanted. On several processes the root knows it of all particles.
///
///   path_length       metres: the geodesics from one executed cycle, or time asked for, to the
///                     next, added up
///   release_distance  metres: the geodesic from the point of release
///   release_bearing   its direction there, degrees clockwise from north, from 0 to below 360; NaN
///                     where the distance is 0
class TrackGeodesics {
public:
  TrackGeodesics(const std::vector<TrackGeodesic>& columns, core::Memory& memory);

  const std::vector<TrackGeodesic>& columns() const { return columns_; }

  /// New particles begin where they are; those that are no more are forgotten. The frame is one
  /// with a place on Earth.
  void begin(const advect::Particles& particles, const insitu_frame& frame);
  /// New particles with ids from `first` on, which do not have to be among those of begin().
  void add(std::int64_t first, std::span<const math::Vec3d> points, const insitu_frame& frame);
  /// The particles, those of begin(), have moved; snapshots: by way of these, if not null.
  void follow(const advect::Particles& particles, const advect::Snapshots* snapshots,
              const insitu_frame& frame, const core::Threads& threads);
  /// Writes columns().size() numbers of the particle with this id; NaN if it is not known.
  void put(std::int64_t particle, double* out) const;
  /// The same as it was at an item of the snapshots that were followed last, where it was present;
  /// NaN if none were.
  void put_snapshot(std::size_t item, double* out) const;
  void forget_snapshots() { at_snapshots_.clear(); }

  /// Everything, to a checkpoint or back.
  void keep(core::Archive& archive);

private:
  void put(const GeodesicTrack& track, double* out) const;

  std::vector<TrackGeodesic> columns_;
  core::Buffer<GeodesicTrack> tracks_; ///< ids ascend
  std::vector<double> at_snapshots_;   ///< [item][column]
};

/// A column's name in files, such as "path_length".
const char* geodesic_name(TrackGeodesic column);

} // namespace insitu::scene
