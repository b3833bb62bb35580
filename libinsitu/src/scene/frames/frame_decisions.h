#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "render/structures/scalar_field.h"
#include "scene/parse/frame_description.h"
#include "scene/run/plan.h"

namespace insitu::scene {

/// What the decisions of a frame need to know of the mesh that it draws.
struct FrameFacts {
  /// Returns the number that is drawn of a field. Throws core::Error for a field or a component
  /// that the mesh does not have.
  std::function<render::ScalarField(const Name&, const Component&)> scalar;
  bool has_stand_in = false;   ///< whether other cells are drawn in the place of the solver's
  bool has_primitives = false; ///< whether these cells are primitives that can be culled
  bool has_values_of_leaves = false; ///< adaptive by `nearest`: values jump, vertices have none
};

/// The fields that a frame names.
using FieldsByName = std::map<std::string, mesh::FieldView>;

/// mesh: of the solver, or the geocentric one that is drawn in its place. fields: those of all
/// processes where there are several, which must outlive the facts; null: those of the mesh. The
/// facts are valid until the next commit of the mesh.
FrameFacts facts_of(const Frame& frame, const commit::CommittedMesh& mesh,
                    const std::string& scene_file, const FieldsByName* fields = nullptr);

/// A volume or a surface is coloured by the values of a field.
struct Coloring {
  const ColorBy* by = nullptr; ///< points into the frame
  render::ScalarField field;
  Decision pass; ///< whether a pass over the values finds the range of the colours
};

struct VolumeDecisions {
  Coloring coloring;
  Decision average;  ///< whether the average of the field at the vertices is drawn in its place
  bool flat = false; ///< whether what is drawn has one value a cell
  bool path_traced = false; ///< whether paths are traced; if not, rays are marched
  Decision shading, preintegration, step_levels;
  std::optional<Decision> culling; ///< an empty optional: the mesh has nothing that can be culled
};

struct IsosurfaceDecisions {
  render::ScalarField field;
  bool averages = false; ///< whether the renderer averages the field at the vertices
  Decision gradients;    ///< whether normals need gradients at the vertices
  render::Normals normals = render::Normals::cell;
  std::optional<Coloring> coloring;
};

/// What is decided about one of the meshes of a frame.
struct LayerDecisions {
  std::optional<VolumeDecisions> volume;
  std::vector<IsosurfaceDecisions> isosurfaces;
  std::optional<Coloring> boundary; ///< an empty optional: no boundary, or one of a single colour
  Decision vertex_cells;            ///< whether something sums over the cells around vertices
};

/// Everything that a frame decides from its description and the facts of its meshes. The settings
/// of the renderer and the frame's part of the plan are both made from these decisions.
struct FrameDecisions {
  Decision samples;       ///< whether pixels have several samples, with an image for one of them
  Decision depth, cell;   ///< images beside that of colour
  bool own_cells = false; ///< whether points at the depth tell the solver's cells from others
  Decision globe;
  bool lit = false;
  Decision surface_lighting, shadows, volume_shadows, occlusion;
  std::vector<LayerDecisions> layers; ///< as Frame::layers; of meshes that are left out nothing
  Decision scalar_bar;
};

/// facts: of the frame's meshes, as Frame::layers; of those that are left out nothing.
FrameDecisions decide_frame(const Frame& frame, std::span<const std::optional<FrameFacts>> facts);

} // namespace insitu::scene
