#pragma once

#include <optional>
#include <vector>

#include "render/frame.h"
#include "scene/run/environment.h"
#include "scene/run/step.h"

namespace insitu::scene {

/// Turns the description of a frame into what the renderer takes, cycle by cycle.
class FrameSettingsMaker {
public:
  /// Reads colour maps and bodies, so that a wrong one is told when the session opens: throws
  /// core::Error. frame must outlive this.
  FrameSettingsMaker(const Frame& frame, const Environment& environment);

  /// For the mesh as it is now, but for the camera. What settings point to lives until the
  /// structures' next end().
  render::FrameSettings make(const commit::CommittedMesh& mesh,
                             render::Structures& structures) const;
  /// One of the frame's cameras at a step. drawn: frames so far, for orbits.
  render::Camera camera(const Camera& camera, const commit::CommittedMesh& mesh, const Step& step,
                        std::int64_t drawn) const;

  /// The ranges that its colours stretch over, by range_label().
  std::vector<std::pair<std::string, ValueRange>>
  ranges(const render::FrameSettings& settings) const;

  /// Of the volume, if there is one.
  const std::optional<render::ColorMap>& volume_colors() const { return volume_colors_; }
  /// Of the frame, read from their files.
  std::span<const render::BodySettings> bodies() const { return bodies_; }

private:
  render::ColorMap color_map(const ColorMapChoice& colors) const;
  render::ScalarField scalar(const commit::CommittedMesh& mesh, const Name& name,
                             const Component& component) const;
  render::TransferFunction transfer(render::Structures& structures,
                                    const render::ScalarField& field,
                                    const render::ColorMap& colors,
                                    const std::optional<ValueRange>& range,
                                    const std::vector<OpacityPoint>& opacity = {}) const;
  render::VolumeSettings volume(const commit::CommittedMesh& mesh, render::Structures& structures,
                                const Volume& from) const;
  render::IsosurfaceSettings isosurface(const commit::CommittedMesh& mesh,
                                        render::Structures& structures, const Isosurface& from,
                                        const std::optional<render::ColorMap>& colors) const;
  render::BoundarySettings boundary(const commit::CommittedMesh& mesh,
                                    render::Structures& structures, const Boundary& from) const;
  std::vector<render::BodySettings> load_bodies() const;

  const Frame& frame_;
  Environment environment_;
  std::optional<render::ColorMap> volume_colors_;
  std::vector<std::optional<render::ColorMap>> surface_colors_;
  std::optional<render::ColorMap> boundary_colors_;
  std::vector<render::BodySettings> bodies_;
};

} // namespace insitu::scene
