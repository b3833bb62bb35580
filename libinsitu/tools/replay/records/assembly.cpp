#include "records/assembly.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>

#include "mesh/shape.h"

namespace insitu_replay {

namespace {

std::int64_t load_integer(const insitu_array& array, std::int64_t i) {
  if (array.type == INSITU_INT32)
    return static_cast<const std::int32_t*>(array.data)[i];
  return array.type == INSITU_INT64 ? static_cast<const std::int64_t*>(array.data)[i]
                                    : static_cast<const std::uint8_t*>(array.data)[i];
}

double load_real(const insitu_array& array, std::int64_t i) {
  return array.type == INSITU_FLOAT32 ? double(static_cast<const float*>(array.data)[i])
                                      : static_cast<const double*>(array.data)[i];
}

const insitu_array* find(const PieceArrays& arrays, const char* name) {
  const auto found = arrays.find(name);
  return found == arrays.end() ? nullptr : &found->second;
}

std::int64_t cell_count(const RecordedPiece& piece) {
  if (piece.kind == RecordedPiece::Kind::cells)
    return piece.cells.count;
  if (piece.kind != RecordedPiece::Kind::block)
    return 0;
  std::int64_t count = 1;
  for (const std::int64_t n : piece.block.vertices)
    count *= std::clamp<std::int64_t>(n, 1, std::int64_t(1) << 20) - 1;
  return count;
}

bool is_ghost(const PieceArrays& arrays, std::int64_t cell) {
  const insitu_array* const ghosts = find(arrays, "ghosts");
  return ghosts && cell < ghosts->count && load_integer(*ghosts, cell) != 0; // once hidden
}

/// Writes the ids of a cell, from 0 on, and returns its type; 0 for what the commit would refuse.
int read_cell(const RecordedPiece& piece, const PieceArrays& arrays, std::int64_t cell,
              std::array<std::int64_t, 8>& ids) {
  if (piece.kind == RecordedPiece::Kind::block) {
    const std::int64_t m = piece.block.vertices[0], n = piece.block.vertices[1];
    const std::int64_t i = cell % (m - 1), j = cell / (m - 1) % (n - 1),
                       k = cell / (m - 1) / (n - 1);
    const std::int64_t v = i + m * (j + n * k), up = v + m * n;
    ids = {v, v + 1, v + 1 + m, v + m, up, up + 1, up + 1 + m, up + m};
    return INSITU_HEXAHEDRON;
  }
  const insitu_array* const connectivity = find(arrays, "connectivity");
  const insitu_array* const types = find(arrays, "types");
  const insitu_array* const offsets = find(arrays, "offsets");
  const std::int64_t base = piece.cells.index_base;
  if (!connectivity)
    return 0;
  int type = piece.cells.shape;
  int count = connectivity->components;
  std::int64_t first = cell * count;
  if (piece.cells.layout == INSITU_LAYOUT_MIXED) {
    if (!types || !offsets || cell >= types->count || cell >= offsets->count)
      return 0;
    type = int(load_integer(*types, cell));
    count = insitu::mesh::vertex_count_of(type);
    first = load_integer(*offsets, cell) - base;
  }
  const std::int64_t numbers = connectivity->count * connectivity->components;
  if (count < 3 || count > 8 || first < 0 || first > numbers - count)
    return 0;
  int used = 0;
  for (; used < count; ++used) {
    const std::int64_t id = load_integer(*connectivity, first + used) - base;
    if (id < 0)
      break;
    ids[std::size_t(used)] = id;
  }
  if (piece.cells.layout == INSITU_LAYOUT_PADDED && used < count)
    type = count < 8   ? int(INSITU_TRIANGLE)
           : used == 6 ? int(INSITU_WEDGE)
           : used == 5 ? int(INSITU_PYRAMID)
                       : int(INSITU_TETRAHEDRON);
  return used == insitu::mesh::vertex_count_of(type) ? type : 0;
}

struct Owned {
  std::int64_t id;
  std::int32_t piece;
  std::int64_t cell;
};

/// The cells that are no ghosts, in the pieces' order; none where some lack global ids.
std::vector<Owned> owned_cells(const RecordedMesh& mesh, const std::vector<PieceArrays>& arrays) {
  std::vector<Owned> out;
  for (std::size_t p = 0; p < mesh.pieces.size(); ++p) {
    const RecordedPiece& piece = mesh.pieces[p];
    const std::int64_t cells = cell_count(piece);
    if (cells == 0 && piece.kind != RecordedPiece::Kind::faces)
      continue;
    const insitu_array* const ids = find(arrays[p], "global ids of cells");
    const insitu_array* const vertices = find(arrays[p], "global ids of vertices");
    if (piece.kind == RecordedPiece::Kind::faces || !ids || !vertices || ids->count < cells ||
        (piece.kind == RecordedPiece::Kind::block && piece.block.dimensions != 3))
      return {};
    for (std::int64_t c = 0; c < cells; ++c)
      if (!is_ghost(arrays[p], c))
        out.push_back({load_integer(*ids, c), std::int32_t(p), c});
  }
  return out;
}

} // namespace

void hide_ghosts(RecordedPiece& piece, PieceArrays& arrays) {
  const auto found = arrays.find("ghosts");
  if (found == arrays.end())
    return;
  constexpr std::uint8_t out_of_use = 1 | 8 | 32, hidden = 32;
  // The record's arrays lie in memory that this program took.
  auto* const bits = static_cast<std::uint8_t*>(const_cast<void*>(found->second.data));
  for (std::int64_t c = 0; c < found->second.count; ++c)
    bits[c] = (piece.convention == INSITU_GHOSTS_VTK ? bits[c] & out_of_use : bits[c]) ? hidden : 0;
  piece.convention = INSITU_GHOSTS_VTK;
}

std::optional<Assembly> Assembly::make(const RecordedMesh& mesh,
                                       const std::vector<PieceArrays>& arrays) {
  const auto before = [](const Owned& a, const Owned& b) { return a.id < b.id; };
  std::vector<Owned> owned = owned_cells(mesh, arrays);
  if (owned.empty() || std::is_sorted(owned.begin(), owned.end(), before))
    return std::nullopt;
  std::stable_sort(owned.begin(), owned.end(), before);
  Assembly out;
  std::unordered_map<std::int64_t, std::int64_t> vertices; // by global id
  for (const Owned& cell : owned) {
    const auto p = std::size_t(cell.piece);
    const insitu_array& of_vertices = arrays[p].at("global ids of vertices");
    std::array<std::int64_t, 8> ids;
    const int type = read_cell(mesh.pieces[p], arrays[p], cell.cell, ids);
    if (type == 0)
      return std::nullopt;
    out.offsets_.push_back(std::int64_t(out.connectivity_.size()));
    for (int v = 0; v < insitu::mesh::vertex_count_of(type); ++v) {
      const std::int64_t id = ids[std::size_t(v)];
      if (id >= of_vertices.count)
        return std::nullopt;
      const auto [at, is_new] =
          vertices.emplace(load_integer(of_vertices, id), std::int64_t(vertices.size()));
      if (is_new) { // its values are those of the lowest cell's piece
        out.from_[INSITU_VERTEX].push_back({cell.piece, id});
        out.ids_[INSITU_VERTEX].push_back(at->first);
      }
      out.connectivity_.push_back(at->second);
    }
    out.types_.push_back(std::uint8_t(type));
    out.from_[INSITU_CELL].push_back({cell.piece, cell.cell});
    out.ids_[INSITU_CELL].push_back(cell.id);
  }
  return out;
}

insitu_cells Assembly::cells() const {
  insitu_cells cells = insitu_cells_default();
  cells.layout = INSITU_LAYOUT_MIXED;
  cells.count = std::int64_t(types_.size());
  cells.connectivity =
      insitu_array_of(connectivity_.data(), INSITU_INT64, std::int64_t(connectivity_.size()), 1);
  cells.types = insitu_array_of(types_.data(), INSITU_UINT8, cells.count, 1);
  cells.offsets = insitu_array_of(offsets_.data(), INSITU_INT64, cells.count, 1);
  return cells;
}

insitu_array Assembly::global_ids(insitu_association association) const {
  return insitu_array_of(ids_[association].data(), INSITU_INT64, count(association), 1);
}

std::int64_t Assembly::count(insitu_association association) const {
  return std::int64_t(from_[association].size());
}

void Assembly::gather(insitu_association association, const std::vector<const insitu_array*>& from,
                      std::size_t item_bytes, std::byte* to) const {
  for (const Place& place : from_[association]) {
    const insitu_array* const array = from[std::size_t(place.piece)];
    if (array && place.item < array->count)
      std::memcpy(to,
                  static_cast<const std::byte*>(array->data) + std::size_t(place.item) * item_bytes,
                  item_bytes);
    else
      std::memset(to, 0, item_bytes);
    to += item_bytes;
  }
}

std::vector<double> Assembly::points(const RecordedMesh& mesh,
                                     const std::vector<PieceArrays>& arrays,
                                     const std::vector<const insitu_array*>& points) const {
  constexpr const char* axes[] = {"coordinates 0", "coordinates 1", "coordinates 2"};
  std::vector<double> out;
  for (const Place& place : from_[INSITU_VERTEX]) {
    const auto p = std::size_t(place.piece);
    const insitu_block& block = mesh.pieces[p].block;
    std::int64_t rest = place.item;
    for (int a = 0; a < 3; ++a) {
      if (points[p]) {
        const int components = points[p]->components;
        out.push_back(a < components && place.item < points[p]->count
                          ? load_real(*points[p], place.item * components + a)
                          : 0.0);
        continue;
      }
      const std::int64_t n = std::max<std::int64_t>(block.vertices[a], 1), i = rest % n;
      rest /= n;
      const insitu_array* const axis = find(arrays[p], axes[a]);
      out.push_back(axis && i < axis->count
                        ? load_real(*axis, i)
                        : block.origin[a] + double(block.first[a] + i) * block.spacing[a]);
    }
  }
  return out;
}

} // namespace insitu_replay
