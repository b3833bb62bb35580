#include "scene/frames/frame_action.h"

#include <algorithm>
#include <cstdio>
#include <deque>
#include <limits>

#include "core/status.h"
#include "core/timer.h"
#include "output/annotate/box_ticks.h"
#include "output/annotate/overlay.h"
#include "scene/earth/globe.h"
#include "scene/expression/trigger.h"
#include "scene/frames/chart_copies.h"
#include "scene/frames/frame_files.h"
#include "scene/frames/frame_on_all.h"
#include "scene/frames/frame_plan.h"
#include "scene/frames/frame_settings.h"
#include "scene/frames/path_accumulation.h"
#include "scene/run/lookup.h"
#include "scene/run/step.h"

namespace insitu::scene {

namespace {

std::string title_of(const ScalarBar& bar, const ColorBy& by) {
  const std::string title = bar.title.empty() ? by.field.text : bar.title;
  return bar.unit.empty() ? title : title + " (" + bar.unit + ")";
}

class FrameAction final : public Action {
public:
  FrameAction(const Frame& frame, const Environment& environment)
      : frame_(frame), environment_(environment), settings_(frame_, environment_),
        cameras_(cameras_of(frame_)) {
    if (frame_.path_tracing && frame_.path_tracing->accumulate)
      for (std::size_t i = 0; i < cameras_.size(); ++i)
        accumulations_.emplace_back(environment_.context.memory);
  }

  const char* kind() const override { return "frame"; }
  const std::string& name() const override { return frame_.name; }
  const Trigger& trigger() const override { return frame_.trigger; }
  const Name& mesh_name() const override { return frame_.mesh; }
  void execute(commit::CommittedMesh& own, const Step& step, bool due) override {
    if (!due)
      return;
    if (environment_.world.size() > 1)
      return execute_on_all(own, step);
    const core::Timer timer;
    commit::CommittedMesh& mesh = frame_.geocentric ? geocentric(own) : own;
    if (mesh.tree().empty() || mesh.sampler().facts(&environment_.context.threads).cells == 0) {
      note_nothing_drawn(mesh, step);
      return;
    }
    told_nothing_ = false;
    const FrameDecisions decisions = decide(mesh);
    render::Structures& structures = environment_.structures.of(mesh);
    Drawing drawing{own, mesh, step, decisions, structures, settings_.make(decisions, structures)};
    if (has_chart_copies(mesh))
      end_at_chart(mesh, drawing.settings);
    if (drawing.settings.path_tracing)
      drawing.settings.path_tracing->cycle = std::uint64_t(step.cycle);
    environment_.statistics.render_s += timer.seconds();
    for (std::size_t i = 0; i < cameras_.size(); ++i)
      draw(drawing, i);
    ++drawn_;
  }

  void plan(const commit::CommittedMesh& mesh, Plan& plan) const override {
    if (frame_.geocentric) { // shares nothing with frames in the mesh's own coordinates
      char drawn[64];
      std::snprintf(drawn, sizeof drawn, ", geocentric, heights times %g",
                    frame_.geocentric->exaggeration);
      plan.begin("frame '" + frame_.name + "'", mesh.mesh().name() + drawn);
      at_geocentric([&] { GeocentricMesh::check(mesh); });
    }
    plan_frame(frame_, settings_, decide(mesh), mesh, environment_.context.threads, plan);
  }

private:
  /// The images of one cycle.
  struct Drawing {
    const commit::CommittedMesh& own;  ///< the solver's mesh
    const commit::CommittedMesh& mesh; ///< the mesh that is drawn
    const Step& step;
    const FrameDecisions& decisions;
    render::Structures& structures;
    render::FrameSettings settings; ///< the camera and what follows it are set for each image
    /// Of several processes; null: there is one.
    const render::FramePart* part = nullptr;
    const FrameKeys* keys = nullptr;
  };

  /// Draws what several processes have of the mesh.
  void execute_on_all(commit::CommittedMesh& own, const Step& step) {
    const core::Timer timer;
    parallel::World& world = environment_.world;
    own.update_chart(world, environment_.context.threads, environment_.context.log);
    commit::CommittedMesh* drawn = &own;
    world.agree_after([&] {
      if (frame_.geocentric)
        drawn = &geocentric(own);
    });
    commit::CommittedMesh& mesh = *drawn;
    const FieldsByName fields = frame_fields(frame_, mesh, environment_);
    const CellsInPlace in_place = find_cells_in_place(mesh);
    FrameDecisions decisions;
    world.agree_after([&] { decisions = decide_on_all(mesh, fields, in_place); });
    // A halo that is there must not be of an earlier step.
    const bool with_halo = decisions.vertex_cells.made || frame_.boundary || mesh.halo();
    if (with_halo)
      mesh.update_halo(world, environment_.context.threads, environment_.context.log);
    know_whole_facts(mesh, environment_);
    if (mesh.sampler().facts().cells == 0) {
      if (world.is_root())
        note_nothing_drawn(mesh, step);
      return;
    }
    told_nothing_ = false;
    const FrameKeys keys(mesh, world);
    render::FramePart part{world, mesh.mesh().view().own_cell_count(),
                           [&](std::int64_t flat) { return keys.key(flat); },
                           mesh.halo() != nullptr};
    if (decisions.own_cells)
      part.solvers_cell = [&](const math::Vec3d& place) { return keys.solvers_at(place); };
    part.compositing = frame_.compositing;
    render::Structures* structures = nullptr;
    std::optional<FieldsByName> refreshed;
    if (with_halo) // its commit has other views
      refreshed = frame_fields(frame_, mesh, environment_);
    world.agree_after([&] {
      structures = &environment_.structures.of(mesh);
      if (refreshed)
        decisions = decide_on_all(mesh, *refreshed, in_place);
    });
    complete_averages(decisions, mesh, *structures, world);
    const RangesByColor ranges = frame_ranges(decisions, *structures, world);
    render::FrameSettings settings;
    world.agree_after([&] {
      settings = settings_.make(decisions, *structures, &ranges);
      if (in_place.copies)
        end_at_chart(mesh, settings);
    });
    note_exact(settings, step);
    Drawing drawing{own, mesh, step, decisions, *structures, std::move(settings), &part, &keys};
    if (drawing.settings.path_tracing)
      drawing.settings.path_tracing->cycle = std::uint64_t(step.cycle);
    environment_.statistics.render_s += timer.seconds();
    for (std::size_t i = 0; i < cameras_.size(); ++i)
      draw(drawing, i);
    ++drawn_;
  }

  /// Whether some process draws other cells in the place of the solver's: copies on a chart, or
  /// cells that are made of them (adaptive meshes' duals).
  struct CellsInPlace {
    bool copies, made;
  };
  CellsInPlace find_cells_in_place(const commit::CommittedMesh& mesh) const {
    std::int64_t found[] = {has_chart_copies(mesh),
                            mesh.mesh().has_stand_in() && mesh.mesh().is_adaptive()};
    environment_.world.reduce(std::span(found), parallel::Reduction::greatest);
    return {found[0] != 0, found[1] != 0};
  }

  /// Copies reach over the ends of a chart, where their places are shown already, and others lie
  /// beyond on charts turned to a pole. Faces that lie in the ends are seen.
  static void end_at_chart(const commit::CommittedMesh& mesh, render::FrameSettings& settings) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const mesh::Box ends = mesh.sampler().facts().bounds;
    const double slack = 1e-6 * (ends.high.x - ends.low.x);
    settings.clips.push_back({render::Clip::Kind::box,
                              {ends.low.x - slack, -infinity, -infinity},
                              {ends.high.x + slack, infinity, infinity}});
  }

  /// The same on all processes.
  FrameDecisions decide_on_all(const commit::CommittedMesh& mesh, const FieldsByName& fields,
                               const CellsInPlace& in_place) const {
    FrameFacts facts = facts_of(frame_, mesh, environment_.scene_file, &fields);
    facts.has_stand_in = in_place.made; // FrameKeys tells whose copies are
    return decide_frame(frame_, facts);
  }

  FrameDecisions decide(const commit::CommittedMesh& mesh) const {
    return decide_frame(frame_, facts_of(frame_, mesh, environment_.scene_file));
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

  void note_exact(const render::FrameSettings& settings, const Step& step) {
    const char* const why = render::why_exact(settings);
    if (!why || told_exact_ || frame_.compositing == render::Compositing::exact)
      return;
    told_exact_ = true;
    if (environment_.world.is_root())
      environment_.context.log.warning("cycle " + std::to_string(step.cycle) + ": frame '" +
                                       frame_.name + "': its compositing is 'exact', as " + why);
  }

  void draw(Drawing& drawing, std::size_t number) {
    const core::Timer timer;
    const commit::CommittedMesh& mesh = drawing.mesh;
    output::BoxTicks ticks;
    environment_.world.agree_after([&] { aim(drawing, number, ticks); });
    if (!accumulations_.empty())
      accumulations_[number].use(mesh, drawing.settings, environment_.world);
    render::FrameStatistics done;
    const std::int64_t located = mesh.located();
    render::FrameImages images =
        drawing.part
            ? render::render_shared_frame(*drawing.part, mesh.own_sampler(), drawing.settings,
                                          drawing.structures, environment_.context.threads, &done)
            : render::render_frame(mesh.sampler(), drawing.settings, drawing.structures,
                                   environment_.context.threads, &done);
    mesh.note_drawn(mesh.located() - located);
    if (drawing.decisions.globe)
      draw_globe(*frame_.geocentric, drawing.own, drawing.settings, environment_.world,
                 environment_.context, images);
    environment_.statistics.render_s += timer.seconds();
    environment_.world.agree_after([&] {
      if (environment_.world.is_root())
        show(drawing, number, ticks, done, images);
    });
  }

  /// Sets what follows the camera.
  void aim(Drawing& drawing, std::size_t number, output::BoxTicks& ticks) {
    render::FrameSettings& settings = drawing.settings;
    const commit::CommittedMesh& mesh = drawing.mesh;
    settings.camera = settings_.camera(cameras_[number].camera, mesh, drawing.step, drawn_);
    if (frame_.outline && frame_.outline->ticks) {
      const mesh::Box box = mesh.sampler().facts().bounds;
      ticks =
          output::box_ticks(settings.camera, settings.width, settings.height, box.low, box.high);
      settings.outline->ticks = ticks.lines;
    }
  }

  /// Draws over an image, and writes the files.
  void show(const Drawing& drawing, std::size_t number, const output::BoxTicks& ticks,
            const render::FrameStatistics& done, render::FrameImages& images) {
    const core::Timer timer;
    const render::FrameSettings& settings = drawing.settings;
    warn(done, settings, drawing.step);
    draw_overlays(images.color, drawing, ticks);
    if (drawing.decisions.own_cells && !drawing.part)
      count_as_the_solver(drawing.mesh, settings, images);
    if (drawing.keys)
      for (std::int64_t& cell : images.cell)
        cell = cell >= 0 ? drawing.keys->solvers(cell) : cell;
    if (const mesh::Mesh& own = drawing.own.mesh();
        !drawing.part && own.has_global_ids(INSITU_CELL))
      for (std::int64_t& cell : images.cell)
        if (cell >= 0)
          cell = own.global_id(INSITU_CELL, cell);
    environment_.statistics.render_s += timer.seconds();
    write(drawing, cameras_[number].name, images);
  }

  void warn(const render::FrameStatistics& done, const render::FrameSettings& settings,
            const Step& step) {
    const std::string of =
        "frame '" + frame_.name + "', cycle " + std::to_string(step.cycle) + ": ";
    if (done.unheld > 0 && !told_unheld_) {
      told_unheld_ = true;
      char tolerance[32];
      std::snprintf(tolerance, sizeof tolerance, "%g", *settings.volume->tolerance);
      environment_.context.log.warning(
          of + "the volume's tolerance of " + tolerance + " is not held in " +
          std::to_string(done.unheld) +
          " macrocells, where the opacity makes a step or the field needs samples nearer than 1/81 "
          "of what accuracy chooses");
    }
    if (done.paths.cut > 0)
      environment_.context.log.warning(
          of + std::to_string(done.paths.cut) + " of " + std::to_string(done.paths.paths) +
          " paths were cut off after " + std::to_string(settings.path_tracing->max_bounces) +
          " bounces; a larger max_bounces loses less light");
  }

  void write(const Drawing& drawing, const std::string& camera, const render::FrameImages& images) {
    const core::Timer timer;
    CinemaRow row;
    row.cycle = drawing.step.cycle;
    row.time = drawing.step.time;
    row.name = frame_.name;
    row.camera = camera;
    row.view = drawing.settings.camera;
    const std::vector<const ColorBy*> by = colorings_of(frame_);
    const std::vector<const render::TransferFunction*> functions = functions_of(drawing.settings);
    for (std::size_t i = 0; i < by.size(); ++i)
      row.ranges.emplace_back(range_label(*by[i]),
                              ValueRange{functions[i]->low(), functions[i]->high()});
    write_frame_files(frame_, environment_, images, row);
    environment_.statistics.output_s += timer.seconds();
    ++environment_.statistics.frames;
  }

  /// Cells that stand in for the solver's become those of the solver that are seen.
  void count_as_the_solver(const commit::CommittedMesh& mesh, const render::FrameSettings& settings,
                           render::FrameImages& images) const {
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

  void draw_overlays(core::Image& image, const Drawing& drawing,
                     const output::BoxTicks& ticks) const {
    output::Overlay overlay;
    overlay.background = drawing.settings.background;
    output::draw_box_labels(image, ticks, overlay);
    if (drawing.decisions.scalar_bar) {
      const ColorBy& first = *colorings_of(frame_).front();
      output::Overlay with_nan = overlay;
      with_nan.names_nan = first.colors.nan.has_value();
      output::draw_scalar_bar(image, *functions_of(drawing.settings).front(),
                              title_of(*frame_.scalar_bar, first), with_nan);
    }
    if (frame_.axes)
      output::draw_axes(image, render::CameraAxes(drawing.settings.camera), overlay);
    if (frame_.time_label)
      output::draw_time_label(image, (*frame_.time_label)(drawing.step.time, drawing.step.cycle),
                              overlay);
  }

  Frame frame_;
  Environment environment_;
  FrameSettingsMaker settings_;
  std::vector<NamedCamera> cameras_;
  std::deque<PathAccumulation> accumulations_; ///< of the cameras, where asked for
  std::int64_t drawn_ = 0;                     ///< frames so far, for the orbit
  bool told_unheld_ = false;                   ///< that a tolerance is not held
  bool told_nothing_ = false;                  ///< that there is no cell, since the last frame
  bool told_exact_ = false;                    ///< that standard compositing is not
};

} // namespace

std::unique_ptr<Action> make_frame_action(const Frame& frame, const Environment& environment) {
  return std::make_unique<FrameAction>(frame, environment);
}

} // namespace insitu::scene
