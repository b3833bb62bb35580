#include "scene/frames/frame_action.h"

#include <algorithm>
#include <cstdio>
#include <deque>

#include "core/status.h"
#include "core/timer.h"
#include "output/annotate/box_ticks.h"
#include "output/annotate/overlay.h"
#include "scene/earth/globe.h"
#include "scene/expression/trigger.h"
#include "scene/frames/frame_files.h"
#include "scene/frames/frame_plan.h"
#include "scene/frames/frame_settings.h"
#include "scene/frames/path_accumulation.h"
#include "scene/run/step.h"

namespace insitu::scene {

namespace {

class FrameAction final : public Action {
public:
  FrameAction(const Frame& frame, const Environment& environment)
      : frame_(frame), environment_(environment), settings_(frame_, environment_) {
    if (frame_.path_tracing && frame_.path_tracing->accumulate)
      for (std::size_t i = 0; i < std::max<std::size_t>(1, frame_.cameras.size()); ++i)
        accumulations_.emplace_back(environment_.context.memory);
  }

  const char* kind() const override { return "frame"; }
  const std::string& name() const override { return frame_.name; }
  const Trigger& trigger() const override { return frame_.trigger; }
  const Name& mesh_name() const override { return frame_.mesh; }

  void execute(commit::CommittedMesh& own, const Step& step, bool due) override {
    if (!due)
      return;
    const core::Timer timer;
    const commit::CommittedMesh& mesh = frame_.geocentric ? geocentric(own) : own;
    if (mesh.tree().empty()) {
      note_nothing_drawn(mesh, step);
      return;
    }
    told_nothing_ = false;
    render::Structures& structures = environment_.structures.of(mesh);
    render::FrameSettings settings = settings_.make(mesh, structures);
    environment_.statistics.render_s += timer.seconds();
    if (frame_.geocentric && (frame_.geocentric->globe || frame_.geocentric->graticule))
      settings.depth = true;
    if (settings.path_tracing)
      settings.path_tracing->cycle = std::uint64_t(step.cycle);
    if (frame_.cameras.empty())
      draw(own, mesh, step, {"", frame_.camera}, 0, settings, structures);
    for (std::size_t i = 0; i < frame_.cameras.size(); ++i)
      draw(own, mesh, step, frame_.cameras[i], i, settings, structures);
    ++drawn_;
  }

  void plan(const commit::CommittedMesh& mesh, Plan& plan) const override {
    if (frame_.geocentric) { // shares nothing with frames in the mesh's own coordinates
      char drawn[64];
      std::snprintf(drawn, sizeof drawn, ", geocentric, heights times %g",
                    frame_.geocentric->exaggeration);
      plan.begin("frame '" + frame_.name + "'", mesh.mesh().name() + drawn);
    }
    plan_frame(frame_, settings_, mesh, environment_.context.threads, plan);
  }

private:
  const commit::CommittedMesh& geocentric(const commit::CommittedMesh& own) {
    try {
      return environment_.structures.geocentric(own, frame_.geocentric->exaggeration);
    } catch (const core::Error& e) {
      if (e.status() != INSITU_ERROR_SCENE)
        throw;
      throw core::Error(e.status(), environment_.scene_file + ":" +
                                        std::to_string(frame_.geocentric->line) + ": " + e.what());
    }
  }

  /// A mesh without cells, or one that hides them all, is no error: a solver's cells may come
  /// later.
  void note_nothing_drawn(const commit::CommittedMesh& mesh, const Step& step) {
    if (!told_nothing_)
      environment_.context.log.warning("cycle " + std::to_string(step.cycle) + ": frame '" +
                                       frame_.name + "': mesh '" + mesh.mesh().name() +
                                       "' has no cell that could be drawn; no image is written "
                                       "until it has");
    told_nothing_ = true;
  }

  /// number: the camera's. own: the solver's mesh, of which `mesh` is what is drawn.
  void draw(const commit::CommittedMesh& own, const commit::CommittedMesh& mesh, const Step& step,
            const NamedCamera& camera, std::size_t number, render::FrameSettings& settings,
            render::Structures& structures) {
    const core::Timer timer;
    settings.camera = settings_.camera(camera.camera, mesh, step, drawn_);
    output::BoxTicks ticks;
    if (frame_.outline && frame_.outline->ticks) {
      const mesh::Box box = mesh.sampler().facts().bounds;
      ticks = output::box_ticks(settings.camera, settings.width, settings.height,
                                box.low, box.high);
      settings.outline->ticks = ticks.lines;
    }
    if (!accumulations_.empty())
      accumulations_[number].use(mesh, settings);
    render::FrameStatistics done;
    const std::int64_t located = mesh.located();
    render::FrameImages images = render::render_frame(mesh.sampler(), settings, structures,
                                                      environment_.context.threads, &done);
    mesh.note_drawn(mesh.located() - located);
    if (done.unheld > 0 && !told_unheld_) {
      told_unheld_ = true;
      char tolerance[32];
      std::snprintf(tolerance, sizeof tolerance, "%g", *settings.volume->tolerance);
      environment_.context.log.warning(
          "frame '" + frame_.name + "', cycle " + std::to_string(step.cycle) +
          ": the volume's tolerance of " + tolerance + " is not held in " +
          std::to_string(done.unheld) +
          " macrocells, where the opacity makes a step or the field needs samples nearer than 1/81 "
          "of what accuracy chooses");
    }
    if (done.paths.cut > 0)
      environment_.context.log.warning(
          "frame '" + frame_.name + "', cycle " + std::to_string(step.cycle) + ": " +
          std::to_string(done.paths.cut) + " of " + std::to_string(done.paths.paths) +
          " paths were cut off after " + std::to_string(settings.path_tracing->max_bounces) +
          " bounces; a larger max_bounces loses less light");
    if (frame_.geocentric)
      draw_globe(*frame_.geocentric, own, settings, environment_.context, images);
    draw_overlays(images.color, settings, ticks, step);
    if (settings.cell)
      count_as_the_solver(mesh, settings, images);
    environment_.statistics.render_s += timer.seconds();

    const core::Timer output_timer;
    CinemaRow row;
    row.cycle = step.cycle;
    row.time = step.time;
    row.name = frame_.name;
    row.camera = camera.name;
    row.view = settings.camera;
    row.ranges = settings_.ranges(settings);
    write_frame_files(frame_, environment_, images, row);
    environment_.statistics.output_s += output_timer.seconds();
    ++environment_.statistics.frames;
  }

  /// Cells of an adaptive mesh's dual become the leaves that are seen.
  void count_as_the_solver(const commit::CommittedMesh& mesh, const render::FrameSettings& settings,
                           render::FrameImages& images) const {
    if (!mesh.mesh().has_stand_in() || images.cell.empty() || images.depth.empty())
      return;
    const render::RayGenerator rays(settings.camera, settings.width, settings.height);
    environment_.context.threads.parallel_for(
        settings.height, 16, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t y = begin; y < end; ++y)
            for (int x = 0; x < settings.width; ++x) {
              const auto at = std::size_t(y * settings.width + x);
              if (images.cell[at] < 0)
                continue;
              const render::Ray ray = rays(x, int(y));
              const math::Vec3d p = ray.origin + double(images.depth[at]) * ray.direction;
              images.cell[at] = mesh.own({images.cell[at], {}}, p).cell;
            }
        });
  }

  void draw_overlays(core::Image& image, const render::FrameSettings& settings,
                     const output::BoxTicks& ticks, const Step& step) const {
    output::Overlay overlay;
    overlay.background = settings.background;
    output::draw_box_labels(image, ticks, overlay);
    if (frame_.scalar_bar)
      draw_scalar_bar(image, settings, overlay);
    if (frame_.axes)
      output::draw_axes(image, render::CameraAxes(settings.camera), overlay);
    if (frame_.time_label)
      output::draw_time_label(image, step.time, step.cycle, overlay);
  }

  /// Of the volume, or else of the first surface that is coloured by a field.
  void draw_scalar_bar(core::Image& image, const render::FrameSettings& settings,
                       output::Overlay overlay) const {
    if (settings.volume) {
      overlay.names_nan = frame_.volume->colors.nan.has_value();
      output::draw_scalar_bar(image, settings.volume->function, frame_.volume->field.text, overlay);
      return;
    }
    const auto draw = [&](const auto& color, const auto& drawn) {
      const auto* by = std::get_if<ColorBy>(&color);
      const auto* function = std::get_if<render::ColorByField>(&drawn);
      if (!by || !function)
        return false;
      overlay.names_nan = by->colors.nan.has_value();
      output::draw_scalar_bar(image, function->function, by->field.text, overlay);
      return true;
    };
    for (std::size_t i = 0; i < frame_.isosurfaces.size(); ++i)
      if (draw(frame_.isosurfaces[i].color, settings.isosurfaces[i].color))
        return;
    if (frame_.boundary)
      draw(frame_.boundary->color, settings.boundary->color);
  }

  Frame frame_;
  Environment environment_;
  FrameSettingsMaker settings_;
  std::deque<PathAccumulation> accumulations_; ///< of the cameras, where asked for
  std::int64_t drawn_ = 0;                     ///< frames so far, for the orbit
  bool told_unheld_ = false;                   ///< that a tolerance is not held
  bool told_nothing_ = false;                  ///< that there is no cell, since the last frame
};

} // namespace

std::unique_ptr<Action> make_frame_action(const Frame& frame, const Environment& environment) {
  return std::make_unique<FrameAction>(frame, environment);
}

} // namespace insitu::scene
