#pragma once

#include <map>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "mesh/box.h"
#include "render/frame.h"
#include "scene/frames/frame_decisions.h"
#include "scene/run/environment.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// The ranges of values by which a frame colours.
using RangesByColor = std::map<const ColorBy*, render::ScalarRange>;

/// Turns the description of a frame into what the renderer takes, cycle by cycle.
class FrameSettingsMaker {
public:
  /// Reads colour maps and bodies, so that a wrong one is told when the session opens: throws
  /// core::Error. frame must outlive this.
  FrameSettingsMaker(const Frame& frame, const Environment& environment);

  /// What the settings of a mesh are made of besides the frame and what it decided.
  struct From {
    std::size_t layer; ///< of Frame::layers
    render::Structures& structures;
    /// Of all processes where there are several; null: of the structures' mesh.
    const RangesByColor* ranges = nullptr;
    /// Around all meshes that are drawn, of a frame of several; null: there is one.
    const mesh::Box* all = nullptr;
    bool is_first = true; ///< of those that are drawn: it gets the bodies and the outline
  };
  /// Makes all settings but the camera. What they point to lives until the structures' next end().
  render::FrameSettings make(const FrameDecisions& decisions, const From& from) const;
  /// What cameras look at.
  struct Scenery {
    mesh::Box box;
    bool is_flat = false;
  };
  /// One of the frame's cameras at a step. drawn: frames so far, for orbits.
  render::Camera camera(const Camera& camera, const Scenery& scenery, const Step& step,
                        std::int64_t drawn) const;

  /// Returns the colours of what the frame colours by a field, read from their files.
  const render::ColorMap& map_of(const ColorBy& by) const { return maps_.at(&by); }
  /// Of the frame, read from their files.
  std::span<const render::BodySettings> bodies() const { return bodies_; }

private:
  render::ColorMap color_map(const ColorMapChoice& colors) const;
  render::TransferFunction transfer(const From& from, const Coloring& coloring,
                                    const std::vector<OpacityPoint>& opacity = {}) const;
  std::variant<render::Color, render::ColorByField>
  surface_color(const From& from, const SurfaceColor& color,
                const std::optional<Coloring>& coloring) const;
  render::VolumeSettings volume(const From& made_of, const Volume& from,
                                const VolumeDecisions& decisions) const;
  render::IsosurfaceSettings isosurface(const From& made_of, const Isosurface& from,
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
