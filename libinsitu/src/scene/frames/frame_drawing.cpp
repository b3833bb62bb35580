#include "scene/frames/frame_drawing.h"

#include <algorithm>

#include "output/annotate/overlay.h"
#include "scene/frames/chart_copies.h"
#include "scene/frames/cinema_table.h"

namespace insitu::scene {

namespace {

std::string title_of(const ScalarBar& bar, const ColorBy& by) {
  const std::string title = bar.title.empty() ? by.field.text : bar.title;
  return bar.unit.empty() ? title : title + " (" + bar.unit + ")";
}

void draw_bar(const Frame& frame, const Drawing& drawing, output::Overlay overlay,
              core::Image& image) {
  for (const DrawnMesh& drawn : drawing.meshes) {
    const std::vector<const ColorBy*> by = colorings_of(frame.layers[drawn.layer]);
    if (by.empty())
      continue;
    overlay.names_nan = by.front()->colors.nan.has_value();
    output::draw_scalar_bar(image, *functions_of(drawn.settings).front(),
                            title_of(*frame.scalar_bar, *by.front()), overlay);
    return;
  }
}

} // namespace

void put_on_one_chart(std::vector<DrawnMesh>& meshes, const Environment& environment) {
  if (meshes.size() < 2)
    return;
  parallel::World& world = environment.world;
  std::vector<const commit::CommittedMesh*> own;
  std::int64_t has_copies = 0;
  world.agree_after([&] {
    for (const DrawnMesh& drawn : meshes) {
      own.push_back(drawn.own);
      has_copies |= has_chart_copies(*drawn.own);
    }
  });
  world.reduce(std::span(&has_copies, 1), parallel::Reduction::greatest);
  const std::optional<double> west = first_west(own);
  for (std::size_t i = 0; i < meshes.size() && has_copies && west; ++i) {
    if (!(first_west({&own[i], 1}).value_or(*west) > *west))
      continue;
    world.agree_after([&] { meshes[i].mesh = &environment.structures.on_chart(*own[i], *west); });
    meshes[i].mesh->update_chart(world, environment.context.threads, environment.context.log);
  }
}

FrameSettingsMaker::Scenery scenery_of(const std::vector<DrawnMesh>& meshes) {
  FrameSettingsMaker::Scenery all{meshes.front().mesh->sampler().facts().bounds, true};
  for (const DrawnMesh& drawn : meshes) {
    all.box.extend(drawn.mesh->sampler().facts().bounds);
    all.is_flat = all.is_flat && drawn.mesh->is_flat();
  }
  return all;
}

std::vector<render::FramePart> parts_of(const Frame& frame, const Drawing& drawing,
                                        parallel::World& world) {
  std::vector<render::FramePart> parts;
  for (const DrawnMesh& drawn : drawing.meshes) {
    const FrameKeys& keys = *drawn.known.keys;
    parts.push_back({world, drawn.mesh->mesh().view().own_cell_count(),
                     [&keys](std::int64_t flat) { return keys.key(flat); }});
    parts.back().compositing = frame.compositing;
    if (drawing.decisions.own_cells)
      parts.back().solvers_cell = [&keys](const math::Vec3d& place) {
        return keys.solvers_at(place);
      };
  }
  return parts;
}

DrawnLayers::DrawnLayers(const Drawing& drawing) {
  for (const DrawnMesh& drawn : drawing.meshes) {
    samplers.push_back(drawing.parts.empty() ? drawn.mesh->sampler() : drawn.mesh->own_sampler());
    located.push_back(drawn.mesh->located());
  }
  for (std::size_t i = 0; i < samplers.size(); ++i)
    layers.push_back({samplers[i], drawing.meshes[i].settings, *drawing.meshes[i].structures});
}

render::FrameImages draw_meshes(const Drawing& drawing, const DrawnLayers& layers,
                                const core::Threads& threads, render::FrameStatistics& done) {
  render::FrameImages images =
      drawing.parts.empty()
          ? render::render_frame(layers.layers, threads, &done)
          : render::render_shared_frame(drawing.parts, layers.layers, threads, &done);
  for (std::size_t i = 0; i < drawing.meshes.size(); ++i) {
    const commit::CommittedMesh& mesh = *drawing.meshes[i].mesh;
    mesh.note_drawn(mesh.located() - layers.located[i]);
  }
  return images;
}

void draw_overlays(const Frame& frame, const Drawing& drawing, const output::BoxTicks& ticks,
                   core::Image& image) {
  const render::FrameSettings& settings = drawing.first().settings;
  output::Overlay overlay;
  overlay.background = settings.background;
  output::draw_box_labels(image, ticks, overlay);
  if (drawing.decisions.scalar_bar)
    draw_bar(frame, drawing, overlay, image);
  if (frame.axes)
    output::draw_axes(image, render::CameraAxes(settings.camera), overlay);
  if (frame.time_label)
    output::draw_time_label(image, (*frame.time_label)(drawing.step.time, drawing.step.cycle),
                            overlay);
}

void tell_cells(const Frame& frame, const Drawing& drawing, const core::Threads& threads,
                render::FrameImages& images) {
  const render::FrameSettings& settings = drawing.first().settings;
  const render::RayGenerator rays(settings.camera, settings.width, settings.height);
  if (!images.cell.empty() && frame.layers.size() > 1)
    images.layer.resize(images.cell.size()); // of a mesh that is drawn alone there is none yet
  const bool alone = drawing.parts.empty();
  const auto solvers = [&](const DrawnMesh& drawn, std::size_t at) {
    std::int64_t cell = images.cell[at];
    if (!alone)
      return drawn.known.keys->solvers(cell);
    if (drawing.decisions.own_cells) {
      const auto width = std::size_t(settings.width);
      const render::Ray ray = rays(int(at % width), int(at / width));
      const math::Vec3d p = ray.origin + double(images.depth[at]) * ray.direction;
      cell = drawn.mesh->own({cell, {}}, p).cell;
    }
    const mesh::Mesh& own = drawn.own->mesh();
    return cell >= 0 && own.has_global_ids(INSITU_CELL) ? own.global_id(INSITU_CELL, cell) : cell;
  };
  constexpr std::int64_t grain = 4096;
  threads.parallel_for(
      std::int64_t(images.cell.size()), grain, [&](std::int64_t begin, std::int64_t end) {
        for (auto at = std::size_t(begin); at < std::size_t(end); ++at) {
          const std::size_t layer = images.layer.empty() ? 0 : std::size_t(images.layer[at]);
          const DrawnMesh& drawn = drawing.meshes[layer];
          if (images.cell[at] >= 0)
            images.cell[at] = solvers(drawn, at);
          if (!images.layer.empty())
            images.layer[at] = std::int32_t(drawn.layer);
        }
      });
}

std::vector<std::pair<std::string, ValueRange>> ranges_of(const Frame& frame,
                                                          const Drawing& drawing) {
  std::vector<std::pair<std::string, ValueRange>> ranges;
  for (const DrawnMesh& drawn : drawing.meshes) {
    const FrameLayer& layer = frame.layers[drawn.layer];
    const std::vector<const ColorBy*> by = colorings_of(layer);
    const std::vector<const render::TransferFunction*> functions = functions_of(drawn.settings);
    for (std::size_t i = 0; i < by.size(); ++i)
      ranges.emplace_back(range_label(frame, layer, *by[i]),
                          ValueRange{functions[i]->low(), functions[i]->high()});
  }
  return ranges;
}

} // namespace insitu::scene
