#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"
#include "render/camera/camera.h"
#include "render/color/transfer_function.h"

namespace insitu::output {

/// What is written over a frame beside the mesh. Sizes follow the image's height; text is dark on a
/// light background and light on a dark one, with a rim in the other shade.
struct Overlay {
  render::Color background{1, 1, 1}; ///< the frame's, linear: chooses the text's shade
  bool names_nan = false; ///< a scalar bar shows the colour of values that are no numbers too
};

/// A vertical bar at the right edge with the function's colours over [low, high], ticks at round
/// values, their labels and, above it, the title (which may be empty). A logarithmic
/// function has ticks at powers of ten, and shorter ones between. Colours of values below and above
/// the range are triangles at the bar's ends. Where the function has opacities, they are not shown:
/// the bar is a key to colours.
void draw_scalar_bar(core::Image& image, const render::TransferFunction& function,
                     const std::string& title, const Overlay& overlay = {});

/// A line of text, see TimeLabel, at the lower left.
void draw_time_label(core::Image& image, const std::string& label, const Overlay& overlay = {});

/// Where x (red), y (green) and z (blue) point, in parallel projection whatever the camera's, at
/// the lower right: three arrows of equal length in space from axes_place(), the nearest drawn
/// last, with their names at their tips. Nothing where the image has no room for them.
void draw_axes(core::Image& image, const render::CameraAxes& camera, const Overlay& overlay = {});

/// In pixels: where the arrows begin, and how long one is that lies in the image's plane (0: no
/// room).
struct AxesPlace {
  double x = 0, y = 0, length = 0;
};
AxesPlace axes_place(const core::Image& image);

/// Round values (1, 2 or 5 times a power of ten apart), ascending, within [low, high]; at most
/// `most` of them, at least 2. With no range to speak of: low alone.
std::vector<double> tick_values(double low, double high, int most);

/// For a logarithmic range, 0 < low <= high: powers of ten within it, ascending, evenly apart, at
/// most `most` (at least 2) of them, in `major`. `minor` has the other powers of ten or, where all
/// are major, 2 to 9 times each. Where fewer than two powers of ten are in the range, `major` is 1,
/// 2 and 5 times powers of ten, or tick_values().
struct LogTicks {
  std::vector<double> major, minor;
};
LogTicks log_tick_values(double low, double high, int most);
/// Labels of these, each as short as can be: 1e-3, 1, 2e5; plain within [0.01, 1e5) if all are.
std::vector<std::string> log_tick_labels(const std::vector<double>& values);

/// A label for each value: as many digits as tell neighbours apart, in scientific notation for
/// large and small ones; the same notation for all.
std::vector<std::string> tick_labels(const std::vector<double>& values);

} // namespace insitu::output
