#include "scene/frames/frame_plan.h"

#include <algorithm>
#include <cstdio>

#include "output/annotate/box_ticks.h"
#include "render/color/preintegration.h"
#include "render/path/path_settings.h"
#include "render/structures/vertex_gradients.h"
#include "render/surface/outline.h"
#include "render/surface/triangle_mesh.h"
#include "render/volume/macrocells.h"
#include "render/volume/primitive_ranges.h"
#include "render/volume/step_levels.h"
#include "scene/earth/globe.h"
#include "scene/frames/frame_plan_images.h"
#include "scene/run/lookup.h"

namespace insitu::scene {

namespace {

using Held = Plan::Held;

std::string quoted(const std::string& name) {
  return "'" + name + "'";
}

std::string scalar_name(const Name& field, const Component& component, int components) {
  if (components == 1)
    return quoted(field.text);
  return component.magnitude()
             ? "the magnitude of " + quoted(field.text)
             : "component " + std::to_string(component.index) + " of " + quoted(field.text);
}

class FramePlanner {
public:
  FramePlanner(const Frame& frame, const FrameSettingsMaker& settings,
               const commit::CommittedMesh& mesh, const core::Threads& threads, Plan& plan)
      : frame_(frame), settings_(settings), mesh_(mesh), view_(mesh.mesh().view()),
        threads_(threads), plan_(plan) {}

  void run() {
    plan_images(frame_, mesh_, plan_);
    geocentric();
    if (frame_.volume)
      volume(*frame_.volume);
    else
      for (const char* item : {"ray marching", "macrocell grid", "majorants", "volume shading",
                               "pre-integration", "step levels"})
        plan_.skip(item, "no volume is asked for");
    if (!frame_.path_tracing)
      plan_.skip("path tracing", "no scattering is asked for");
    for (const Isosurface& surface : frame_.isosurfaces)
      isosurface(surface);
    if (frame_.isosurfaces.empty())
      for (const char* item : {"value ranges of the tree", "vertex gradients"})
        plan_.skip(item, "no isosurface is asked for");
    vertex_cells();
    triangles();
    lighting();
    effect(FrameEffect::shadows, "shadows");
    effect(FrameEffect::volume_shadows, "volume shadows");
    effect(FrameEffect::ambient_occlusion, "ambient occlusion");
    if (frame_.clips.empty())
      plan_.skip("clips", "none is asked for");
    else
      plan_.need("clips", -1, std::to_string(frame_.clips.size()) + " of them");
  }

private:
  bool asks_for(FrameEffect which) const {
    return std::find(frame_.effects.begin(), frame_.effects.end(), which) != frame_.effects.end();
  }
  bool is_lit() const {
    return asks_for(FrameEffect::lighting) || asks_for(FrameEffect::shadows) ||
           asks_for(FrameEffect::volume_shadows) || asks_for(FrameEffect::ambient_occlusion);
  }
  void lighting() {
    const char* const item = "lighting of surfaces";
    if (frame_.isosurfaces.empty() && !frame_.boundary && frame_.bodies.empty())
      plan_.skip(item, "there is none");
    else if (is_lit())
      plan_.need(item, -1, "an effect of the frame, or with shadows or occlusion");
    else
      plan_.skip(item, "not among the frame's effects");
  }
  void effect(FrameEffect which, const char* name) {
    if (asks_for(which))
      plan_.need(name, -1, "an effect of the frame");
    else
      plan_.skip(name, "not among the frame's effects");
  }

  void geocentric() {
    if (!frame_.geocentric) {
      if (mesh_.reference_frame.kind != INSITU_FRAME_CARTESIAN)
        plan_.skip("geocentric vertices", "drawn in the mesh's own coordinates");
      return;
    }
    if (mesh_.reference_frame.kind == INSITU_FRAME_CARTESIAN)
      throw core::Error(INSITU_ERROR_SCENE, "geocentric: the mesh has Cartesian coordinates");
    char factor[32];
    std::snprintf(factor, sizeof factor, "%g", frame_.geocentric->exaggeration);
    const std::string what = std::string(", heights times ") + factor;
    plan_.need("geocentric vertices" + what,
               view_.vertex_count() * std::int64_t(sizeof(math::Vec3d)),
               "converted once, kept while the geometry holds");
    plan_.need("tree of geocentric cells" + what, mesh_.tree().bytes(),
               "about, as the mesh's own; refitted as it moves");
    const std::int64_t rows = std::min(frame_.size[1], 65);
    if (frame_.geocentric->globe || frame_.geocentric->graticule)
      plan_.need_at_most("globe", frame_.size[0] * rows * globe_bytes_a_pixel,
                         "while it is drawn, some rows at a time", Held::while_executed);
    else
      plan_.skip("globe", "neither globe nor graticule is asked for");
  }

  void triangles() {
    if (frame_.boundary) {
      plan_.need_at_most("face table", render::TriangleMesh::most_bytes_while_made(view_, threads_),
                         "while the boundary is found", Held::while_executed);
      plan_.need("boundary faces", render::TriangleMesh::bytes_about(mesh_.sampler()),
                 "about, as of a mesh that fills its box; kept while the geometry holds");
      if (const auto* by = std::get_if<ColorBy>(&frame_.boundary->color))
        range(scalar_name(by->field, by->component, find_field(mesh_, by->field, {}).components),
              by->colors.range);
    } else {
      for (const char* item : {"face table", "boundary faces"})
        plan_.skip(item, "no boundary is asked for");
    }
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
    if (!frame_.outline)
      plan_.skip("outline", "none is asked for");
    else if (frame_.outline->ticks)
      plan_.need_at_most("outline", (12 + output::most_box_ticks) * render::Outline::bytes_a_line,
                         "twelve lines, and ticks; while it is drawn", Held::while_executed);
    else
      plan_.need_at_most("outline", 12 * render::Outline::bytes_a_line,
                         "twelve lines, while it is drawn", Held::while_executed);
  }

  void range(const std::string& what, const std::optional<ValueRange>& given) {
    if (given)
      plan_.skip("pass over " + what, "the range is given");
    else
      plan_.need("pass over " + what, -1, "the range of the colours is automatic");
  }

  void average(const std::string& what, const std::string& why) {
    plan_.need("vertex average of " + what, view_.vertex_count() * std::int64_t(sizeof(double)),
               why);
    sums_over_cells_ = true;
  }

  void volume(const Volume& v) {
    const mesh::FieldView field = find_field(mesh_, v.field, {});
    const std::string what = scalar_name(v.field, v.component, field.components);
    if (frame_.path_tracing)
      path_tracing(what, *frame_.path_tracing);
    else
      plan_.need("ray marching of " + what, -1, "the frame's volume");
    range(what, v.colors.range);
    if (v.smooth && field.association == INSITU_CELL)
      average(what, "a smooth volume of a cell field");
    else
      plan_.skip("vertex average of " + what, field.association == INSITU_CELL
                                                  ? "the volume shows one value a cell"
                                                  : "a vertex field");
    if (frame_.path_tracing)
      path_majorants(what, *frame_.path_tracing);
    else
      macrocells(what, v);
    samples(what, v, field.association == INSITU_CELL && !v.smooth);
    if (mesh_.mesh().has_stand_in() && render::PrimitiveRanges::serve(mesh_.sampler(), {field}))
      culling(what, v);
  }

  /// What is done for a sample, or between two, where it is asked for. flat: one value a cell.
  void samples(const std::string& what, const Volume& v, bool flat) {
    const auto item = [&](const char* name, bool asked, bool needs_slope, const auto& need) {
      const std::string of = name + (" of " + what);
      if (!asked)
        plan_.skip(of, "not asked for");
      else if (frame_.path_tracing)
        plan_.skip(of, "the volume is path traced");
      else if (needs_slope && flat)
        plan_.skip(of, "the volume shows one value a cell");
      else
        need(of);
    };
    item("volume shading", v.shading, true, [&](const std::string& of) {
      plan_.need(of, -1, "by the gradient, of samples that show");
    });
    item("pre-integration", v.preintegrated, true, [&](const std::string& of) {
      const render::ColorMap& colors = *settings_.volume_colors();
      const std::size_t points =
          std::max<std::size_t>(2, v.opacity.empty() ? colors.opacity().size() : v.opacity.size());
      plan_.need_at_most(of, render::Preintegration::most_bytes(int(points), colors.scale()),
                         "tables of integrals, while it is drawn", Held::while_executed);
    });
    item("step levels", v.tolerance.has_value(), false, [&](const std::string& of) {
      plan_.need(of, usual_macrocells() * render::StepLevels::bytes_each,
                 "the volume has a tolerance; while it is drawn", Held::while_executed);
    });
  }
  std::int64_t usual_macrocells() const {
    return render::Macrocells::grid_of(mesh_.sampler(), render::Macrocells::usual_cells).count();
  }

  /// Of gridlets and stitching cells.
  void culling(const std::string& what, const Volume& v) {
    const std::string item = "tree of what shows of " + what;
    // Of all primitives; the tree at most as large as the mesh's.
    const std::int64_t ranges = query::CulledCells::primitives_of(mesh_.sampler()) *
                                render::PrimitiveRanges::bytes_a_primitive;
    const std::int64_t most = ranges + mesh_.tree().bytes();
    if (v.culling == render::Culling::never)
      plan_.skip(item, "culling is not asked for");
    else if (v.preintegrated && !frame_.path_tracing)
      plan_.skip(item, "pre-integration needs what does not show too");
    else
      plan_.need_at_most(item, most, "culling");
  }

  static bool shows_all(const Volume& v) {
    return v.nan_opacity > 0 && !v.opacity.empty() &&
           std::all_of(v.opacity.begin(), v.opacity.end(),
                       [](const OpacityPoint& p) { return p.opacity > 0; });
  }

  void macrocells(const std::string& what, const Volume& v) {
    const std::int64_t count = usual_macrocells();
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

  void path_tracing(const std::string& what, const PathTracing& p) {
    plan_.skip("ray marching", "the volume is path traced");
    plan_.need("path tracing of " + what, -1, std::to_string(p.samples) + " paths a pixel");
    const auto views = std::int64_t(std::max<std::size_t>(1, frame_.cameras.size()));
    if (p.accumulate)
      plan_.need("sums of samples of frame '" + frame_.name + "'",
                 views * frame_.size[0] * frame_.size[1] *
                     std::int64_t(sizeof(render::PathSums::Pixel)),
                 "samples accumulate, for each camera");
    else
      plan_.skip("sums of samples", "samples do not accumulate");
  }

  void path_majorants(const std::string& what, const PathTracing& p) {
    const std::int64_t count =
        render::Macrocells::grid_of(mesh_.sampler(), p.cells_per_macrocell).count();
    char each[48];
    std::snprintf(each, sizeof each, ", %g cells to each", p.cells_per_macrocell);
    const std::string of =
        what + (p.cells_per_macrocell == render::Macrocells::usual_cells ? std::string()
                                                                         : std::string(each));
    plan_.need("macrocell grid of " + of, count * render::Macrocells::bytes_each, "path tracing");
    plan_.need("majorants of " + of, count * render::Majorants::bytes_each, "path tracing");
    plan_.need("extinctions of " + of, count * std::int64_t(sizeof(float)),
               "majorants with the frame's density, while it is drawn", Held::while_executed);
  }

  /// For what sums over the cells around vertices.
  void vertex_cells() {
    if (sums_over_cells_)
      plan_.need("cells around vertices", render::VertexCells::bytes_for(view_, threads_),
                 "for vertex averages and gradients");
    else
      plan_.skip("cells around vertices", "neither averages nor gradients at vertices are needed");
  }

  void isosurface(const Isosurface& s) {
    const mesh::FieldView field = find_field(mesh_, s.field, {});
    const std::string what = scalar_name(s.field, s.component, field.components);
    if (field.association == INSITU_CELL)
      average(what, "an isosurface of a cell field");
    plan_.need("value ranges of " + what,
               std::int64_t(mesh_.tree().node_count()) * accel::ValueRanges::bytes_a_node,
               std::to_string(s.values.size()) +
                   (s.values.size() == 1 ? " isovalue" : " isovalues"));
    const std::string gradients = "vertex gradients of " + what;
    if (s.normals == render::Normals::smooth && is_lit()) {
      plan_.need(gradients, view_.vertex_count() * render::VertexGradients::bytes_a_vertex,
                 "smooth normals; found where they are seen");
      sums_over_cells_ = true;
    } else if (s.normals == render::Normals::smooth)
      plan_.skip(gradients, "nothing is lit");
    else
      plan_.skip(gradients, s.normals == render::Normals::cell
                                ? "normals are the cells' own gradients"
                                : "normals are central differences");
    if (const auto* by = std::get_if<ColorBy>(&s.color)) {
      const mesh::FieldView colors = find_field(mesh_, by->field, {});
      range(scalar_name(by->field, by->component, colors.components), by->colors.range);
    }
  }

  const Frame& frame_;
  const FrameSettingsMaker& settings_;
  const commit::CommittedMesh& mesh_;
  const mesh::MeshView& view_;
  const core::Threads& threads_;
  Plan& plan_;
  bool sums_over_cells_ = false;
};

} // namespace

void plan_frame(const Frame& frame, const FrameSettingsMaker& settings,
                const commit::CommittedMesh& mesh, const core::Threads& threads, Plan& plan) {
  FramePlanner(frame, settings, mesh, threads, plan).run();
}

} // namespace insitu::scene
