#include "scene/frame_action.h"

#include <optional>

#include "core/status.h"
#include "core/timer.h"
#include "output/overlay.h"
#include "output/png.h"
#include "scene/frame_plan.h"
#include "scene/frame_settings.h"
#include "scene/path_accumulation.h"

namespace insitu::scene {

namespace {

class FrameAction final : public Action {
public:
  FrameAction(const Frame& frame, const Environment& environment)
      : frame_(frame), environment_(environment), settings_(frame_, environment_) {
    if (frame_.path_tracing && frame_.path_tracing->accumulate)
      accumulation_.emplace(environment_.context.memory);
  }

  const char* kind() const override { return "frame"; }
  const std::string& name() const override { return frame_.name; }
  const Trigger& trigger() const override { return frame_.trigger; }
  const Name& mesh_name() const override { return frame_.mesh; }

  void execute(query::CommittedMesh& mesh, const Step& step, bool due) override {
    if (!due)
      return;
    const core::Timer timer;
    core::Context& context = environment_.context;
    if (mesh.tree().empty())
      throw core::Error(INSITU_ERROR_MESH,
                        "mesh '" + mesh.mesh().name() + "' has no cell that could be drawn");
    render::Structures& structures = environment_.structures.of(mesh);
    render::FrameSettings settings = settings_.make(mesh, structures, drawn_);
    if (settings.path_tracing)
      settings.path_tracing->cycle = std::uint64_t(step.cycle);
    if (accumulation_)
      accumulation_->use(mesh, settings);
    render::FrameStatistics done;
    core::Image image =
        render::render_frame(mesh.sampler(), settings, structures, context.threads, &done).color;
    if (done.paths.cut > 0)
      context.log.warning("frame '" + frame_.name + "', cycle " + std::to_string(step.cycle) +
                          ": " + std::to_string(done.paths.cut) + " of " +
                          std::to_string(done.paths.paths) + " paths were cut off after " +
                          std::to_string(settings.path_tracing->max_bounces) +
                          " bounces; a larger max_bounces loses less light");
    draw_overlays(image, settings, step);
    environment_.statistics.render_s += timer.seconds();

    const core::Timer output_timer;
    const std::string path = cycle_path(environment_, frame_.name, step.cycle, ".png");
    output::write_png(path, image);
    if (environment_.page)
      environment_.page->add_frame(frame_.name, "color", path);
    environment_.statistics.output_s += output_timer.seconds();
    ++environment_.statistics.frames;
    ++environment_.statistics.files;
    ++drawn_;
  }

  void plan(const query::CommittedMesh& mesh, Plan& plan) const override {
    plan_frame(frame_, mesh, plan);
  }

private:
  void draw_overlays(core::Image& image, const render::FrameSettings& settings,
                     const Step& step) const {
    output::Overlay overlay;
    overlay.background = settings.background;
    if (frame_.scalar_bar && settings.volume)
      output::draw_scalar_bar(image, settings.volume->function, frame_.volume->field.text, overlay);
    else if (frame_.scalar_bar)
      for (const render::IsosurfaceSettings& surface : settings.isosurfaces)
        if (const auto* by = std::get_if<render::ColorByField>(&surface.color)) {
          output::draw_scalar_bar(image, by->function, by->field.field.name, overlay);
          break;
        }
    if (frame_.time_label)
      output::draw_time_label(image, step.time, step.cycle, overlay);
  }

  Frame frame_;
  Environment environment_;
  FrameSettingsMaker settings_;
  std::optional<PathAccumulation> accumulation_;
  std::int64_t drawn_ = 0; ///< frames so far, for the orbit
};

} // namespace

std::unique_ptr<Action> make_frame_action(const Frame& frame, const Environment& environment) {
  return std::make_unique<FrameAction>(frame, environment);
}

} // namespace insitu::scene
