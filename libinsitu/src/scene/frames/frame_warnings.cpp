#include "scene/frames/frame_warnings.h"

#include <cstdio>

namespace insitu::scene {

void FrameWarnings::nothing_drawn(const commit::CommittedMesh& mesh, std::size_t layer,
                                  const Step& step, bool is_told) {
  if (is_told && !told_nothing_[layer])
    log_.warning("cycle " + std::to_string(step.cycle) + ": frame '" + frame_.name + "': mesh '" +
                 mesh.mesh().name() + "' has no cell that could be drawn; " +
                 (frame_.layers.size() > 1 ? "it is left out" : "no image is written") +
                 " until it has");
  told_nothing_[layer] = true;
}

void FrameWarnings::exact(const Drawing& drawing, bool is_told) {
  std::vector<const render::FrameSettings*> settings;
  for (const DrawnMesh& drawn : drawing.meshes)
    settings.push_back(&drawn.settings);
  const char* const why = render::why_exact(settings);
  if (!why || told_exact_ || frame_.compositing == render::Compositing::exact)
    return;
  told_exact_ = true;
  if (is_told)
    log_.warning("cycle " + std::to_string(drawing.step.cycle) + ": frame '" + frame_.name +
                 "': its compositing is 'exact', as " + why);
}

void FrameWarnings::image(const render::FrameStatistics& done, const Drawing& drawing) {
  const std::string of =
      "frame '" + frame_.name + "', cycle " + std::to_string(drawing.step.cycle) + ": ";
  if (done.unheld > 0 && !told_unheld_) {
    told_unheld_ = true;
    char tolerance[32] = "";
    for (const DrawnMesh& drawn : drawing.meshes)
      if (const auto& volume = drawn.settings.volume; volume && volume->tolerance)
        std::snprintf(tolerance, sizeof tolerance, "%g", *volume->tolerance);
    log_.warning(of + "the volume's tolerance of " + tolerance + " is not held in " +
                 std::to_string(done.unheld) +
                 " macrocells, where the opacity makes a step or the field needs samples nearer "
                 "than 1/81 of what accuracy chooses");
  }
  if (done.paths.cut > 0)
    log_.warning(of + std::to_string(done.paths.cut) + " of " + std::to_string(done.paths.paths) +
                 " paths were cut off after " +
                 std::to_string(drawing.first().settings.path_tracing->max_bounces) +
                 " bounces; a larger max_bounces loses less light");
}

} // namespace insitu::scene
