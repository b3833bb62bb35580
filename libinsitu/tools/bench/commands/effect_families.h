#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/memory.h"
#include "render/frame.h"

namespace insitu::bench {

/// An effect of a frame: the bare frame, and with it.
struct FrameEffect {
  std::string name;
  std::function<void(render::FrameSettings&)> ask;
  bool goes_with_all = true; ///< with the family's other effects
  /// What is drawn over the image.
  std::function<void(core::Image&, const render::FrameSettings&)> draw_over = {};
};

struct EffectFamily {
  std::string name; ///< of the bare frame
  render::FrameSettings bare;
  std::vector<FrameEffect> effects;
};

/// Of cells' own values; its effect is that of a scene's `smooth`, which is not among the settings.
constexpr const char* cell_volume = "cell volume";

/// What `insitu-bench effects` prices: frames of so many pixels a side of a field over the unit
/// box, at its vertices and in its cells. The memory, which counts what accumulates, must outlive
/// them.
std::vector<EffectFamily> effect_families(int size, const render::ScalarField& of_vertices,
                                          const render::ScalarField& of_cells,
                                          core::Memory& memory);

} // namespace insitu::bench
