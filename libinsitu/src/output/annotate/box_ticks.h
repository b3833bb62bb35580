#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/image.h"
#include "output/annotate/overlay.h"
#include "render/camera/camera.h"
#include "render/surface/outline.h"

namespace insitu::output {

/// The coordinates of a box along its outer edges, as a camera sees it: for each axis one of the
/// edges that part what is seen of the box from what is behind it, the lowest of those that run
/// more across the image, the leftmost of those that run more upwards. Nothing lies beyond these
/// edges but what is outside of the box.
struct BoxTicks {
  struct Axis {
    int axis = 0;
    std::vector<double> values; ///< round, ascending, within the box
    std::vector<std::string> labels;
    std::vector<std::array<double, 2>> ends; ///< of the ticks, in pixels from the upper left corner
    std::array<double, 2> middle{};          ///< of the edge, as it is seen
    std::array<double, 2> outwards{};        ///< in the image, of length 1, at right angles
  };
  std::vector<Axis> axes; ///< those that are seen long enough; none from within the box
  std::vector<render::OutlineTick> lines;
};

/// The lines of all axes together are no more.
constexpr std::int64_t most_box_ticks = 3 * 10;

/// low, high: the box's corners. An axis without extent has no ticks.
BoxTicks box_ticks(const render::Camera& camera, int width, int height, const math::Vec3d& low,
                   const math::Vec3d& high);

/// The values at the ticks' ends and the axes' names, x, y and z, beyond them. What would lie over
/// another, or not wholly in the image, is left out.
void draw_box_labels(core::Image& image, const BoxTicks& ticks, const Overlay& overlay = {});

/// The part of an image's half, as Camera::fitted() takes it, that labels need beside a box.
constexpr double box_label_margin = 0.25;

} // namespace insitu::output
