#include "scene/frames/frame_plan.h"

#include <algorithm>
#include <cstdio>

#include "output/annotate/box_ticks.h"
#include "render/color/preintegration.h"
#include "render/path/path_grid.h"
#include "render/path/path_tracer.h"
#include "render/structures/vertex_gradients.h"
#include "render/surface/outline.h"
#include "render/surface/triangle_mesh.h"
#include "render/volume/macrocells.h"
#include "render/volume/primitive_ranges.h"
#include "render/volume/step_levels.h"
#include "scene/earth/globe.h"
#include "scene/frames/frame_plan_images.h"

namespace insitu::scene {

namespace {

using Held = Plan::Held;

std::string quoted(const std::string& name) {
  return "'" + name + "'";
}

std::string scalar_name(const render::ScalarField& scalar) {
  const std::string field = quoted(scalar.field.name);
  if (scalar.field.components == 1)
    return field;
  return scalar.component < 0 ? "the magnitude of " + field
                              : "component " + std::to_string(scalar.component) + " of " + field;
}

class FramePlanner {
public:
  FramePlanner(const Frame& frame, std::size_t layer, const FrameSettingsMaker& settings,
               const FrameDecisions& decisions, const commit::CommittedMesh& mesh,
               const core::Threads& threads, Plan& plan)
      : frame_(frame), layer_(frame.layers[layer]), settings_(settings), decisions_(decisions),
        decided_(decisions.layers[layer]), mesh_(mesh), view_(mesh.mesh().view()),
        threads_(threads), plan_(plan), is_first_(layer == 0) {}

  void run() {
    if (is_first_)
      plan_images(frame_, decisions_, plan_);
    geocentric();
    if (layer_.volume)
      volume(*layer_.volume, *decided_.volume);
    else
      skip({"ray marching", "macrocell grid", "majorants", "volume shading", "pre-integration",
            "step levels"},
           "no volume is asked for");
    if (!frame_.path_tracing || !layer_.volume)
      plan_.skip("path tracing", frame_.path_tracing ? "no volume of the mesh is asked for"
                                                     : "no scattering is asked for");
    for (std::size_t i = 0; i < layer_.isosurfaces.size(); ++i)
      isosurface(layer_.isosurfaces[i], decided_.isosurfaces[i]);
    if (layer_.isosurfaces.empty())
      skip({"value ranges of the tree", "vertex gradients"}, "no isosurface is asked for");
    plan_.tell("cells around vertices", decided_.vertex_cells,
               decided_.vertex_cells ? render::VertexCells::bytes_for(view_, threads_) : 0);
    boundary();
    if (is_first_)
      beside_meshes();
  }

private:
  /// What a frame has once, whatever its meshes.
  void beside_meshes() {
    bodies();
    outline();
    plan_.tell("lighting of surfaces", decisions_.surface_lighting);
    plan_.tell("shadows", decisions_.shadows);
    plan_.tell("volume shadows", decisions_.volume_shadows);
    plan_.tell("ambient occlusion", decisions_.occlusion);
    if (frame_.clips.empty())
      plan_.skip("clips", "none is asked for");
    else
      plan_.need("clips", -1, std::to_string(frame_.clips.size()) + " of them");
  }

  void skip(std::initializer_list<const char*> items, const char* why) {
    for (const char* item : items)
      plan_.skip(item, why);
  }

  void geocentric() {
    if (!frame_.geocentric) {
      if (mesh_.reference_frame.kind != INSITU_FRAME_CARTESIAN)
        plan_.skip("geocentric vertices", "drawn in the mesh's own coordinates");
      return;
    }
    char factor[32];
    std::snprintf(factor, sizeof factor, "%g", frame_.geocentric->exaggeration);
    const std::string what = std::string(", heights times ") + factor;
    plan_.need("geocentric vertices" + what,
               view_.vertex_count() * std::int64_t(sizeof(math::Vec3d)),
               "converted once, kept while the geometry holds");
    plan_.need("tree of geocentric cells" + what, mesh_.tree().bytes(),
               "about, as the mesh's own; refitted as it moves");
    const std::int64_t rows = std::min(frame_.size[1], 65);
    plan_.tell_at_most("globe", decisions_.globe, frame_.size[0] * rows * globe_bytes_a_pixel,
                       Held::while_executed);
  }

  void boundary() {
    if (!layer_.boundary) {
      skip({"face table", "boundary faces"}, "no boundary is asked for");
      return;
    }
    plan_.need_at_most("face table", render::TriangleMesh::most_bytes_while_made(view_, threads_),
                       "while the boundary is found", Held::while_executed);
    plan_.need("boundary faces", render::TriangleMesh::bytes_about(mesh_.sampler()),
               "about, as of a mesh that fills its box; kept while the geometry holds");
    pass(decided_.boundary);
  }

  void bodies() {
    for (const render::BodySettings& body : settings_.bodies()) {
      const render::TriangleList& list = *body.triangles;
      plan_.need("corners in " + quoted(list.source) + ", for frame '" + frame_.name + "'",
                 std::int64_t(list.corners.capacity() * sizeof(math::Vec3d)), "read once");
      plan_.need("triangles of " + quoted(list.source),
                 render::TriangleMesh::bytes_about(std::int64_t(list.corners.size() / 3)),
                 "about; a body");
    }
    if (settings_.bodies().empty())
      plan_.skip("bodies", "none is asked for");
  }

  void outline() {
    if (!frame_.outline)
      plan_.skip("outline", "none is asked for");
    else if (frame_.outline->ticks)
      plan_.need_at_most("outline", (12 + output::most_box_ticks) * render::Outline::bytes_a_line,
                         "twelve lines, and ticks; while it is drawn", Held::while_executed);
    else
      plan_.need_at_most("outline", 12 * render::Outline::bytes_a_line,
                         "twelve lines, while it is drawn", Held::while_executed);
  }

  void pass(const std::optional<Coloring>& coloring) {
    if (coloring)
      plan_.tell("pass over " + scalar_name(coloring->field), coloring->pass);
  }

  void average(const std::string& what, const Decision& decision) {
    plan_.tell("vertex average of " + what, decision,
               view_.vertex_count() * std::int64_t(sizeof(double)));
  }

  void volume(const Volume& v, const VolumeDecisions& d) {
    const std::string what = scalar_name(d.coloring.field);
    if (d.path_traced)
      path_tracing(what, *frame_.path_tracing);
    else
      plan_.need("ray marching of " + what, -1, "the frame's volume");
    pass(d.coloring);
    average(what, d.average);
    if (d.path_traced)
      path_majorants(what, *frame_.path_tracing);
    else
      macrocells(what, v);
    plan_.tell("volume shading of " + what, d.shading);
    const render::ColorMap& colors = settings_.map_of(v);
    const std::size_t points =
        std::max<std::size_t>(2, v.opacity.empty() ? colors.opacity().size() : v.opacity.size());
    plan_.tell_at_most("pre-integration of " + what, d.preintegration,
                       render::Preintegration::most_bytes(int(points), colors.scale()),
                       Held::while_executed);
    plan_.tell("step levels of " + what, d.step_levels,
               macrocells_of(v) * render::StepLevels::bytes_each, Held::while_executed);
    if (d.culling) // of all primitives; the tree at most as large as the mesh's
      plan_.tell_at_most("tree of what shows of " + what, *d.culling,
                         query::CulledCells::primitives_of(mesh_.sampler()) *
                                 render::PrimitiveRanges::bytes_a_primitive +
                             mesh_.tree().bytes());
  }
  std::int64_t macrocells_of(const Volume& v) const {
    if (!v.tolerance)
      return render::Macrocells::grid_of(mesh_.sampler(), {}).count();
    const mesh::MeshFacts facts = mesh_.sampler().facts(&threads_);
    return render::level_grid(facts, render::cell_widths(mesh_.sampler(), facts.bounds, threads_))
        .count();
  }

  static bool shows_all(const Volume& v) {
    return v.nan_opacity > 0 && !v.opacity.empty() &&
           std::all_of(v.opacity.begin(), v.opacity.end(),
                       [](const OpacityPoint& p) { return p.opacity > 0; });
  }

  void macrocells(const std::string& what, const Volume& v) {
    const std::int64_t count = macrocells_of(v);
    const std::string grid = "macrocell grid of " + what, majorants = "majorants of " + what;
    const char* const if_it_pays = "to skip what is empty, if a look at some cells tells it pays";
    const char* const all_shows = "the opacity is nowhere 0, of NaN neither";
    if (v.tolerance)
      plan_.need(grid, count * render::Macrocells::bytes_each_with_size,
                 "the volume has a tolerance");
    else if (shows_all(v))
      plan_.skip(grid, all_shows);
    else
      plan_.need_at_most(grid, count * render::Macrocells::bytes_each, if_it_pays);
    if (shows_all(v))
      plan_.skip(majorants, all_shows);
    else
      plan_.need_at_most(majorants, count * render::Majorants::bytes_each, if_it_pays);
  }

  static bool has_volume(const FrameLayer& layer) { return layer.volume.has_value(); }

  void path_tracing(const std::string& what, const PathTracing& p) {
    plan_.skip("ray marching", "the volume is path traced");
    plan_.need("path tracing of " + what, -1, std::to_string(p.samples) + " paths a pixel");
    if (&layer_ != &*std::ranges::find_if(frame_.layers, &has_volume))
      return; // the sums are the frame's
    const auto views = std::int64_t(cameras_of(frame_).size());
    if (p.accumulate)
      plan_.need("sums of samples of frame '" + frame_.name + "'",
                 views * frame_.size[0] * frame_.size[1] *
                     std::int64_t(sizeof(render::PathSums::Pixel)),
                 "samples accumulate, for each camera");
    else
      plan_.skip("sums of samples", "samples do not accumulate");
  }

  void path_majorants(const std::string& what, const PathTracing& p) {
    const mesh::MeshFacts facts = mesh_.sampler().facts(&threads_);
    const std::int64_t count =
        render::path_grid(facts, render::cell_widths(mesh_.sampler(), facts.bounds, threads_),
                          p.cells_per_macrocell)
            .count();
    char each[80];
    std::snprintf(each, sizeof each, ", %g cells to each, %g of them at most",
                  p.cells_per_macrocell, render::most_path_macrocells);
    const std::string of = what + each;
    plan_.need("macrocell grid of " + of, count * render::Macrocells::bytes_each, "path tracing");
    plan_.need("majorants of " + of, count * render::Majorants::bytes_each, "path tracing");
    plan_.need("extinctions of " + of, count * std::int64_t(sizeof(float)),
               "majorants with the frame's density, while it is drawn", Held::while_executed);
  }

  void isosurface(const Isosurface& s, const IsosurfaceDecisions& d) {
    const std::string what = scalar_name(d.field);
    if (d.averages)
      average(what, {true, "an isosurface of a cell field"});
    plan_.need("value ranges of " + what,
               std::int64_t(mesh_.tree().node_count()) * accel::ValueRanges::bytes_a_node,
               std::to_string(s.values.size()) +
                   (s.values.size() == 1 ? " isovalue" : " isovalues"));
    plan_.tell("vertex gradients of " + what, d.gradients,
               view_.vertex_count() * render::VertexGradients::bytes_a_vertex);
    pass(d.coloring);
  }

  const Frame& frame_;
  const FrameLayer& layer_;
  const FrameSettingsMaker& settings_;
  const FrameDecisions& decisions_;
  const LayerDecisions& decided_;
  const commit::CommittedMesh& mesh_;
  const mesh::MeshView& view_;
  const core::Threads& threads_;
  Plan& plan_;
  bool is_first_;
};

} // namespace

void plan_frame(const Frame& frame, std::size_t layer, const FrameSettingsMaker& settings,
                const FrameDecisions& decisions, const commit::CommittedMesh& mesh,
                const core::Threads& threads, Plan& plan) {
  FramePlanner(frame, layer, settings, decisions, mesh, threads, plan).run();
}

} // namespace insitu::scene
