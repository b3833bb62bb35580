#pragma once

#include <cstdint>
#include <vector>

#include "query/sampler.h"
#include "render/frame.h"

namespace insitu::bench {

/// The standard view of a mesh: its volume in the colour map viridis over [low, high], which fills
/// most of the image, over black.
render::FrameSettings standard_frame(const query::Sampler& sampler, const mesh::FieldView& field,
                                     double low, double high, int size);

/// The standard workload's frame of the unit box: x + 2 y + 3 z in three periods of opacity, seen
/// from a corner, a sample every 1 / N for N^3 cells; 14.79 million samples of 1 M cells at 512 x
/// 512.
render::FrameSettings workload_frame(const mesh::FieldView& field, std::int64_t cells, int size);

/// One sample a ray took, or would take that nothing ends: the points that a frame's march locates,
/// of one tile of 16 x 16 pixels in every `every` each way. rays: of these tiles.
std::vector<math::Vec3d> lattice_points(const query::Sampler& sampler,
                                        const render::FrameSettings& settings, int every,
                                        std::int64_t* rays = nullptr);

/// The ways of locate_lattice: a sample at a time, the last one's cell first; or a ray at a time. n
/// above 0: in bundles of neighbouring rays, n samples of each ray at once.
constexpr int one_by_one = -1, ray_by_ray = 0;

/// Locates these points, and does nothing else.
struct LatticeCost {
  std::int64_t rays = 0, samples = 0;
  double seconds = 0.0; ///< of processor time, on the calling thread
};
LatticeCost locate_lattice(const query::Sampler& sampler, const render::FrameSettings& settings,
                           int way, int every = 4);

} // namespace insitu::bench
