#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "accel/tree/value_ranges.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "query/sampler.h"
#include "render/structures/scalar_field.h"
#include "render/structures/vertex_average.h"
#include "render/structures/vertex_gradients.h"
#include "render/surface/triangle_mesh.h"
#include "render/volume/macrocells.h"
#include "render/volume/primitive_ranges.h"
#include "render/volume/whole_grid.h"

namespace insitu::render {

/// What frames of one mesh need beyond its tree: made when the first frame asks for it, shared by
/// all, kept for the next cycle, given back when a cycle has drawn without it. Not thread-safe.
class Structures {
public:
  /// How often each kind was made, for plans and tests: what no frame asks for stays at 0.
  struct Counts {
    std::int64_t vertex_cells = 0;                             ///< made
    std::int64_t averages = 0, averages_refreshed = 0;         ///< made; given new values
    std::int64_t value_ranges = 0, value_ranges_refreshed = 0; ///< made; given new values
    std::int64_t gradients = 0, gradients_refreshed = 0;       ///< made; forgotten for new values
    std::int64_t scalar_ranges = 0;                            ///< passes over the values
    std::int64_t macrocells = 0, macrocells_refreshed = 0;     ///< built; given new values
    std::int64_t majorants = 0; ///< classified, for the first time or anew
    std::int64_t primitive_ranges = 0, primitive_ranges_refreshed = 0; ///< made; given new values
    std::int64_t culled = 0; ///< trees of what shows, made for the first time or anew
    std::int64_t boundaries = 0, bodies = 0;
    Counts& operator+=(const Counts& b) {
      vertex_cells += b.vertex_cells;
      averages += b.averages;
      averages_refreshed += b.averages_refreshed;
      value_ranges += b.value_ranges;
      value_ranges_refreshed += b.value_ranges_refreshed;
      gradients += b.gradients;
      gradients_refreshed += b.gradients_refreshed;
      scalar_ranges += b.scalar_ranges;
      macrocells += b.macrocells;
      macrocells_refreshed += b.macrocells_refreshed;
      majorants += b.majorants;
      primitive_ranges += b.primitive_ranges;
      primitive_ranges_refreshed += b.primitive_ranges_refreshed;
      culled += b.culled;
      boundaries += b.boundaries;
      bodies += b.bodies;
      return *this;
    }
    friend bool operator==(const Counts&, const Counts&) = default;
  };

  /// What was spent on some of them in all, in seconds.
  struct Seconds {
    double vertex_cells = 0;     ///< made
    double averages = 0;         ///< made and refreshed
    double value_ranges = 0;     ///< made and refreshed
    double gradients = 0;        ///< made and forgotten; they are found while frames are drawn
    double macrocells = 0;       ///< built and refreshed
    double majorants = 0;        ///< classified
    double primitive_ranges = 0; ///< made and refreshed
    double culled = 0;           ///< classified, and the tree of what shows
    Seconds& operator+=(const Seconds& b) {
      vertex_cells += b.vertex_cells;
      averages += b.averages;
      value_ranges += b.value_ranges;
      gradients += b.gradients;
      macrocells += b.macrocells;
      majorants += b.majorants;
      primitive_ranges += b.primitive_ranges;
      culled += b.culled;
      return *this;
    }
  };

  explicit Structures(core::Memory& memory) : memory_(&memory) {}

  /// What the mesh is now; fields and geometry grow with each commit that changed them. Forgets
  /// what no longer holds. The threads must outlive the next begin(). copies: finds those of a
  /// chart that has some, while the geometry holds; empty: there are none.
  void begin(const query::Sampler& sampler, std::uint64_t geometry, std::uint64_t fields,
             const core::Threads& threads, std::function<ChartCopies()> copies = {});
  /// Gives back what nobody asked for since begin().
  void end();

  /// A cell field at the vertices. Like all that says nothing else, kept while the geometry holds,
  /// and given new values in place.
  const VertexAverage& average(const ScalarField& cell_field);
  /// Its values, see VertexAverage::values().
  std::span<double> average_values(const ScalarField& cell_field);
  /// Of a vertex field, or of an average's field().
  const accel::ValueRanges& value_ranges(const ScalarField& vertex_field);
  /// Found anew for new values.
  ScalarRange scalar_range(const ScalarField& field);
  /// grid: null: that of Macrocells::grid_of().
  const Macrocells& macrocells(const ScalarField& field, const MacrocellGrid* grid = nullptr);
  /// The same, which know their cells' sizes.
  const Macrocells& macrocells_with_sizes(const ScalarField& field, const MacrocellGrid& grid);
  /// Of macrocells(field, grid); classified anew when the values or the function's opacities
  /// change.
  const Majorants& majorants(const ScalarField& field, const TransferFunction& function,
                             const MacrocellGrid* grid = nullptr);
  /// Of the sampler's own cells, in a mesh that fills the box; kept while geometry and box hold.
  const CellWidths& cell_widths(const mesh::Box& whole);
  /// What a function shows of an adaptive mesh, for which the field's PrimitiveRanges are kept;
  /// made anew when the values or the function's opacities change. Null where there are none to
  /// cull.
  const query::CulledCells* culled(const ScalarField& field, const TransferFunction& function);
  /// Of a vertex field, or of an average's field().
  const VertexGradients& gradients(const ScalarField& vertex_field);
  /// For averages and gradients; kept while the geometry holds.
  const VertexCells& vertex_cells();
  /// The mesh's boundary faces; kept while the geometry holds.
  const TriangleMesh& boundary();
  /// A file's triangles, which say which file; kept while frames draw them.
  const TriangleMesh& body(const TriangleList& list);

  core::Memory& memory() const { return *memory_; }
  const Counts& counts() const { return counts_; }
  const Seconds& seconds() const { return seconds_; }

private:
  /// Field, association, component (range_component()), average.
  using Key = std::tuple<std::string, insitu_association, int, bool>;
  template <class T>
  struct Entry {
    std::unique_ptr<T> value;
    bool used = false;
  };
  /// Kept while the geometry holds, and given new values in place.
  template <class T>
  struct ValuesEntry {
    std::unique_ptr<T> value;
    bool used = false, is_fresh = false;
  };
  /// The same of what a function makes of values.
  template <class T>
  struct FunctionEntry {
    std::unique_ptr<T> value;
    std::vector<OpacityPoint> opacity; ///< of the function
    double nan_opacity = 0;
    Scale scale = Scale::linear;
    bool used = false, is_fresh = false;
    bool is_of(const TransferFunction& function) const {
      return opacity == function.opacity_points() && nan_opacity == function.nan_opacity() &&
             scale == function.scale();
    }
    void set(const TransferFunction& function) {
      opacity = function.opacity_points();
      nan_opacity = function.nan_opacity();
      scale = function.scale();
      is_fresh = true;
    }
  };
  template <class T, class Make, class Refresh>
  static const T& up_to_date(ValuesEntry<T>& entry, std::int64_t& made, std::int64_t& refreshed,
                             double& seconds, Make&& make, Refresh&& refresh);
  template <class Map>
  static typename Map::mapped_type& entry_of(Map& map, const typename Map::key_type& key,
                                             const TransferFunction& function);
  Key key_of(const ScalarField& field) const;
  template <class T>
  static void drop_unused(T& entries);
  const PrimitiveRanges& primitive_ranges(const ScalarField& field);
  const ChartCopies* copies();

  core::Memory* memory_;
  std::unique_ptr<query::Sampler> sampler_;
  const core::Threads* threads_ = nullptr;
  std::function<ChartCopies()> find_copies_;
  std::optional<ChartCopies> copies_; ///< if they were asked for
  std::uint64_t geometry_ = 0, fields_ = 0;
  Counts counts_;
  Seconds seconds_;
  Entry<VertexCells> vertex_cells_;
  std::optional<std::pair<mesh::Box, CellWidths>> cell_widths_;
  std::map<Key, ValuesEntry<VertexAverage>> averages_;
  std::map<Key, ValuesEntry<accel::ValueRanges>> value_ranges_;
  std::map<Key, ValuesEntry<VertexGradients>> gradients_;
  std::map<Key, Entry<ScalarRange>> scalar_ranges_;
  /// With the grid's numbers, if it is given.
  using GridKey = std::pair<Key, std::vector<double>>;
  static GridKey with(const Key& key, const MacrocellGrid* grid);
  std::map<GridKey, ValuesEntry<Macrocells>> macrocells_;
  std::multimap<GridKey, FunctionEntry<Majorants>> majorants_;
  std::map<Key, ValuesEntry<PrimitiveRanges>> primitive_ranges_;
  std::multimap<Key, FunctionEntry<query::CulledCells>> culled_;
  std::map<std::string, Entry<TriangleMesh>> triangles_; ///< by file; the boundary without a name
};

} // namespace insitu::render
