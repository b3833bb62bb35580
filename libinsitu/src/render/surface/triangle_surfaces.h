#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "query/sampler.h"
#include "render/clip.h"
#include "render/structures/structures.h"
#include "render/surface/isosurface.h"
#include "render/surface/surface_hit.h"
#include "render/surface/triangle_mesh.h"

namespace insitu::render {

/// The mesh's own boundary; see TriangleMesh::boundary.
struct BoundarySettings {
  double opacity = 1;
  /// A vertex field is interpolated over the triangles, a cell field is that of the face's cell.
  std::variant<Color, ColorByField> color = Color{0.6f, 0.6f, 0.6f};
};

/// Triangles that do not come from the mesh.
struct BodySettings {
  std::shared_ptr<const TriangleList> triangles;
  double opacity = 1;
  Color color{0.6f, 0.6f, 0.6f};
};

/// Intersects rays with the boundary and with bodies.
class TriangleSurfaces {
public:
  /// Asks structures for the meshes. first_surface: SurfaceHit::surface of the boundary, or of the
  /// first body without one. Settings and structures must outlive it. Throws core::Error.
  TriangleSurfaces(const query::Sampler& sampler, const std::optional<BoundarySettings>& boundary,
                   const std::vector<BodySettings>& bodies, std::int32_t first_surface,
                   Structures& structures);

  /// Adds to `hits`, which are in order and end with the first opaque one, those of triangles, and
  /// leaves them so. stays: as in IsosurfaceTracer::trace.
  void trace(const Ray& ray, std::vector<SurfaceHit>& hits,
             const std::vector<Stretch>* stays) const;
  /// The parts of it where the mesh is spread over processes: adds hits with the boundary of this
  /// process's cells as they are; and puts hits with bodies and boundary hits of all processes
  /// among `hits`.
  void collect_boundary(const Ray& ray, std::vector<SurfaceHit>& hits,
                        const std::vector<Stretch>* stays) const;
  void add(const Ray& ray, std::span<const SurfaceHit> boundary, std::vector<SurfaceHit>& hits,
           const std::vector<Stretch>* stays) const;
  /// The surface's own colour at a hit of these.
  Color color(const SurfaceHit& hit) const;

private:
  struct Surface {
    const TriangleMesh* mesh;
    float opacity;
    std::variant<Color, const ColorByField*> color;
  };
  void meet(const Ray& ray, std::size_t first, std::size_t last, std::vector<SurfaceHit>& hits,
            const std::vector<Stretch>* stays) const;
  static void settle(std::vector<SurfaceHit>& hits);
  double value(const ScalarField& field, const TriangleMesh& mesh, const SurfaceHit& hit) const;

  query::Sampler sampler_;
  std::int32_t first_;
  std::size_t bodies_ = 0; ///< the first of them among the surfaces
  std::vector<Surface> surfaces_;
};

} // namespace insitu::render
