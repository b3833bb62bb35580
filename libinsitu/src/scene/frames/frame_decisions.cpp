#include "scene/frames/frame_decisions.h"

#include <algorithm>

#include "core/status.h"
#include "query/lattice/culled_cells.h"
#include "scene/run/lookup.h"

namespace insitu::scene {

namespace {

constexpr const char* while_drawn = "while it is drawn";
constexpr const char* no_effect = "not among the frame's effects";

template <class Item>
bool asks_for(const std::vector<Item>& items, Item item) {
  return std::find(items.begin(), items.end(), item) != items.end();
}

void decide_images(const Frame& frame, bool has_stand_in, FrameDecisions& d) {
  d.samples = frame.samples_per_pixel > 1
                  ? Decision{true, "several samples a pixel, one after the other"}
                  : Decision{false, "one sample a pixel"};
  const bool globe = frame.geocentric && (frame.geocentric->globe || frame.geocentric->graticule);
  d.globe = globe ? Decision{true, "while it is drawn, some rows at a time"}
                  : Decision{false, "neither globe nor graticule is asked for"};
  const bool cell = asks_for(frame.images, ImageKind::cell);
  d.cell = {cell, cell ? while_drawn : "not among the frame's images"};
  // In which of the solver's cells a point of a cell that stands in for it lies takes the point.
  d.own_cells = cell && has_stand_in;
  if (asks_for(frame.images, ImageKind::depth))
    d.depth = {true, while_drawn};
  else if (d.own_cells)
    d.depth = {true, "while it is drawn: it tells the solver's cells from those in their place"};
  else if (globe)
    d.depth = {true, "while it is drawn: what the globe hides"};
  else
    d.depth = {false, "not among the frame's images"};
}

/// Returns why surfaces are lit where the frame has no word about effects, or null where they are
/// not: colours of a field tell something of a boundary without light, one colour tells nothing.
const char* lit_by_default(const Frame& frame) {
  const auto has = [&](const auto& what) {
    return std::any_of(frame.layers.begin(), frame.layers.end(), what);
  };
  const auto isosurfaces = [](const FrameLayer& layer) { return !layer.isosurfaces.empty(); };
  const auto plain_boundary = [](const FrameLayer& layer) {
    return layer.boundary && std::holds_alternative<render::Color>(layer.boundary->color);
  };
  return frame.has_effects_key   ? nullptr
         : has(isosurfaces)      ? "isosurfaces, and no effects are listed"
         : !frame.bodies.empty() ? "bodies, and no effects are listed"
         : has(plain_boundary)   ? "a boundary of one colour, and no effects are listed"
                                 : nullptr;
}

void decide_lighting(const Frame& frame, FrameDecisions& d) {
  const auto choose = [&](FrameEffect effect) {
    const bool asked = asks_for(frame.effects, effect);
    return Decision{asked, asked ? "an effect of the frame" : no_effect};
  };
  d.shadows = choose(FrameEffect::shadows);
  d.volume_shadows = choose(FrameEffect::volume_shadows);
  d.occlusion = choose(FrameEffect::ambient_occlusion);
  if (d.volume_shadows && !d.shadows)
    d.shadows = {true, "with volume shadows"};
  const char* const by_default = lit_by_default(frame);
  d.lit = by_default || asks_for(frame.effects, FrameEffect::lighting) || d.shadows || d.occlusion;
  const bool has_surfaces =
      !frame.bodies.empty() ||
      std::any_of(frame.layers.begin(), frame.layers.end(), [](const FrameLayer& layer) {
        return !layer.isosurfaces.empty() || layer.boundary;
      });
  if (!has_surfaces)
    d.surface_lighting = {false, "there is none"};
  else if (by_default)
    d.surface_lighting = {true, by_default};
  else if (d.lit)
    d.surface_lighting = {true, "an effect of the frame, or with shadows or occlusion"};
  else
    d.surface_lighting = {false, no_effect};
}

Coloring decide_coloring(const ColorBy& by, const FrameFacts& facts) {
  return {&by, facts.scalar(by.field, by.component),
          by.colors.range ? Decision{false, "the range is given"}
                          : Decision{true, "the range of the colours is automatic"}};
}

std::optional<Coloring> decide_coloring(const SurfaceColor& color, const FrameFacts& facts) {
  const auto* by = std::get_if<ColorBy>(&color);
  return by ? std::optional(decide_coloring(*by, facts)) : std::nullopt;
}

/// Where the volume has no word about it, samples alone would draw rings; frames that list their
/// effects have what they list.
Decision integrates(const Frame& frame, const Volume& volume) {
  if (volume.preintegrated)
    return *volume.preintegrated ? Decision{true, "tables of integrals, while it is drawn"}
                                 : Decision{false, "the volume says no"};
  if (frame.has_effects_key)
    return {false, "the frame lists its effects"};
  if (volume.tolerance)
    return {false, "a tolerance makes steps uneven"};
  if (volume.culling == render::Culling::always)
    return {false, "culling leaves out what does not show"};
  if (frame.accuracy == INSITU_FAST)
    return {false, "the frame's accuracy is fast"};
  return {true, "against rings, by default: tables of integrals, while it is drawn"};
}

VolumeDecisions decide_volume(const Frame& frame, const Volume& volume, const FrameFacts& facts) {
  const bool path_traced = frame.path_tracing.has_value();
  VolumeDecisions d;
  d.coloring = decide_coloring(volume, facts);
  const bool of_cells = d.coloring.field.field.association == INSITU_CELL;
  d.flat = of_cells && !volume.smooth;
  d.path_traced = path_traced;
  d.average = d.flat      ? Decision{false, "the volume shows one value a cell"}
              : !of_cells ? Decision{false, "a vertex field"}
                          : Decision{true, "a smooth volume of a cell field"};
  const auto choose = [&](bool asked, bool needs_slope, const char* why) {
    return !asked                  ? Decision{false, "not asked for"}
           : path_traced           ? Decision{false, "the volume is path traced"}
           : needs_slope && d.flat ? Decision{false, "the volume shows one value a cell"}
                                   : Decision{true, why};
  };
  d.shading = choose(volume.shading, true, "by the gradient, of samples that show");
  const Decision integral = integrates(frame, volume);
  d.preintegration = integral.made ? choose(true, true, integral.why) : integral;
  d.step_levels =
      choose(volume.tolerance.has_value(), false, "the volume has a tolerance; while it is drawn");
  if (facts.has_primitives && !d.flat)
    d.culling = volume.culling == render::Culling::never
                    ? Decision{false, "culling is not asked for"}
                : d.preintegration ? Decision{false, "pre-integration needs what does not show too"}
                                   : Decision{true, "culling"};
  return d;
}

IsosurfaceDecisions decide_isosurface(const Isosurface& surface, bool lit,
                                      const FrameFacts& facts) {
  IsosurfaceDecisions d;
  d.field = facts.scalar(surface.field, surface.component);
  d.averages = d.field.field.association == INSITU_CELL;
  d.normals = surface.normals;
  if (surface.normals == render::Normals::cell) {
    d.gradients = {false, "normals are the cells' own gradients"};
  } else if (surface.normals == render::Normals::central) {
    d.gradients = {false, "normals are central differences"};
  } else if (lit) {
    d.gradients = {true, "smooth normals; found where they are seen"};
  } else {
    d.gradients = {false, "nothing is lit"};
    d.normals = render::Normals::cell;
  }
  d.coloring = decide_coloring(surface.color, facts);
  return d;
}

bool sums_over_cells(const LayerDecisions& d) {
  return (d.volume && d.volume->average) ||
         std::any_of(d.isosurfaces.begin(), d.isosurfaces.end(),
                     [](const IsosurfaceDecisions& s) { return s.averages || s.gradients; });
}

LayerDecisions decide_layer(const Frame& frame, const FrameLayer& layer, bool lit,
                            const FrameFacts& facts) {
  LayerDecisions d;
  if (layer.volume)
    d.volume = decide_volume(frame, *layer.volume, facts);
  for (const Isosurface& surface : layer.isosurfaces)
    d.isosurfaces.push_back(decide_isosurface(surface, lit, facts));
  if (layer.boundary)
    d.boundary = decide_coloring(layer.boundary->color, facts);
  d.vertex_cells = sums_over_cells(d)
                       ? Decision{true, "for vertex averages and gradients"}
                       : Decision{false, "neither averages nor gradients at vertices are needed"};
  if (d.vertex_cells.made && facts.has_values_of_leaves)
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "isosurfaces and smooth volumes of an adaptive mesh whose reconstruction is "
                      "`nearest`: its values jump from leaf to leaf; with `dual` they do not");
  return d;
}

bool colors_by_field(const LayerDecisions& d) {
  return d.volume || d.boundary ||
         std::any_of(d.isosurfaces.begin(), d.isosurfaces.end(),
                     [](const IsosurfaceDecisions& s) { return s.coloring.has_value(); });
}

} // namespace

FrameFacts facts_of(const Frame& frame, const commit::CommittedMesh& mesh,
                    const std::string& scene_file, const FieldsByName* fields) {
  FrameFacts facts;
  facts.scalar = [&mesh, scene_file, fields](const Name& name, const Component& component) {
    const mesh::FieldView field =
        fields ? fields->at(name.text) : find_field(mesh, name, scene_file);
    if (component.index >= field.components)
      throw core::Error(INSITU_ERROR_SCENE, at_line(scene_file, name.line) + "component " +
                                                std::to_string(component.index) + " of field '" +
                                                name.text + "', which has " +
                                                std::to_string(field.components));
    return render::ScalarField{field, component.index};
  };
  facts.has_stand_in = mesh.mesh().has_stand_in() && !frame.geocentric;
  facts.has_primitives = facts.has_stand_in && query::CulledCells::serves(mesh.sampler());
  facts.has_values_of_leaves =
      mesh.mesh().is_adaptive() && mesh.mesh().reconstruction() == INSITU_NEAREST;
  return facts;
}

FrameDecisions decide_frame(const Frame& frame, std::span<const std::optional<FrameFacts>> facts) {
  FrameDecisions d;
  decide_images(frame,
                std::any_of(facts.begin(), facts.end(),
                            [](const auto& of) { return of && of->has_stand_in; }),
                d);
  decide_lighting(frame, d);
  for (std::size_t i = 0; i < frame.layers.size(); ++i)
    d.layers.push_back(facts[i] ? decide_layer(frame, frame.layers[i], d.lit, *facts[i])
                                : LayerDecisions{});
  d.scalar_bar = !frame.scalar_bar ? Decision{false, "not asked for"}
                 : !std::any_of(d.layers.begin(), d.layers.end(), colors_by_field)
                     ? Decision{false, "nothing is coloured by a field"}
                     : Decision{true, "drawn over the image"};
  return d;
}

} // namespace insitu::scene
