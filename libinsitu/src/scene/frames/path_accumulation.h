#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "parallel/world.h"
#include "render/frame.h"
#include "scene/frames/frame_drawing.h"

namespace insitu::scene {

/// Path tracing samples of the frames before, to go on with while meshes, fields and view stay the
/// same.
class PathAccumulation {
public:
  explicit PathAccumulation(core::Memory& memory) : sums_(memory) {}

  /// Lets the settings add to the sums; they begin anew where anything has changed. Random numbers
  /// are those of the cycle in which they began: the sums are of one frame of all the samples.
  /// Collective: where anything has changed on one process, they begin anew on all.
  void use(std::span<const DrawnMesh> meshes, render::FrameSettings& settings,
           parallel::World& world);

private:
  struct State {
    std::vector<std::pair<std::uint64_t, std::uint64_t>> meshes; ///< which, and their versions
    std::array<math::Vec3d, 6> view; ///< the rays of three corners
    friend bool operator==(const State&, const State&) = default;
  };
  State state_;
  std::uint64_t first_cycle_ = 0;
  render::PathSums sums_;
};

} // namespace insitu::scene
