#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "query/sampler.h"
#include "render/cell_roots.h"
#include "render/clip.h"
#include "render/scalar_field.h"
#include "render/structures.h"
#include "render/surface_hit.h"
#include "render/transfer_function.h"

namespace insitu::render {

/// Colours of a surface by a field, of vertices or cells; the function's opacity is not used.
struct ColorByField {
  ScalarField field;
  TransferFunction function;
};

/// Surfaces on which a field takes these values. A cell field is averaged to the vertices first
/// (VertexAverage).
struct IsosurfaceSettings {
  ScalarField field;
  std::vector<double> values;
  double opacity = 1;
  std::variant<Color, ColorByField> color = Color{0.6f, 0.6f, 0.6f}; ///< linear
};

/// Intersects rays with all surfaces of a frame in one traversal, pruned by the fields' value
/// ranges.
class IsosurfaceTracer {
public:
  /// Asks structures for averages of cell fields and value ranges. The settings and the structures
  /// must outlive it.
  IsosurfaceTracer(const query::Sampler& sampler, const std::vector<IsosurfaceSettings>& settings,
                   Structures& structures);

  /// Of all settings together; see SurfaceHit::surface.
  std::int32_t surface_count() const { return std::int32_t(surfaces_.size()); }

  /// The ray's hits in depth order, up to and including the first opaque one, without colours. Of
  /// hits of one surface at one place (of cells that overlap, or on an edge) the lowest cell id
  /// counts. stays: where hits may be; null: anywhere ahead of the origin.
  void trace(const Ray& ray, std::vector<SurfaceHit>& hits, SurfaceCounts& counts,
             const std::vector<Stretch>* stays = nullptr) const;
  /// The surface's own colour at a hit.
  Color color(const SurfaceHit& hit) const;

private:
  struct Level {
    double value = 0;
    float low = 0, high = 0; ///< the value in floats, outwards
    std::int32_t surface = 0;
    const IsosurfaceSettings* settings = nullptr;
  };
  /// All levels of one scalar field.
  struct Group {
    ScalarField source, field; ///< as asked for, and at the vertices
    const accel::ValueRanges* ranges = nullptr;
    std::vector<Level> levels;
    bool needs(std::uint32_t node, int child) const;
  };
  /// What a trace goes on with from cell to cell.
  struct Search {
    RaySpace space;
    const std::vector<Stretch>* stays;
    double t_min, t_max;
    std::vector<SurfaceHit>& hits;
    SurfaceCounts& counts;
  };
  void test_cell(std::int64_t flat, Search& search) const;

  query::Sampler sampler_;
  std::vector<Group> groups_;
  std::vector<const IsosurfaceSettings*> surfaces_; ///< by SurfaceHit::surface
};

} // namespace insitu::render
