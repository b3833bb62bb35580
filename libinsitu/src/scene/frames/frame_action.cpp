#include "scene/frames/frame_action.h"

#include <algorithm>
#include <cstdio>
#include <deque>

#include "core/status.h"
#include "core/timer.h"
#include "output/annotate/box_ticks.h"
#include "scene/earth/globe.h"
#include "scene/expression/trigger.h"
#include "scene/frames/chart_copies.h"
#include "scene/frames/frame_drawing.h"
#include "scene/frames/frame_files.h"
#include "scene/frames/frame_on_all.h"
#include "scene/frames/frame_plan.h"
#include "scene/frames/frame_settings.h"
#include "scene/frames/frame_warnings.h"
#include "scene/frames/path_accumulation.h"
#include "scene/run/lookup.h"
#include "scene/run/step.h"

namespace insitu::scene {

namespace {

class FrameAction final : public Action {
public:
  FrameAction(const Frame& frame, const Environment& environment)
      : frame_(frame), environment_(environment), settings_(frame_, environment_),
        cameras_(cameras_of(frame_)), warnings_(frame_, environment_.context.log) {
    if (frame_.path_tracing && frame_.path_tracing->accumulate)
      for (std::size_t i = 0; i < cameras_.size(); ++i)
        accumulations_.emplace_back(environment_.context.memory);
  }

  const char* kind() const override { return "frame"; }
  const std::string& name() const override { return frame_.name; }
  const Trigger& trigger() const override { return frame_.trigger; }
  const Name& mesh_name() const override { return frame_.layers.front().mesh; }
  void execute(commit::CommittedMesh& own, const Step& step, bool due) override {
    if (!due)
      return;
    if (!note_.again(step)) {
      next_camera_ = 0;
      drawn_image_.reset();
      is_drawn_ = false;
    }
    if (is_drawn_)
      write_image();
    if (next_camera_ == cameras_.size()) {
      ++drawn_;
      return;
    }
    if (environment_.world.size() > 1)
      return execute_on_all(own, step);
    const core::Timer timer;
    std::vector<DrawnMesh> meshes = meshes_with_cells(own, step);
    if (meshes.empty())
      return;
    std::vector<std::optional<FrameFacts>> facts(frame_.layers.size());
    for (const DrawnMesh& drawn : meshes)
      facts[drawn.layer] = facts_of(frame_, *drawn.mesh, environment_.scene_file);
    Drawing drawing{step, decide_frame(frame_, facts), std::move(meshes)};
    for (DrawnMesh& drawn : drawing.meshes)
      drawn.structures = &environment_.structures.of(*drawn.mesh);
    make_settings(drawing);
    draw(std::move(drawing), timer);
  }

  void plan(const commit::CommittedMesh& mesh, MeshList meshes, Plan& plan) const override {
    std::vector<const commit::CommittedMesh*> shown{&mesh};
    for (std::size_t i = 1; i < frame_.layers.size(); ++i)
      shown.push_back(&find_mesh(meshes, frame_.layers[i].mesh, environment_.scene_file));
    std::vector<std::optional<FrameFacts>> facts;
    for (const commit::CommittedMesh* of : shown)
      facts.emplace_back(facts_of(frame_, *of, environment_.scene_file));
    const FrameDecisions decisions = decide_frame(frame_, facts);
    for (std::size_t i = 0; i < shown.size(); ++i) {
      std::string name = shown[i]->mesh().name();
      if (frame_.geocentric) { // shares nothing with frames in the mesh's own coordinates
        char drawn[64];
        std::snprintf(drawn, sizeof drawn, ", geocentric, heights times %g",
                      frame_.geocentric->exaggeration);
        name += drawn;
      }
      plan.begin("frame '" + frame_.name + "'", name);
      if (frame_.geocentric)
        at_geocentric([&] { GeocentricMesh::check(*shown[i]); });
      plan_frame(frame_, i, settings_, decisions, *shown[i], environment_.context.threads, plan);
      if (!frame_.geocentric && begins_further_east(shown, i))
        plan.need("tree of cells on the chart of all meshes", shown[i]->tree().bytes(),
                  "about, as the mesh's own, whose chart begins further east");
    }
  }

private:
  /// What is drawn of the frame's meshes, those without cells left out.
  std::vector<DrawnMesh> meshes_with_cells(commit::CommittedMesh& first, const Step& step) {
    std::vector<DrawnMesh> meshes;
    for (std::size_t i = 0; i < frame_.layers.size(); ++i) {
      commit::CommittedMesh& own =
          i == 0 ? first
                 : find_host_mesh(step.meshes, frame_.layers[i].mesh, environment_.scene_file);
      commit::CommittedMesh& mesh = frame_.geocentric ? geocentric(own) : own;
      const bool has_cells =
          !mesh.tree().empty() && mesh.sampler().facts(&environment_.context.threads).cells > 0;
      if (has_cells) {
        meshes.push_back({i, &own, &mesh});
        warnings_.drawn(i);
      } else {
        warnings_.nothing_drawn(mesh, i, step, true);
      }
    }
    if (!frame_.geocentric)
      put_on_one_chart(meshes, environment_);
    return meshes;
  }

  /// Draws what several processes have of the meshes.
  void execute_on_all(commit::CommittedMesh& own, const Step& step) {
    const core::Timer timer;
    parallel::World& world = environment_.world;
    Drawing drawing{step, {}, meshes_of_all(own, step)};
    std::vector<DrawnMesh>& meshes = drawing.meshes;
    for (DrawnMesh& drawn : meshes) {
      drawn.known.fields = frame_fields(layer_of(drawn), *drawn.mesh, environment_);
      drawn.known.in_place = find_cells_in_place(*drawn.mesh, world);
    }
    world.agree_after([&] { drawing.decisions = decide_on_all(meshes); });
    const bool with_halo = update_halos(drawing);
    leave_out(drawing);
    if (meshes.empty())
      return;
    for (DrawnMesh& drawn : meshes) {
      drawn.known.keys.emplace(*drawn.mesh, world);
      if (with_halo) // its commit has other views
        drawn.known.fields = frame_fields(layer_of(drawn), *drawn.mesh, environment_);
    }
    world.agree_after([&] {
      for (DrawnMesh& drawn : meshes)
        drawn.structures = &environment_.structures.of(*drawn.mesh);
      if (with_halo || meshes.size() < frame_.layers.size())
        drawing.decisions = decide_on_all(meshes);
      drawing.parts = parts_of(frame_, drawing, world);
    });
    for (DrawnMesh& drawn : meshes) {
      const LayerDecisions& decided = drawing.decisions.layers[drawn.layer];
      complete_averages(decided, *drawn.mesh, *drawn.structures, world);
      drawn.known.ranges = frame_ranges(decided, *drawn.structures, world);
    }
    world.agree_after([&] {
      make_settings(drawing);
      warnings_.exact(drawing, world.is_root());
    });
    draw(std::move(drawing), timer);
  }

  const FrameLayer& layer_of(const DrawnMesh& drawn) const { return frame_.layers[drawn.layer]; }

  /// What is drawn; of several meshes those that have a cell somewhere.
  std::vector<DrawnMesh> meshes_of_all(commit::CommittedMesh& first, const Step& step) {
    parallel::World& world = environment_.world;
    std::vector<DrawnMesh> meshes;
    for (std::size_t i = 0; i < frame_.layers.size(); ++i) {
      commit::CommittedMesh* own = &first;
      if (i > 0)
        world.agree_after([&] {
          own = &find_host_mesh(step.meshes, frame_.layers[i].mesh, environment_.scene_file);
        });
      if (frame_.layers.size() > 1 && cells_of_all(own->mesh(), world) == 0) {
        warnings_.nothing_drawn(*own, i, step, world.is_root());
        continue;
      }
      own->update_chart(world, environment_.context.threads, environment_.context.log);
      world.agree_after([&] {
        meshes.push_back({i, own, frame_.geocentric ? &geocentric(*own) : own});
      });
    }
    if (!frame_.geocentric)
      put_on_one_chart(meshes, environment_);
    return meshes;
  }

  /// Returns whether some mesh has a halo: one that is there must not be of an earlier step.
  bool update_halos(const Drawing& drawing) {
    const core::Context& context = environment_.context;
    bool any = false;
    for (const DrawnMesh& drawn : drawing.meshes)
      if (drawing.decisions.layers[drawn.layer].vertex_cells.made || layer_of(drawn).boundary ||
          drawn.mesh->halo()) {
        drawn.mesh->update_halo(environment_.world, context.threads, context.log);
        any = true;
      }
    return any;
  }

  /// Leaves out meshes that hide all their cells.
  void leave_out(Drawing& drawing) {
    const auto is_bare = [](const DrawnMesh& drawn) {
      return drawn.mesh->sampler().facts().cells == 0;
    };
    for (const DrawnMesh& drawn : drawing.meshes) {
      know_whole_facts(*drawn.mesh, environment_);
      if (is_bare(drawn))
        warnings_.nothing_drawn(*drawn.mesh, drawn.layer, drawing.step,
                                environment_.world.is_root());
      else
        warnings_.drawn(drawn.layer);
    }
    std::erase_if(drawing.meshes, is_bare);
  }

  void make_settings(Drawing& drawing) const {
    const bool several = frame_.layers.size() > 1, alone = drawing.parts.empty();
    const mesh::Box all = scenery_of(drawing.meshes).box;
    const bool has_copies = std::ranges::any_of(drawing.meshes, [&](const DrawnMesh& drawn) {
      return alone ? has_chart_copies(*drawn.mesh) : drawn.known.in_place.copies;
    });
    for (DrawnMesh& drawn : drawing.meshes) {
      drawn.settings = settings_.make(
          drawing.decisions, {drawn.layer, *drawn.structures, alone ? nullptr : &drawn.known.ranges,
                              several ? &all : nullptr, &drawn == &drawing.first()});
      if (has_copies)
        end_at_chart(all, drawn.settings);
    }
  }

  /// began: with the work on this drawing.
  void draw(Drawing drawing, const core::Timer& began) {
    for (DrawnMesh& drawn : drawing.meshes)
      if (drawn.settings.path_tracing)
        drawn.settings.path_tracing->cycle = std::uint64_t(drawing.step.cycle);
    environment_.statistics.render_s += began.seconds();
    while (next_camera_ < cameras_.size())
      draw(drawing, next_camera_);
    ++drawn_;
  }

  /// The same on all processes.
  FrameDecisions decide_on_all(const std::vector<DrawnMesh>& meshes) const {
    std::vector<std::optional<FrameFacts>> facts(frame_.layers.size());
    for (const DrawnMesh& drawn : meshes) {
      std::optional<FrameFacts>& of = facts[drawn.layer];
      of = facts_of(frame_, *drawn.mesh, environment_.scene_file, &drawn.known.fields);
      of->has_stand_in = drawn.known.in_place.made; // FrameKeys tells whose copies are
    }
    return decide_frame(frame_, facts);
  }

  /// Errors of the scene get the line of `geocentric`.
  template <class Call>
  void at_geocentric(const Call& call) const {
    try {
      call();
    } catch (const core::Error& e) {
      if (e.status() != INSITU_ERROR_SCENE)
        throw;
      throw core::Error(e.status(),
                        at_line(environment_.scene_file, frame_.geocentric->line) + e.what());
    }
  }

  commit::CommittedMesh& geocentric(const commit::CommittedMesh& own) {
    commit::CommittedMesh* drawn = nullptr;
    at_geocentric(
        [&] { drawn = &environment_.structures.geocentric(own, frame_.geocentric->exaggeration); });
    return *drawn;
  }

  void draw(Drawing& drawing, std::size_t number) {
    const core::Timer timer;
    const DrawnMesh& first = drawing.first();
    output::BoxTicks ticks;
    std::optional<DrawnLayers> layers;
    environment_.world.agree_after([&] {
      aim(drawing, number, ticks);
      layers.emplace(drawing);
    });
    if (!accumulations_.empty())
      accumulations_[number].use(drawing.meshes, drawing.first().settings, environment_.world);
    render::FrameStatistics done;
    render::FrameImages images = draw_meshes(drawing, *layers, environment_.context.threads, done);
    if (drawing.decisions.globe)
      draw_globe(*frame_.geocentric, *first.own, first.settings, environment_.world,
                 environment_.context, images);
    environment_.statistics.render_s += timer.seconds();
    environment_.world.agree_after([&] {
      if (environment_.world.is_root())
        show(drawing, number, ticks, done, images);
    });
    is_drawn_ = true;
    write_image();
  }

  /// Sets what follows the camera.
  void aim(Drawing& drawing, std::size_t number, output::BoxTicks& ticks) {
    const FrameSettingsMaker::Scenery scenery = scenery_of(drawing.meshes);
    const render::Camera camera =
        settings_.camera(cameras_[number].camera, scenery, drawing.step, drawn_);
    for (DrawnMesh& drawn : drawing.meshes)
      drawn.settings.camera = camera;
    if (frame_.outline && frame_.outline->ticks) {
      render::FrameSettings& settings = drawing.first().settings;
      ticks = output::box_ticks(camera, settings.width, settings.height, scenery.box.low,
                                scenery.box.high);
      settings.outline->ticks = ticks.lines;
    }
  }

  /// Draws over an image, which is then to be written.
  void show(const Drawing& drawing, std::size_t number, const output::BoxTicks& ticks,
            const render::FrameStatistics& done, render::FrameImages& images) {
    const core::Timer timer;
    warnings_.image(done, drawing);
    draw_overlays(frame_, drawing, ticks, images.color);
    tell_cells(frame_, drawing, environment_.context.threads, images);
    environment_.statistics.render_s += timer.seconds();
    drawn_image_.emplace(DrawnImage{std::move(images), row_of(drawing, cameras_[number].name)});
  }

  /// Writes the files of the next camera, which is drawn.
  void write_image() {
    environment_.world.agree_after([&] {
      if (!environment_.world.is_root())
        return;
      const core::Timer timer;
      write_frame_files(frame_, environment_, drawn_image_->images, drawn_image_->row);
      environment_.statistics.output_s += timer.seconds();
      ++environment_.statistics.frames;
    });
    drawn_image_.reset();
    is_drawn_ = false;
    ++next_camera_;
  }

  /// What the rows of a camera's files have in common.
  CinemaRow row_of(const Drawing& drawing, const std::string& camera) const {
    CinemaRow row;
    row.cycle = drawing.step.cycle;
    row.time = drawing.step.time;
    row.name = frame_.name;
    row.camera = camera;
    row.view = drawing.first().settings.camera;
    row.ranges = ranges_of(frame_, drawing);
    return row;
  }

  Frame frame_;
  Environment environment_;
  FrameSettingsMaker settings_;
  std::vector<NamedCamera> cameras_;
  std::deque<PathAccumulation> accumulations_; ///< of the cameras, where asked for
  std::int64_t drawn_ = 0;                     ///< frames so far, for the orbit
  // How far the step came, so that it goes on there where it comes again: an image that is drawn
  // and cannot be written is not drawn anew.
  struct DrawnImage {
    render::FrameImages images;
    CinemaRow row;
  };
  StepNote note_;
  std::size_t next_camera_ = 0;
  bool is_drawn_ = false;                      ///< the next camera's image
  std::optional<DrawnImage> drawn_image_;      ///< that image, at the root
  FrameWarnings warnings_;
};

} // namespace

std::unique_ptr<Action> make_frame_action(const Frame& frame, const Environment& environment) {
  return std::make_unique<FrameAction>(frame, environment);
}

} // namespace insitu::scene
