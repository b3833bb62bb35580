#pragma once

#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "accel/camera_rays/gridlet_rays.h"
#include "query/sampler.h"
#include "render/clip.h"
#include "render/color/transfer_function.h"
#include "render/structures/place_value.h"
#include "render/structures/scalar_field.h"
#include "render/structures/structures.h"
#include "render/surface/cell_roots.h"
#include "render/surface/normals.h"
#include "render/surface/surface_hit.h"
#include "render/surface/tiles/trilinear_cell.h"

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
  Normals normals = Normals::cell;
  RootSearch search = RootSearch::exact;
};

/// Where rays of light start: on a surface, of a cell that a hit tells, above it by `clearance`
/// along the normal.
struct SecondaryStart {
  std::int64_t cell = -1;
  std::int32_t surface = -1;
  math::Vec3d normal;
  double clearance = 0;
};

/// A ray of which nothing but what light comes through is asked.
struct LightRay {
  Ray ray;
  const std::vector<Stretch>* stays = nullptr; ///< where hits count; not null
  const SecondaryStart* start = nullptr;       ///< or null
  double open = 1;                             ///< the part of light that surfaces let through
};

/// Intersects rays with all surfaces of a frame in one traversal, pruned by the fields' value
/// ranges.
class IsosurfaceTracer {
public:
  /// Asks structures for averages of cell fields, value ranges, and, if hits will be lit, gradients
  /// of smooth surfaces. The settings and the structures must outlive it.
  IsosurfaceTracer(const query::Sampler& sampler, const std::vector<IsosurfaceSettings>& settings,
                   Structures& structures, bool lit = true);

  /// Of all settings together; see SurfaceHit::surface.
  std::int32_t surface_count() const { return std::int32_t(surfaces_.size()); }

  /// The ray's hits in depth order, up to and including the first opaque one, without colours. Of
  /// hits of one surface at one place (of cells that overlap, or on an edge) the lowest cell id
  /// counts. stays: where hits may be; null: anywhere ahead of the origin.
  void trace(const Ray& ray, std::vector<SurfaceHit>& hits, SurfaceCounts& counts,
             const std::vector<Stretch>* stays = nullptr) const;
  /// Sets `open` of each ray. Rays that start near to each other should be beside each other: they
  /// pass the tree in packets.
  void trace(std::span<LightRay> rays, SurfaceCounts& counts) const;
  /// A part of it, of at most RayLanes::most rays: sets their hits as cells have them, in no order,
  /// twins among them; of a ray that meets an opaque one, that and maybe others.
  void collect(std::span<const LightRay> rays, std::vector<SurfaceHit>* hits,
               SurfaceCounts& counts) const;
  /// The surface's own colour at a hit.
  Color color(const SurfaceHit& hit) const;
  /// The field's gradient at a hit, which lies at p, as the surface's normals are chosen.
  math::Vec3d gradient(const SurfaceHit& hit, const math::Vec3d& p, SurfaceCounts& counts) const;

  /// Of central differences, whose places may be in other processes' cells: whether a surface's
  /// normals are these; half their length about a hit; the places about a point p, two along each
  /// axis; the field at one of them, `cell` below 0 where no cell holds it, hint as for
  /// Sampler::locate(); the gradient by the values at all places.
  static constexpr int places_about = 6;
  bool is_central(std::int32_t surface) const;
  double half_length(const SurfaceHit& hit) const;
  static math::Vec3d place_about(const math::Vec3d& p, double half, int number);
  PlaceValue value_at(std::int32_t surface, const math::Vec3d& place, std::int64_t hint) const;
  math::Vec3d central_gradient(std::int32_t surface, double half,
                               std::span<const PlaceValue, places_about> values) const;

  /// Puts all hits of a ray into depth order, makes twins one, and leaves out what lies behind the
  /// first opaque one. A hit whose gradient is not a number gets the cell's own, if hits are lit;
  /// `last` keeps the cell for the next ray.
  struct LastCell {
    std::int32_t surface = -1; ///< none
    std::int64_t flat = -1;
    TrilinearCell cell;
  };
  void settle(std::vector<SurfaceHit>& hits, LastCell& last) const;
  /// The parts of these: the hits of a ray as cells have them, in no order, twins among them, some
  /// behind opaque ones; their order; their gradients.
  void collect(const Ray& ray, std::vector<SurfaceHit>& hits, SurfaceCounts& counts,
               const std::vector<Stretch>* stays) const;
  static void put_in_order(std::vector<SurfaceHit>& hits);
  void complete(std::span<SurfaceHit> hits, LastCell& last) const;
  /// Whether all surfaces are searched by RootSearch::exact, as tiles do.
  bool is_exact() const { return is_exact_; }

  struct Level {
    double value = 0;
    float low = 0, high = 0; ///< the value in floats, outwards
    std::int32_t surface = 0;
    const IsosurfaceSettings* settings = nullptr;
  };
  /// All levels of one scalar field.
  struct Group {
    ScalarField source, field; ///< as asked for, and at the vertices
    bool has_blank_cells = false;
    const accel::ValueRanges* ranges = nullptr;
    const VertexGradients* gradients = nullptr; ///< if a surface asks for them
    const VertexCells* around = nullptr;        ///< for these
    std::vector<Level> levels;
    /// Bit c: a level may be in child c's values.
    unsigned needed(std::uint32_t node) const;
    /// The values at a cell's vertices; false if the cell has no surface because it is blank or one
    /// is not a number.
    bool load(std::int32_t piece, std::int64_t cell, const std::int64_t* ids, int n,
              double* values) const;
  };
  /// What a trace goes on with from cell to cell.
  struct Search {
    cells::RaySpace space;
    const std::vector<Stretch>* stays;
    double t_min, t_max;
    std::vector<SurfaceHit>& hits;
    SurfaceCounts& counts;
    bool any = false; ///< an opaque hit ends it, wherever it is: t_max becomes -1
  };
  /// A root in a cell as a hit. extent: of the ray in the cell.
  static SurfaceHit hit_of(const LevelHit& root, double extent, std::int64_t flat,
                           const Level& level);
  /// Adds a hit to a search's unless it is cut away or hidden; whether the ray goes on.
  static bool keep(const SurfaceHit& hit, Search& search);
  /// Searches one cell for one level by the ray alone (CellRoots, exact): found(hit) for each hit
  /// from t_min on, in order, until it returns false.
  void search_by_ray(std::int64_t flat, const Group& group, const Level& level,
                     const cells::RaySpace& space, double t_min, double t_max,
                     const core::FunctionRef<bool(const SurfaceHit&)>& found,
                     SurfaceCounts& counts) const;
  const std::vector<Group>& groups() const { return groups_; }
  /// Bit c: a level of any group may be in child c's values.
  unsigned needed(std::uint32_t node) const;
  const query::Sampler& sampler() const { return sampler_; }
  /// Of all tracers of the process no other has this number; never 0.
  std::uint64_t number() const { return number_; }

private:
  void test_cell(std::int64_t flat, Search& search) const;
  void collect_packet(std::span<const LightRay> rays, std::vector<SurfaceHit>* hits,
                      SurfaceCounts& counts) const;
  Search search_of(const Ray& ray, const std::vector<Stretch>* stays, std::vector<SurfaceHit>& hits,
                   SurfaceCounts& counts) const;
  /// visit(flat cell) for the cells of a tree's item that a ray may meet.
  template <class Visit>
  void for_each_cell(std::int64_t item, const Search& search, Visit&& visit) const;

  query::Sampler sampler_;
  std::uint64_t number_;
  bool lit_, is_exact_ = false;
  std::vector<Group> groups_;
  struct Surface {
    const IsosurfaceSettings* settings;
    std::size_t group;
    double value;
  };
  std::vector<Surface> surfaces_; ///< by SurfaceHit::surface
};

template <class Visit>
void IsosurfaceTracer::for_each_cell(std::int64_t item, const Search& search, Visit&& visit) const {
  const mesh::MeshView& mesh = sampler_.mesh();
  const mesh::PieceView& piece = mesh.pieces[mesh.piece_of(item)];
  if (piece.is_halo)
    return; // its process finds its hits
  const std::int64_t first = mesh.first_cell[&piece - mesh.pieces];
  if (!piece.gridlets) {
    if (piece.is_own(item - first))
      visit(item);
    return;
  }
  const Ray& ray = search.space.ray();
  accel::for_each_cell_along_ray(*piece.gridlets, (item - first) >> mesh::Gridlet::cell_bits,
                                 ray.origin, ray.direction, search.t_min, search.t_max,
                                 [&](int local) {
                                   if (piece.is_own(item - first + local))
                                     visit(item + local);
                                 });
}

} // namespace insitu::render
