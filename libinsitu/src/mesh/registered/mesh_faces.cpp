/// Cells that are given by their faces: the arrays, and that each has the items that it should.
/// Whether the faces bound cells is found when these are cut (commit/standins/polyhedral.h).
#include <algorithm>
#include <string>

#include "core/caller_struct.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

using core::Error;

namespace {

constexpr std::int64_t most_faces = std::int64_t(1) << 40;

/// Checks the arrays of one insitu_faces.
class FacesReader {
public:
  FacesReader(const insitu_faces& given, std::string name)
      : given_(given), name_(std::move(name)) {}

  FacesView read() {
    if (given_.form != INSITU_FACES_OWNERS && given_.form != INSITU_FACES_CELLS)
      refuse("unknown form " + std::to_string(int(given_.form)));
    if (given_.index_base != 0 && given_.index_base != 1)
      refuse("index_base " + std::to_string(given_.index_base) + ", 0 or 1 expected");
    view_.by_cells = given_.form == INSITU_FACES_CELLS;
    view_.index_base = given_.index_base;
    view_.cell_count = count(given_.cell_count, "cell_count");
    view_.faces = rings(given_.face_count, "face_count", given_.vertices, "vertices",
                        given_.offsets, "face offsets");
    if (view_.by_cells)
      read_cells();
    else
      read_owners();
    return view_;
  }
  std::vector<std::pair<ExternalArray, const char*>> arrays; ///< those that were read

private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(INSITU_ERROR_ARGUMENT, name_ + ": " + what);
  }

  std::int64_t count(std::int64_t given, const char* what) const {
    if (given < 0 || given > most_faces)
      refuse(std::string(what) + " " + std::to_string(given));
    return given;
  }

  const ExternalArray& array(const insitu_array& given, const char* what, int most_components,
                             Pointers pointers = Pointers::refused) {
    ExternalArray adopted = adopt(&given, name_ + ", " + what, pointers);
    require_integer(adopted, name_ + ", " + what);
    if (!adopted.layout.linear && !adopted.indirect)
      refuse(std::string(what) + ": items must be evenly spaced");
    if (adopted.components > most_components)
      refuse(std::string(what) + ": " + std::to_string(adopted.components) + " components, " +
             (most_components == 1 ? "1" : "1 or 2") + " expected");
    return arrays.emplace_back(std::move(adopted), what).first;
  }

  static IndexView index_view(const ExternalArray& a, int component = 0) {
    return {a.data ? a.data + component * a.component_stride : nullptr, a.layout.count,
            a.layout.stride[0], a.type == INSITU_INT32};
  }

  IndexView ids(const insitu_array& given, const char* what) {
    return index_view(array(given, what, 1));
  }

  /// Ids with so many items: `expected`, of what.
  IndexView ids(const insitu_array& given, const char* what, std::int64_t expected,
                const std::string& of) {
    const IndexView view = ids(given, what);
    if (view.count != expected)
      refuse(std::string(what) + ": " + std::to_string(view.count) + " items, " +
             std::to_string(expected) + " expected of " + of);
    return view;
  }

  /// Where so many items start, and, or not, where the last one ends.
  IndexView places(const insitu_array& given, const char* what, std::int64_t items,
                   const std::string& of) {
    return ids(given, what, given.count == items ? items : items + 1, of);
  }

  RingsView rings(std::int64_t given, const char* count_name, const insitu_array& vertices,
                  const char* vertices_name, const insitu_array& offsets,
                  const char* offsets_name) {
    RingsView out;
    out.count = count(given, count_name);
    if (out.count == 0)
      return out;
    const ExternalArray& given_ids = array(vertices, vertices_name, 1, Pointers::followed);
    out.ids = index_view(given_ids);
    out.behind = given_ids.indirect;
    out.bytes_behind = given_ids.offset;
    const std::string faces = std::to_string(out.count) + " faces";
    if (out.behind && out.ids.count != out.count)
      refuse(std::string(vertices_name) + ": " + std::to_string(out.ids.count) + " pointers, " +
             std::to_string(out.count) + " expected of " + faces);
    out.offsets = out.behind ? ids(offsets, offsets_name, out.count, faces)
                             : places(offsets, offsets_name, out.count, faces);
    return out;
  }

  void read_owners() {
    view_.far_cells = count(given_.far_cells, "far_cells");
    if (view_.faces.count > 0)
      read_inner_owners();
    if (given_.boundary_count == 0)
      return;
    view_.boundary = rings(given_.boundary_count, "boundary_count", given_.boundary_vertices,
                           "boundary vertices", given_.boundary_offsets, "boundary offsets");
    view_.boundary_owner = ids(given_.boundary_owner, "boundary owner", view_.boundary.count,
                               std::to_string(view_.boundary.count) + " faces");
  }

  void read_inner_owners() {
    const std::string faces = std::to_string(view_.faces.count) + " faces";
    const ExternalArray& owner = array(given_.owner, "owner", 2);
    if (owner.layout.count != view_.faces.count)
      refuse("owner: " + std::to_string(owner.layout.count) + " items, " +
             std::to_string(view_.faces.count) + " expected of " + faces);
    view_.owner = index_view(owner);
    const bool pairs = owner.components == 2;
    if (pairs)
      view_.neighbour = index_view(owner, 1);
    if (pairs && given_.neighbour.count != 0)
      refuse("neighbour has " + std::to_string(given_.neighbour.count) +
             " items, but owner has two components, which are both cells");
    if (!pairs && (given_.neighbour.data || given_.neighbour.count != 0)) {
      view_.neighbour = ids(given_.neighbour, "neighbour");
      if (view_.neighbour.count > view_.faces.count)
        refuse("neighbour: " + std::to_string(view_.neighbour.count) + " items for " + faces);
    }
  }

  void read_cells() {
    if (view_.cell_count == 0)
      return;
    view_.cell_faces = ids(given_.cell_faces, "cell faces");
    view_.cell_offsets = places(given_.cell_offsets, "cell offsets", view_.cell_count,
                                std::to_string(view_.cell_count) + " cells");
  }

  const insitu_faces& given_;
  std::string name_;
  FacesView view_;
};

} // namespace

void Mesh::set_faces(std::int32_t piece, const insitu_faces* given) {
  const std::string name = "mesh '" + name_ + "', piece " + std::to_string(piece) + " faces";
  refuse_if_adaptive(name);
  const insitu_faces copy = core::from_caller(given, name);
  FacesReader reader(copy, name);
  const FacesView faces = reader.read();
  PieceView v;
  v.layout = CellLayout::uniform;
  v.cell_count = faces.cell_count;
  v.index_base = faces.index_base;
  Piece& p = piece_for(piece);
  p.set_cells_view(v);
  p.given = copy;
  p.face_arrays = std::move(reader.arrays);
  p.faces = faces;
  pending_ |= INSITU_CHANGED_ALL;
}

void Mesh::count_rings(std::size_t piece) {
  Piece& p = pieces_[piece];
  if (!p.faces || p.view.cell_count == 0)
    return;
  auto array = p.face_arrays.begin();
  for (const RingsView* const rings : {&p.faces->faces, &p.faces->boundary}) {
    if (!rings->behind)
      continue;
    std::int64_t values = 0;
    for (std::int64_t f = 0; f < rings->count; ++f) {
      const IndexView ring = rings->ring_behind(f);
      if (!ring.data)
        throw Error(INSITU_ERROR_MESH, "mesh '" + name_ + "', piece " + std::to_string(piece) +
                                           ": the pointer of " +
                                           (rings == &p.faces->faces ? "face " : "boundary face ") +
                                           std::to_string(f) + " is null");
      values += std::max<std::int64_t>(ring.count, 0);
    }
    array =
        std::find_if(array, p.face_arrays.end(), [](const auto& a) { return a.first.indirect; });
    (array++)->first.indirect_values = values;
  }
}

bool Mesh::has_faces() const {
  return std::ranges::any_of(pieces_, [](const Piece& p) { return p.faces && p.view.cell_count; });
}

const FacesView* Mesh::faces(std::int32_t piece) const {
  const Piece& p = pieces_[std::size_t(piece)];
  return p.faces && p.view.cell_count > 0 ? &*p.faces : nullptr;
}

void Mesh::set_parts(std::int32_t piece, const PartsView* parts) {
  pieces_[std::size_t(piece)].view.parts = parts;
  if (std::size_t(piece) < piece_views_.size())
    piece_views_[std::size_t(piece)].parts = parts;
}

} // namespace insitu::mesh
