#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/log.h"
#include "scene/frames/frame_drawing.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// What a frame tells the user in warnings, of which most are told once.
class FrameWarnings {
public:
  FrameWarnings(const Frame& frame, core::Log& log)
      : frame_(frame), log_(log), told_nothing_(frame.layers.size()) {}

  /// A mesh without cells, or one that hides them all, is no error: a solver's cells may come
  /// later. is_told: on this process.
  void nothing_drawn(const commit::CommittedMesh& mesh, std::size_t layer, const Step& step,
                     bool is_told);
  void drawn(std::size_t layer) { told_nothing_[layer] = false; }
  /// That standard compositing is not what is done.
  void exact(const Drawing& drawing, bool is_told);
  /// What an image lacks.
  void image(const render::FrameStatistics& done, const Drawing& drawing);

private:
  const Frame& frame_;
  core::Log& log_;
  bool told_unheld_ = false; ///< that a tolerance is not held
  bool told_exact_ = false;
  /// By layer: that the mesh has no cell, since it last had one.
  std::vector<bool> told_nothing_;
};

} // namespace insitu::scene
