#pragma once

#include <algorithm>
#include <cstdint>

#include "core/memory.h"

namespace insitu::render {

class Majorants;

/// How far light is followed in a medium. none: what collides shows its colour, as emission and
/// absorption do, so the mean is what ray marching tends to with ever shorter steps. single: light
/// scatters once on its way from a light to the viewer; multiple: any number of times.
enum class Scattering { none, single, multiple };

/// The most opacity that a stretch of unit distance has here, 1 - 2^-24: a transfer function's 1 is
/// an extinction of 24 ln 2 = 16.6 per unit distance, not an infinite one.
constexpr double largest_opacity = 1 - 0x1.0p-24;

/// Colours of pixels added up over samples, to go on with in later frames.
struct PathSums {
  /// Colour (times alpha) and alpha.
  struct Pixel {
    double r, g, b, alpha;
  };
  explicit PathSums(core::Memory& memory) : pixels(memory, INSITU_MEMORY_FRAME) {}

  /// Forgets all.
  void restart() { is_whole = false; }
  /// Ready for an image of this size: starts anew where the last one was of another, or broke off.
  /// has_pixels: whether the sums are here; of several processes they are at the root.
  void begin(int w, int h, bool has_pixels = true) {
    if (!is_whole || w != width || h != height) {
      width = w;
      height = h;
      samples = 0;
      pixels.resize_discard(has_pixels ? std::size_t(w) * std::size_t(h) : 0);
      std::fill(pixels.begin(), pixels.end(), Pixel{0, 0, 0, 0});
    }
    is_whole = false;
  }
  /// Adds to a pixel, and returns its sum.
  const Pixel& add(std::size_t pixel, const Pixel& more) {
    Pixel& all = pixels[pixel];
    all.r += more.r;
    all.g += more.g;
    all.b += more.b;
    all.alpha += more.alpha;
    return all;
  }
  /// The image is done.
  void end(int more_samples) {
    samples += more_samples;
    is_whole = true;
  }

  bool is_whole = false; ///< every pixel has `samples`
  int width = 0, height = 0;
  std::int64_t samples = 0; ///< in each pixel
  core::Buffer<Pixel> pixels;
};

/// A volume drawn by following light, in place of ray marching.
struct PathTracingSettings {
  Scattering scattering = Scattering::multiple;
  int samples = 64;      ///< paths a pixel, spread over the samples of pixels
  double density = 1;    ///< factor on the extinction
  double anisotropy = 0; ///< the mean cosine of scattering, in (-1, 1)
  /// Bounces after which a path is cut off, which makes the image darker by what it missed: paths
  /// cut are counted (PathCounts::cut).
  int max_bounces = 4096;
  /// Russian roulette: a path of less throughput goes on with a chance of throughput / roulette.
  double roulette = 0.25;
  bool shows_dome = false; ///< dome lights instead of the background behind the medium
  /// Sets RayState::depth too: where half of the paths (of the first 256) have stopped.
  bool depth = false;
  /// Of the grid of majorants: about so many cells to a macrocell, but at most
  /// most_path_macrocells.
  double cells_per_macrocell = 4;
  /// Of the whole mesh, where it is spread over processes; null: what Structures has of the
  /// sampler's. Not owned.
  const Majorants* majorants = nullptr;
  std::uint64_t seed = 0, cycle = 0;
  /// Adds to these, and draws their mean; null: this frame's samples alone. Not owned. Whoever
  /// keeps them empties them when what is drawn changes.
  PathSums* sums = nullptr;
  /// How points are located, for measurements: the image is the same.
  enum class Locate { batch, single, last_cell };
  Locate locate = Locate::batch;
};

/// What path tracing did.
struct PathCounts {
  std::int64_t paths = 0;
  std::int64_t locations = 0;  ///< tentative collisions, each of which locates a point
  std::int64_t collisions = 0; ///< real ones
  std::int64_t scatterings = 0;
  std::int64_t shadow_rays = 0;
  std::int64_t macrocells = 0; ///< passed
  std::int64_t cut = 0;        ///< paths that ended at max_bounces
  std::int64_t violations = 0; ///< extinctions above their majorant, which bias; 0 always

  PathCounts& operator+=(const PathCounts& b) {
    paths += b.paths;
    locations += b.locations;
    collisions += b.collisions;
    scatterings += b.scatterings;
    shadow_rays += b.shadow_rays;
    macrocells += b.macrocells;
    cut += b.cut;
    violations += b.violations;
    return *this;
  }
};

} // namespace insitu::render
