#pragma once

#include <cstddef>
#include <vector>

#include "output/annotate/box_ticks.h"
#include "render/processes/frame_part.h"
#include "scene/frames/frame_on_all.h"
#include "scene/frames/frame_settings.h"

namespace insitu::scene {

/// A mesh that a frame draws in a cycle.
struct DrawnMesh {
  std::size_t layer;           ///< of Frame::layers
  commit::CommittedMesh* own;  ///< the solver's mesh
  commit::CommittedMesh* mesh; ///< the mesh that is drawn
  render::Structures* structures = nullptr;
  LayerOnAll known = {};
  render::FrameSettings settings = {}; ///< the camera and what follows it are set for each image
};

/// The images of one cycle.
struct Drawing {
  const Step& step;
  FrameDecisions decisions;
  std::vector<DrawnMesh> meshes; ///< at least one
  /// parts_of() it, where there are several processes; empty: there is one.
  std::vector<render::FramePart> parts = {};

  DrawnMesh& first() { return meshes.front(); }
  const DrawnMesh& first() const { return meshes.front(); }
};

/// Where cells of one of several meshes in longitude and latitude are drawn over the seam, all
/// begin at one longitude: meshes whose chart begins further east are drawn in copies of theirs
/// that do. Collective; throws parallel::AgreedError.
void put_on_one_chart(std::vector<DrawnMesh>& meshes, const Environment& environment);

/// What cameras look at: around all meshes, flat if all of them are.
FrameSettingsMaker::Scenery scenery_of(const std::vector<DrawnMesh>& meshes);

/// What a process has to do with the drawing's meshes, whose keys are known; they must outlive it.
std::vector<render::FramePart> parts_of(const Frame& frame, const Drawing& drawing,
                                        parallel::World& world);

/// What the renderer takes of the meshes of a drawing, which must outlive it.
struct DrawnLayers {
  explicit DrawnLayers(const Drawing& drawing);
  std::vector<query::Sampler> samplers;
  std::vector<std::int64_t> located; ///< points, before
  std::vector<render::FrameLayer> layers;
};

/// Draws the frame's images, without what stands over them. Collective; throws
/// parallel::AgreedError.
render::FrameImages draw_meshes(const Drawing& drawing, const DrawnLayers& layers,
                                const core::Threads& threads, render::FrameStatistics& done);

/// Draws what stands over the image: the outline's numbers, scalar bar, axes, time label.
void draw_overlays(const Frame& frame, const Drawing& drawing, const output::BoxTicks& ticks,
                   core::Image& image);

/// Makes the cells that are seen the solver's, by global ids where it gives some, and their layers
/// those of the frame.
void tell_cells(const Frame& frame, const Drawing& drawing, const core::Threads& threads,
                render::FrameImages& images);

/// The ranges of the frame's colours, for the table.
std::vector<std::pair<std::string, ValueRange>> ranges_of(const Frame& frame,
                                                          const Drawing& drawing);

} // namespace insitu::scene
