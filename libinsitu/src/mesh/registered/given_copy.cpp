#include "mesh/registered/given_copy.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <variant>

namespace insitu::mesh {

namespace {

constexpr std::int64_t item_grain = 1 << 14; ///< items a task

/// The cells of a patch, as read, within an array that has its layers around them.
insitu_array within_layers(insitu_array array, const insitu_patch& patch) {
  const std::array<std::int64_t, 3> extent = extent_with_ghosts(patch);
  std::int64_t first = 0, stride = std::int64_t(size_of(array.type)) * array.components;
  for (int a = 0; a < 3; ++a) {
    first += patch.ghosts_before[a] * stride;
    array.extent[a] = patch.cells[a];
    array.stride[a] = stride;
    stride *= extent[std::size_t(a)];
  }
  array.count = patch.cells[0] * patch.cells[1] * patch.cells[2];
  array.data = static_cast<const std::byte*>(array.data) + first;
  return array;
}

/// Levels as a caller gives them.
void give_levels(const AmrLevels& levels, Mesh& to) {
  insitu_amr amr = insitu_amr_default();
  for (int a = 0; a < 3; ++a) {
    amr.origin[a] = levels.given_origin()[a];
    amr.spacing[a] = levels.given_spacing()[a];
  }
  std::vector<std::int32_t> ratios;
  for (int l = 1; l < levels.level_count; ++l)
    ratios.push_back(1 << (levels.depth_of[l] - levels.depth_of[l - 1]));
  amr.level_count = levels.level_count;
  amr.ratios = ratios.empty() ? nullptr : ratios.data();
  amr.finest_first = levels.finest_first;
  amr.reconstruction = levels.reconstruction;
  amr.dimensions = levels.dimensions();
  to.set_amr(&amr);
}

/// The arrays of a piece's cells by the names that given_piece() has for them.
using Named = std::map<std::string, insitu_array>;

insitu_array find(const Named& arrays, const char* name) {
  const auto found = arrays.find(name);
  return found == arrays.end() ? insitu_array_default() : found->second;
}

void give_cells(std::monostate, const Named&, std::int32_t, Mesh&) {}

void give_cells(insitu_cells cells, const Named& arrays, std::int32_t p, Mesh& to) {
  cells.connectivity = find(arrays, "connectivity");
  cells.types = find(arrays, "types");
  cells.offsets = find(arrays, "offsets");
  to.set_cells(p, &cells);
}

void give_cells(insitu_faces faces, const Named& arrays, std::int32_t p, Mesh& to) {
  faces.vertices = find(arrays, "vertices");
  faces.offsets = find(arrays, "face offsets");
  faces.owner = find(arrays, "owner");
  faces.neighbour = find(arrays, "neighbour");
  faces.boundary_vertices = find(arrays, "boundary vertices");
  faces.boundary_offsets = find(arrays, "boundary offsets");
  faces.boundary_owner = find(arrays, "boundary owner");
  faces.cell_faces = find(arrays, "cell faces");
  faces.cell_offsets = find(arrays, "cell offsets");
  to.set_faces(p, &faces);
}

void give_cells(insitu_block block, const Named& arrays, std::int32_t p, Mesh& to) {
  block.coordinates[0] = find(arrays, "coordinates 0");
  block.coordinates[1] = find(arrays, "coordinates 1");
  block.coordinates[2] = find(arrays, "coordinates 2");
  to.set_block(p, &block);
}

void give_amr(const AmrPiece& piece, const Named& arrays, std::int32_t p, Mesh& to) {
  if (piece.kind == AmrPiece::Kind::patch) {
    const insitu_patch patch = as_read(piece.patch);
    to.set_patch(p, &patch);
    return;
  }
  insitu_leaves leaves = insitu_leaves_default();
  const bool any = piece.levels.given();
  leaves.levels =
      any ? find(arrays, "levels") : insitu_array_of(nullptr, INSITU_INT32, 0, 1); // no cells
  leaves.corners = any ? find(arrays, "corners") : insitu_array_of(nullptr, INSITU_INT32, 0, 3);
  leaves.corner_bits = piece.corner_bits;
  std::copy_n(piece.offset, 3, leaves.offset);
  to.set_leaves(p, &leaves);
}

} // namespace

std::byte* DenseCopies::room(std::int64_t bytes) {
  core::Buffer<std::byte>& array = arrays_.emplace_back(*memory_, INSITU_MEMORY_HELD);
  array.resize_discard(std::size_t(std::max<std::int64_t>(bytes, 1)));
  return array.data();
}

insitu_array DenseCopies::copy(const std::vector<ExternalArray>& arrays,
                               const core::Threads& threads) {
  const std::int64_t count = arrays[0].layout.count;
  const int components = components_of(arrays);
  const std::int64_t step = std::int64_t(components) * size_of(arrays[0].type);
  std::byte* const to = room(count * step);
  const std::byte* const dense = dense_items(arrays);
  threads.parallel_for(count, item_grain, [&](std::int64_t begin, std::int64_t end) {
    if (dense)
      std::copy(dense + begin * step, dense + end * step, to + begin * step);
    else
      copy_dense(arrays, begin, end, to + begin * step);
  });
  return insitu_array_of(to, arrays[0].type, count, components);
}

std::pair<insitu_array, insitu_array> DenseCopies::copy(RingsBehind rings, insitu_type type,
                                                        std::int64_t base) {
  const std::int64_t ids = rings.id_count(), places = rings.face_count() + 1;
  std::byte* const to = room(ids * size_of(type));
  rings.copy_ids(0, ids, to);
  std::byte* const starts = room(places * 8);
  rings.copy_places(0, places, base, starts);
  return {insitu_array_of(to, type, ids, 1), insitu_array_of(starts, INSITU_INT64, places, 1)};
}

void CellsGiven::copy_piece(const GivenPiece& piece, std::int32_t p, Mesh& to,
                            const core::Threads& threads) {
  Named arrays;
  const ExternalArray* rings = nullptr; // behind pointers, until their numbers of ids come
  std::string rings_name;
  for (const auto& [name, array] : piece.cell_arrays) {
    if (name.ends_with("vertices") && array.indirect) {
      rings = &array;
      rings_name = name;
    } else if (rings && name.ends_with("offsets")) {
      const std::int64_t base = std::get<insitu_faces>(piece.cells).index_base;
      std::tie(arrays[rings_name], arrays[name]) =
          copies_.copy(RingsBehind(*rings, array), rings->type, base);
      rings = nullptr;
    } else {
      arrays[name] = copies_.copy({array}, threads);
    }
  }
  if (to.is_adaptive())
    give_amr(piece.amr, arrays, p, to);
  else
    std::visit([&](const auto& cells) { give_cells(cells, arrays, p, to); }, piece.cells);
  if (!piece.points.empty()) {
    const insitu_array points = copies_.copy(piece.points, threads);
    to.set_points(p, &points, 1);
  }
  if (piece.ghosts.given()) {
    const insitu_array ghosts = copies_.copy({piece.ghosts}, threads);
    to.set_ghosts(p, &ghosts, piece.convention);
  }
  for (const insitu_association of : {INSITU_VERTEX, INSITU_CELL})
    if (piece.global_ids[of].given()) {
      const insitu_array ids = copies_.copy({piece.global_ids[of]}, threads);
      to.set_global_ids(p, of, &ids);
    }
}

void CellsGiven::copy(const Mesh& from, Mesh& to, const core::Threads& threads) {
  const GivenMesh given = from.given();
  if (given.levels)
    give_levels(*given.levels, to);
  to.set_separate_pieces(given.separate_pieces);
  for (std::int32_t p = 0; p < from.given_piece_count(); ++p)
    copy_piece(from.given_piece(p), p, to, threads);
}

ValuesGiven::ValuesGiven(const Mesh& from, core::Memory& memory, const core::Threads& threads)
    : copies_(memory) {
  const GivenMesh given = from.given();
  fields_ = given.fields;
  if (given.levels)
    levels_ = *given.levels;
  for (std::int32_t p = 0; p < from.given_piece_count(); ++p) {
    const GivenPiece piece = from.given_piece(p);
    if (!given.levels)
      hidden_.push_back({p, piece.hidden_points.given()
                                ? copies_.copy({piece.hidden_points}, threads)
                                : insitu_array_default()});
    const bool is_patch = piece.amr.kind == AmrPiece::Kind::patch;
    for (const GivenField& field : piece.fields) {
      insitu_array array = copies_.copy(
          is_patch ? with_read_layers(field.arrays, piece.amr.patch) : field.arrays, threads);
      if (is_patch)
        array = within_layers(array, as_read(piece.amr.patch));
      values_.push_back({p, field.name, field.association, array});
    }
  }
}

void ValuesGiven::give(Mesh& to) const {
  for (const std::string& name : to.field_names())
    to.remove_field(name);
  if (levels_)
    give_levels(*levels_, to);
  for (const HiddenPoints& points : hidden_)
    to.set_hidden_points(points.piece, points.array.count > 0 ? &points.array : nullptr);
  for (const GivenMesh::Field& field : fields_) {
    for (const Values& values : values_)
      if (values.name == field.name)
        to.set_field(values.piece, field.name, values.association, &values.array, 1);
    for (const double blank : field.blanks)
      if (to.has_field(field.name))
        to.add_blank(field.name, blank);
  }
  to.set_changed(INSITU_CHANGED_FIELDS); // where there are none
}

} // namespace insitu::mesh
