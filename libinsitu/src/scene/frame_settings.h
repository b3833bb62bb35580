#pragma once

#include <optional>
#include <vector>

#include "render/frame.h"
#include "scene/action.h"

namespace insitu::scene {

/// Turns the description of a frame into what the renderer takes, cycle by cycle.
class FrameSettingsMaker {
public:
  /// Reads the colour maps, so that a wrong one is told when the session opens: throws core::Error.
  /// frame must outlive this.
  FrameSettingsMaker(const Frame& frame, const Environment& environment);

  /// For the mesh as it is now. drawn: frames so far, for orbits. What settings point to lives
  /// until the structures' next end().
  render::FrameSettings make(const query::CommittedMesh& mesh, render::Structures& structures,
                             std::int64_t drawn) const;

private:
  render::ColorMap color_map(const ColorMap& colors) const;
  std::string at_line(int line) const;
  render::ScalarField scalar(const query::CommittedMesh& mesh, const Name& name,
                             const Component& component) const;
  render::TransferFunction transfer(render::Structures& structures,
                                    const render::ScalarField& field,
                                    const render::ColorMap& colors,
                                    const std::optional<ValueRange>& range,
                                    const std::vector<OpacityPoint>& opacity) const;
  render::VolumeSettings volume(const query::CommittedMesh& mesh, render::Structures& structures,
                                const Volume& from) const;
  render::IsosurfaceSettings isosurface(const query::CommittedMesh& mesh,
                                        render::Structures& structures, const Isosurface& from,
                                        const std::optional<render::ColorMap>& colors) const;
  render::PathTracingSettings path_tracing(const PathTracing& from) const;
  render::Camera camera(const query::CommittedMesh& mesh, std::int64_t drawn) const;

  const Frame& frame_;
  Environment environment_;
  std::optional<render::ColorMap> volume_colors_;
  std::vector<std::optional<render::ColorMap>> surface_colors_;
};

} // namespace insitu::scene
