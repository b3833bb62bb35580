#include "scene/frame_plan.h"

#include <algorithm>
#include <cstdio>

#include "render/macrocells.h"
#include "render/path_settings.h"
#include "render/primitive_ranges.h"
#include "scene/action.h"

namespace insitu::scene {

namespace {

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
  FramePlanner(const Frame& frame, const query::CommittedMesh& mesh, Plan& plan)
      : frame_(frame), mesh_(mesh), view_(mesh.mesh().view()), plan_(plan) {}

  void run() {
    const std::int64_t pixels = std::int64_t(frame_.size[0]) * frame_.size[1];
    plan_.need("image of " + std::to_string(frame_.size[0]) + " x " +
                   std::to_string(frame_.size[1]),
               pixels * std::int64_t(4 * sizeof(float)), "while it is drawn");
    image(ImageKind::depth, "image of depth", pixels * std::int64_t(sizeof(float)));
    image(ImageKind::cell, "image of cells", pixels * std::int64_t(sizeof(std::int64_t)));
    geocentric();
    if (frame_.volume)
      volume(*frame_.volume);
    else
      plan_.skip("ray marching", "no volume is asked for");
    if (!frame_.path_tracing)
      plan_.skip("path tracing", "no scattering is asked for");
    for (const Isosurface& surface : frame_.isosurfaces)
      isosurface(surface);
    if (frame_.isosurfaces.empty())
      plan_.skip("value ranges of the tree", "no isosurface is asked for");
    triangles();
    effect(FrameEffect::lighting, "lighting");
    effect(FrameEffect::shadows, "shadows");
    effect(FrameEffect::volume_shadows, "volume shadows");
    effect(FrameEffect::ambient_occlusion, "ambient occlusion");
    if (frame_.clips.empty())
      plan_.skip("clips", "none is asked for");
    else
      plan_.need("clips", -1, std::to_string(frame_.clips.size()) + " of them");
  }

private:
  void effect(FrameEffect which, const char* name) {
    if (std::find(frame_.effects.begin(), frame_.effects.end(), which) != frame_.effects.end())
      plan_.need(name, -1, "an effect of the frame");
    else
      plan_.skip(name, "not among the frame's effects");
  }

  void image(ImageKind kind, const char* name, std::int64_t bytes) {
    if (std::find(frame_.images.begin(), frame_.images.end(), kind) != frame_.images.end())
      plan_.need(name, bytes, "while it is drawn");
    else
      plan_.skip(name, "not among the frame's images");
  }

  void geocentric() {
    if (!frame_.geocentric) {
      if (mesh_.frame.kind != INSITU_FRAME_CARTESIAN)
        plan_.skip("geocentric vertices", "drawn in the mesh's own coordinates");
      return;
    }
    if (mesh_.frame.kind == INSITU_FRAME_CARTESIAN)
      throw core::Error(INSITU_ERROR_SCENE, "geocentric: the mesh has Cartesian coordinates");
    char factor[32];
    std::snprintf(factor, sizeof factor, "%g", frame_.geocentric->exaggeration);
    const std::string what = std::string(", heights times ") + factor;
    plan_.need("geocentric vertices" + what,
               view_.vertex_count() * std::int64_t(sizeof(math::Vec3d)),
               "converted once, kept while the geometry holds");
    plan_.need("tree of geocentric cells" + what, mesh_.locators().info(mesh_.tree()).bytes,
               "about, as the mesh's own; refitted as it moves");
    const std::int64_t rows = std::min(frame_.size[1], 65);
    if (frame_.geocentric->globe || frame_.geocentric->graticule)
      plan_.need("globe", frame_.size[0] * rows * std::int64_t(104), "about, while it is drawn");
    else
      plan_.skip("globe", "neither globe nor graticule is asked for");
  }

  void triangles() {
    if (frame_.boundary) {
      plan_.need("boundary faces", -1, "found once, kept while the geometry holds");
      if (const auto* by = std::get_if<ColorBy>(&frame_.boundary->color))
        range(scalar_name(by->field, by->component, find_field(mesh_, by->field, {}).components),
              by->colors.range);
    } else {
      plan_.skip("boundary faces", "no boundary is asked for");
    }
    for (const Body& body : frame_.bodies)
      plan_.need("triangles of " + quoted(body.path), -1, "a body");
    if (frame_.outline)
      plan_.need("outline", -1, frame_.outline->ticks ? "twelve lines, and ticks" : "twelve lines");
  }

  void range(const std::string& what, const std::optional<ValueRange>& given) {
    if (given)
      plan_.skip("pass over " + what, "the range is given");
    else
      plan_.need("pass over " + what, -1, "the range of the colours is automatic");
  }

  void average(const std::string& what, const std::string& why) {
    plan_.need("vertex average of " + what,
               view_.first_vertex[view_.piece_count] * std::int64_t(sizeof(double)), why);
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
    if (!frame_.path_tracing)
      macrocells(what, v);
    if (mesh_.mesh().has_stand_in() && render::PrimitiveRanges::serve(mesh_.sampler(), {field}))
      culling(what, v);
  }

  /// Of gridlets and stitching cells.
  void culling(const std::string& what, const Volume& v) {
    const std::string item = "tree of what shows of " + what;
    // Of all primitives; the tree at most as large as the mesh's.
    const std::int64_t ranges = query::CulledCells::primitives_of(mesh_.sampler()) *
                                render::PrimitiveRanges::bytes_a_primitive;
    const std::int64_t most = ranges + mesh_.tree().bytes();
    if (v.culling == Culling::never)
      plan_.skip(item, "culling is not asked for");
    else if (v.preintegrated && !frame_.path_tracing)
      plan_.skip(item, "pre-integration needs what does not show too");
    else if (v.culling == Culling::always)
      plan_.need(item, most, "at most; culling");
    else if (frame_.path_tracing)
      plan_.skip(item, "path tracing takes few samples where nothing shows");
    else if (shows_all(v))
      plan_.skip(item, "the opacity is nowhere 0, of NaN neither");
    else
      plan_.need(item, -1,
                 "to cull what does not show, if a look at some cells tells that it pays; then " +
                     std::to_string(ranges) + " to " + std::to_string(most) + " bytes");
  }

  static bool shows_all(const Volume& v) {
    return v.nan_opacity > 0 && !v.opacity.empty() &&
           std::all_of(v.opacity.begin(), v.opacity.end(),
                       [](const OpacityPoint& p) { return p.opacity > 0; });
  }

  void macrocells(const std::string& what, const Volume& v) {
    const std::string item = "macrocells of " + what;
    // A range of two doubles, a mark and a majorant each.
    const std::int64_t bytes = (mesh_.tree().cell_count() / 64 + 1) * 21;
    if (v.tolerance)
      plan_.need(item, bytes, "the volume has a tolerance");
    else if (shows_all(v))
      plan_.skip(item, "the opacity is nowhere 0, of NaN neither");
    else
      plan_.need(item, -1,
                 "to skip what is empty, if a look at some cells tells that it pays; then about " +
                     std::to_string(bytes) + " bytes");
  }

  void path_tracing(const std::string& what, const PathTracing& p) {
    plan_.skip("ray marching", "the volume is path traced");
    plan_.need("path tracing of " + what, -1, std::to_string(p.samples) + " paths a pixel");
    // Range, mark, opacity and extinction of each; what the mesh's shape adds is not counted.
    constexpr double bytes_each = sizeof(render::Macrocells::Range) + 1 + 2 * sizeof(float);
    const double count = std::max(1.0, double(view_.cell_count()) / p.cells_per_macrocell);
    plan_.need("majorants of " + what, std::int64_t(bytes_each * count), "about; path tracing");
    if (p.accumulate)
      plan_.need("sums of samples",
                 std::int64_t(frame_.size[0]) * frame_.size[1] *
                     std::int64_t(sizeof(render::PathSums::Pixel)),
                 "samples accumulate");
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
    if (s.normals == Normals::smooth)
      plan_.need(gradients,
                 view_.first_vertex[view_.piece_count] * std::int64_t(sizeof(math::Vec3d)),
                 "smooth normals");
    else
      plan_.skip(gradients, s.normals == Normals::cell ? "normals are the cells' own gradients"
                                                       : "normals are central differences");
    if (const auto* by = std::get_if<ColorBy>(&s.color)) {
      const mesh::FieldView colors = find_field(mesh_, by->field, {});
      range(scalar_name(by->field, by->component, colors.components), by->colors.range);
    }
  }

  const Frame& frame_;
  const query::CommittedMesh& mesh_;
  const mesh::MeshView& view_;
  Plan& plan_;
};

} // namespace

void plan_frame(const Frame& frame, const query::CommittedMesh& mesh, Plan& plan) {
  FramePlanner(frame, mesh, plan).run();
}

} // namespace insitu::scene
