#pragma once

#include "commit/committed_mesh.h"
#include "measure.h"
#include "render/frame.h"
#include "render/structures/structures.h"

namespace insitu::bench {

/// Frames of one mesh as they follow each other in a session: what they need of it is made once.
/// Mesh, memory and threads must outlive it.
class KeptFrames {
public:
  KeptFrames(const commit::CommittedMesh& mesh, core::Memory& memory, const core::Threads& threads)
      : mesh_(mesh), threads_(threads), structures_(memory) {
    structures_.begin(mesh.sampler(), mesh.tree_version(), mesh.fields_version(), threads);
  }

  render::FrameImages draw(const render::FrameSettings& settings,
                           render::FrameStatistics* statistics = nullptr) {
    return render::render_frame(mesh_.sampler(), settings, structures_, threads_, statistics);
  }
  /// Seconds a frame after a first one: the median.
  double time(const render::FrameSettings& settings, int repetitions,
              render::FrameStatistics* statistics = nullptr) {
    (void)draw(settings);
    Series series;
    for (int i = 0; i < repetitions; ++i)
      series.time([&] { (void)draw(settings, statistics); });
    return series.for_ratio(threads_.count());
  }

private:
  const commit::CommittedMesh& mesh_;
  const core::Threads& threads_;
  render::Structures structures_;
};

} // namespace insitu::bench
