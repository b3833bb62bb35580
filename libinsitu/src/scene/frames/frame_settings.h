#pragma once

#include <map>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "render/frame.h"
#include "scene/frames/frame_decisions.h"
#include "scene/run/environment.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// Turns the description of a frame into what the renderer takes, cycle by cycle.
class FrameSettingsMaker {
public:
  /// Reads colour maps and bodies, so that a wrong one is told when the session opens: throws
  /// core::Error. frame must outlive this.
  FrameSettingsMaker(const Frame& frame, const Environment& environment);

  /// Makes all settings but the camera. What they point to lives until the structures' next end().
  render::FrameSettings make(const FrameDecisions& decisions, render::Structures& structures) const;
  /// One of the frame's cameras at a step. drawn: frames so far, for orbits.
  render::Camera camera(const Camera& camera, const commit::CommittedMesh& mesh, const Step& step,
                        std::int64_t drawn) const;

  /// Returns the colours of what the frame colours by a field, read from their files.
  const render::ColorMap& map_of(const ColorBy& by) const { return maps_.at(&by); }
  /// Of the frame, read from their files.
  std::span<const render::BodySettings> bodies() const { return bodies_; }

private:
  render::ColorMap color_map(const ColorMapChoice& colors) const;
  render::TransferFunction transfer(render::Structures& structures, const Coloring& coloring,
                                    const std::vector<OpacityPoint>& opacity = {}) const;
  std::variant<render::Color, render::ColorByField>
  surface_color(render::Structures& structures, const SurfaceColor& color,
                const std::optional<Coloring>& coloring) const;
  render::VolumeSettings volume(render::Structures& structures, const Volume& from,
                                const VolumeDecisions& decisions) const;
  render::IsosurfaceSettings isosurface(render::Structures& structures, const Isosurface& from,
                                        const IsosurfaceDecisions& decisions) const;
  std::vector<render::BodySettings> load_bodies() const;

  const Frame& frame_;
  Environment environment_;
  std::map<const ColorBy*, render::ColorMap> maps_; ///< of colorings_of() the frame
  std::vector<render::BodySettings> bodies_;
};

/// Returns the functions by which settings colour, in the order of colorings_of() the frame.
std::vector<const render::TransferFunction*> functions_of(const render::FrameSettings& settings);

} // namespace insitu::scene
