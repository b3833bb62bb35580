#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "parallel/bytes.h"
#include "query/ray_bundle/ray_bundle.h"
#include "render/camera/ray_state.h"
#include "render/volume/volume.h"

/// What is sent about a tile's rays, which are numbered within the tile, to its owner.
namespace insitu::render {

using parallel::ByteReader;
using parallel::ByteWriter;

using CellKey = std::function<std::int64_t(std::int64_t flat)>;

/// Where a ray meets a surface: what puts hits of all processes in order, and makes twins one.
struct SentMeeting {
  double t;
  std::int64_t key; ///< of the cell
  double extent;
  std::int64_t triangle;
  std::int32_t surface;
  float opacity;

  SentMeeting() = default;
  SentMeeting(const SurfaceHit& hit, std::int64_t key_)
      : t(hit.t), key(key_), extent(hit.extent), triangle(hit.triangle), surface(hit.surface),
        opacity(hit.opacity) {}
  /// With the key in the place of the cell.
  SurfaceHit hit() const {
    SurfaceHit hit;
    hit.t = t;
    hit.cell = key;
    hit.extent = extent;
    hit.triangle = triangle;
    hit.surface = surface;
    hit.opacity = opacity;
    return hit;
  }
};

/// Of so many bits.
inline std::size_t words_of(std::size_t bits) {
  return (bits + 63) / 64;
}

/// Bytes of a hit on its way, and of where rays of light start from it, if there are some.
constexpr std::int64_t bytes_a_hit = 80, bytes_a_start = 16;
/// Bytes of the samples of a ray in a round, of each of them, of a gradient where colours are lit,
/// of a place where lights hang on it, and of a level with a tolerance. Where cells are told, of
/// which of them change, and of each change of cell among them.
constexpr std::int64_t bytes_a_run = 6, bytes_a_sample = 8, bytes_a_gradient = 24,
                       bytes_a_place = 24, bytes_a_level = 1, bytes_of_changes = 4,
                       bytes_a_change = 8;

/// Writes the hits of rays, those in cells of this process.
void write_hits(std::span<const RayState> rays, const CellKey& key, bool with_starts,
                ByteWriter& to);
/// Adds those of a process and a layer to the hits of the rays; cells are keys. which: of the rays,
/// those that the process was told; empty: all.
void read_hits(ByteReader from, bool with_starts, int process, std::span<const std::uint32_t> which,
               std::span<RayState> rays, std::int32_t layer = 0);

/// Writes claims of rays from the tile's ray `first_ray` on, ray by ray. key: null: without cells.
void write_claims(const VolumeMarcher::Claims& claims, std::size_t first_ray, const CellKey* key,
                  ByteWriter& to);

/// Reads the claims of all processes on a tile's samples in a round.
class ClaimReader {
public:
  static constexpr int most_depth = 32; ///< samples of a ray

  ClaimReader(const VolumeMarcher& volume, bool with_cells)
      : with_cells_(with_cells), with_gradients_(volume.is_lit()),
        with_places_(volume.is_lit_by_place()), with_levels_(volume.has_levels()) {}
  void clear() { runs_.clear(); }
  /// Of a process, those of rays in ascending order.
  void add(ByteReader claims);

  /// Goes on to the next ray of which a sample is claimed; false if there is none. Of claims on one
  /// sample that of the lowest key stays, with cells.
  bool next();
  /// Without cells: whether two processes claim a sample of the ray.
  bool is_tied() const { return is_tied_; }
  std::size_t ray() const { return ray_; }
  std::uint32_t wanted() const { return wanted_; }
  /// most_depth of them; cells are keys, or 0.
  const query::ValueSample* samples() const { return samples_; }
  /// The same, with gradients in place of coordinates if there are some.
  const query::Location* locations() const { return locations_; }
  /// The same, if there are some.
  const math::Vec3d* places() const { return places_; }
  const std::uint8_t* levels() const { return levels_; }
  /// Puts the light of a sample in place of its gradient.
  void set_light(int sample, const math::Vec3d& light) { locations_[sample].parametric = light; }

private:
  struct Run {
    ByteReader reader;
    std::size_t ray;
  };
  static constexpr std::size_t no_ray = ~std::size_t(0);
  static void begin(Run& run) {
    run.ray = run.reader.at_end() ? no_ray : run.reader.value<std::uint16_t>();
  }
  void take(Run& run);

  bool with_cells_, with_gradients_, with_places_, with_levels_, is_tied_ = false;
  std::vector<Run> runs_; ///< by process
  std::size_t ray_ = 0;
  std::uint32_t wanted_ = 0;
  query::ValueSample samples_[most_depth];
  query::Location locations_[most_depth];
  math::Vec3d places_[most_depth];
  std::uint8_t levels_[most_depth];
};

} // namespace insitu::render
