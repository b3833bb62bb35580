#include "render/surface/triangle_surfaces.h"

#include <algorithm>
#include <limits>
#include <string>

#include "core/status.h"

namespace insitu::render {

namespace {

/// Hits of one surface, nearer than this times its extent, are one, of triangles that share an
/// edge.
constexpr double twin_distance = 1e-9;

void check_opacity(double opacity, const char* what) {
  if (!(opacity >= 0 && opacity <= 1))
    throw core::Error(INSITU_ERROR_ARGUMENT, std::string(what) + ": opacity " +
                                                 std::to_string(opacity) + "; 0 to 1 expected");
}

} // namespace

TriangleSurfaces::TriangleSurfaces(const query::Sampler& sampler,
                                   const std::optional<BoundarySettings>& boundary,
                                   const std::vector<BodySettings>& bodies,
                                   std::int32_t first_surface, Structures& structures)
    : sampler_(sampler), first_(first_surface) {
  if (boundary) {
    check_opacity(boundary->opacity, "boundary");
    Surface surface{&structures.boundary(), float(boundary->opacity), Color{}};
    if (const auto* by = std::get_if<ColorByField>(&boundary->color)) {
      const mesh::FieldView& field = by->field.field;
      if (by->field.component >= field.components)
        throw core::Error(INSITU_ERROR_FIELD,
                          std::string("boundary by '") + field.name + "': component " +
                              std::to_string(by->field.component) + " asked for, " +
                              std::to_string(field.components) + " held");
      surface.color = by;
    } else {
      surface.color = std::get<Color>(boundary->color);
    }
    surfaces_.push_back(surface);
  }
  bodies_ = surfaces_.size();
  for (const BodySettings& body : bodies) {
    check_opacity(body.opacity, "body");
    surfaces_.push_back({&structures.body(*body.triangles), float(body.opacity), body.color});
  }
}

void TriangleSurfaces::trace(const Ray& ray, std::vector<SurfaceHit>& hits,
                             const std::vector<Stretch>* stays) const {
  const std::size_t before = hits.size();
  meet(ray, 0, surfaces_.size(), hits, stays);
  if (hits.size() > before)
    settle(hits);
}

void TriangleSurfaces::collect_boundary(const Ray& ray, std::vector<SurfaceHit>& hits,
                                        const std::vector<Stretch>* stays) const {
  meet(ray, 0, bodies_, hits, stays);
}

void TriangleSurfaces::add(const Ray& ray, std::span<const SurfaceHit> boundary,
                           std::vector<SurfaceHit>& hits, const std::vector<Stretch>* stays) const {
  const std::size_t before = hits.size();
  meet(ray, bodies_, surfaces_.size(), hits, stays);
  hits.insert(hits.end(), boundary.begin(), boundary.end());
  if (hits.size() > before)
    settle(hits);
}

/// Adds hits with surfaces [first, last) up to the last of `hits`, if that is opaque.
void TriangleSurfaces::meet(const Ray& ray, std::size_t first, std::size_t last,
                            std::vector<SurfaceHit>& hits,
                            const std::vector<Stretch>* stays) const {
  if (stays && stays->empty())
    return;
  const double t_min = stays ? stays->front().from : 0.0;
  double t_max = stays ? stays->back().to : std::numeric_limits<double>::infinity();
  if (!hits.empty() && hits.back().opacity >= 1)
    t_max = std::min(t_max, hits.back().t);
  for (std::size_t s = first; s < last; ++s) {
    const Surface& surface = surfaces_[s];
    const TriangleMesh& mesh = *surface.mesh;
    mesh.rays().meet(ray.origin, ray.direction, t_min, t_max, [&](const accel::TriangleHit& met) {
      if (stays && !stays_at(*stays, met.t))
        return false; // cut away: the ray goes on
      SurfaceHit hit;
      hit.t = met.t;
      hit.cell = mesh.cell(met.triangle);
      hit.surface = first_ + std::int32_t(s);
      hit.triangle = std::int64_t(met.triangle);
      hit.opacity = surface.opacity;
      hit.extent = mesh.rays().extent();
      hit.parametric = {met.u, met.v, 0};
      hit.gradient = mesh.normal(met.triangle);
      hits.push_back(hit);
      return surface.opacity >= 1;
    });
  }
}

/// Puts hits in order, makes twins one, and leaves out what lies behind the first opaque one.
void TriangleSurfaces::settle(std::vector<SurfaceHit>& hits) {
  std::sort(hits.begin(), hits.end(), [](const SurfaceHit& a, const SurfaceHit& b) {
    if (a.t != b.t)
      return a.t < b.t;
    if (a.surface != b.surface)
      return a.surface < b.surface;
    return a.cell != b.cell ? a.cell < b.cell : a.triangle < b.triangle;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const SurfaceHit hit = hits[i];
    bool twin = false;
    for (std::size_t k = kept; k-- > 0 && !twin && hit.triangle >= 0;) {
      if (hit.t - hits[k].t > twin_distance * hit.extent)
        break;
      twin = hits[k].surface == hit.surface;
    }
    if (twin)
      continue;
    hits[kept++] = hit;
    if (hit.opacity >= 1)
      break; // nothing shows behind
  }
  hits.resize(kept);
}

double TriangleSurfaces::value(const ScalarField& field, const TriangleMesh& mesh,
                               const SurfaceHit& hit) const {
  const mesh::MeshView& view = sampler_.mesh();
  const std::int32_t piece = view.piece_of(hit.cell);
  if (field.field.association == INSITU_CELL)
    return field.load(piece, hit.cell - view.first_cell[piece]);
  std::uint32_t ids[3];
  mesh.vertices(std::uint32_t(hit.triangle), ids);
  const double weights[3] = {1 - hit.parametric.x - hit.parametric.y, hit.parametric.x,
                             hit.parametric.y};
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += weights[k] * field.load(piece, std::int64_t(ids[k]) - view.first_vertex[piece]);
  return sum;
}

Color TriangleSurfaces::color(const SurfaceHit& hit) const {
  const Surface& surface = surfaces_[std::size_t(hit.surface - first_)];
  if (const Color* constant = std::get_if<Color>(&surface.color))
    return *constant;
  const ColorByField& by = *std::get<const ColorByField*>(surface.color);
  return by.function.color(value(by.field, *surface.mesh, hit));
}

} // namespace insitu::render
