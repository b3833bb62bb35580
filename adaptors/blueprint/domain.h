#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.h"
#include "nestsets.h"
#include "node.h"

namespace insitu::blueprint {

struct Field {
  std::string name;
  insitu_association on = INSITU_VERTEX;
  std::vector<insitu_array> arrays;
};

/// What polygons become that are cut into triangles about the means of their vertices.
struct Cuts {
  std::vector<std::int64_t> cell; ///< the tree's, of each cell
  /// The polygon of each vertex that was made, behind those of the tree.
  std::vector<std::int64_t> ring_offsets{0}, ring_ids;
  std::int64_t made() const { return static_cast<std::int64_t>(ring_offsets.size()) - 1; }
  /// An array of the tree's cells or vertices as one of the cells and vertices that there are; made
  /// vertices have the means of their polygons.
  insitu_array expanded(const insitu_array& array, bool on_cells, Copies& copies) const;
};

/// A domain of a Blueprint mesh as a piece of a mesh: views of the solver's arrays, checked as far
/// as the tree goes; the library checks the rest.
struct Domain {
  enum class Kind { none, block, cells, faces, patch };
  std::string path;
  Kind kind = Kind::none;
  int dimensions = 3;                   ///< or 2: a flat mesh
  std::array<std::int64_t, 3> extent{}; ///< of blocks and patches, in vertices
  std::array<double, 3> origin{}, spacing{};
  insitu_block block = insitu_block_default();
  insitu_cells cells = insitu_cells_default();
  insitu_faces faces = insitu_faces_default();
  std::int64_t vertex_count = 0, cell_count = 0; ///< of the tree
  std::vector<insitu_array> points; ///< empty: the block's own
  std::vector<Field> fields;
  std::optional<insitu_array> ghosts, hidden_points;
  insitu_ghost_convention convention = INSITU_GHOSTS_VTK;
  std::optional<insitu_array> global_ids[2]; ///< by insitu_association
  std::optional<std::int64_t> id;            ///< state/domain_id
  std::string topology;                      ///< its name
  std::int64_t level = -1;                   ///< of a patch
  std::vector<NestWindow> windows;           ///< of a patch
  std::uint64_t topology_print = 0, geometry_print = 0;
  std::vector<std::string> left_out; ///< what of the tree is not given, and why
  /// Of cells and what tells of them; equal ones of a step before are kept (keep_cells()).
  std::shared_ptr<Copies> cell_copies = std::make_shared<Copies>();
  std::shared_ptr<Copies> point_copies = std::make_shared<Copies>();
  Copies copies;              ///< of values, and of axes
  bool are_polygons = false;  ///< of any number of vertices, which may be cut
  std::shared_ptr<Cuts> cuts; ///< null: cells and vertices are the tree's
};

/// Reads a domain. topology: its name; empty: the first one of cells of volume, or else the first
/// one of a flat mesh. channel: where
/// metadata of fields may stand too, or null. Throws Error, by the path.
Domain read_domain(const Node& mesh, const std::string& topology, const Node& channel);

/// The names of a mesh's topologies beside the one that is read of it, whose cells have as many
/// dimensions, and on which a field says that it is.
std::vector<std::string> other_topologies(const Node& mesh);

/// Parts of read_domain().
void read_cells(const Node& topology, Domain& domain);
void read_fields(const Node& mesh, const Node& topology, const Node& channel, Domain& domain);

/// Parts of read_cells(): polygons of any number of vertices, alone or among others, and polyhedra
/// among cells of other shapes.
void read_polygons(const Node& topology, Domain& domain);
void read_polyhedra_among_others(const Node& topology, Domain& domain);
/// Hides cells of lower dimension than others, of which there are so many by their shapes' names.
void hide_lower(const Node& elements, const std::map<std::string, std::int64_t>& lower,
                const std::uint8_t* types, Domain& domain);

/// The number of dimensions of cells of a shape of Blueprint's; -1: unknown.
int dimensions_of(const std::string& shape);

/// The numbers at dims/offsets and dims/strides, or of a field; without them those of packed items.
struct Window {
  std::array<std::int64_t, 3> offset{}, stride{};
  bool given = false;
};
/// items: of the array within which the window lies; refuses a window that reaches outside.
Window read_window(const Node& dims, const std::array<std::int64_t, 3>& extent, std::int64_t items);

} // namespace insitu::blueprint
