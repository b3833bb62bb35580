#include "scene/record/vtk_shown.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "mesh/registered/dense_items.h"
#include "scene/record/record_text.h"

namespace insitu::scene {

namespace {

using mesh::ExternalArray;

constexpr std::int64_t no_matter = std::numeric_limits<std::int64_t>::max();

std::int64_t load_id(const ExternalArray& ids, std::int64_t item, int component = 0) {
  return mesh::load_index(ids.at(item, component), ids.type == INSITU_INT32);
}

std::int64_t real_bits(double number) {
  std::int64_t bits = 0;
  std::memcpy(&bits, &number, sizeof bits);
  return bits;
}

} // namespace

/// A piece as a part of an UnstructuredGrid, or a block.
struct VtkShown::Piece {
  insitu_cells cells = insitu_cells_default();
  insitu_block block = insitu_block_default(); ///< of ImageData
  ExternalArray connectivity, types, offsets, ghosts;
  std::vector<ExternalArray> points;
  insitu_ghost_convention convention = INSITU_GHOSTS_VTK;
  std::int64_t vertices = 0, ids = 0; ///< ids: of all cells

  /// Returns the type of a cell, and its ids, counted from 0; 0 if they are none.
  int cell(std::int64_t c, std::array<std::int64_t, 8>& to) const {
    std::int64_t first = 0;
    int type = cells.shape, count = connectivity.components;
    if (cells.layout == INSITU_LAYOUT_MIXED) {
      type = int(std::to_integer<std::uint8_t>(*types.at(c, 0)));
      count = mesh::vertex_count_of(type);
      first = mesh::from_base(load_id(offsets, c), cells.index_base);
      if (first < 0 || first > connectivity.layout.count - count)
        return 0;
    } else if (cells.layout == INSITU_LAYOUT_PADDED) {
      int used = 0;
      while (used < count && mesh::from_base(load_id(connectivity, c, used), cells.index_base) >= 0)
        ++used;
      const bool is_flat = count < 8;
      type = used == count ? type
             : is_flat     ? (used == 3 ? int(INSITU_TRIANGLE) : 0)
             : used == 6   ? int(INSITU_WEDGE)
             : used == 5   ? int(INSITU_PYRAMID)
             : used == 4   ? int(INSITU_TETRAHEDRON)
                           : 0;
      count = used;
    }
    if (count == 0 || count != mesh::vertex_count_of(type))
      return 0;
    for (int i = 0; i < count; ++i) {
      const std::int64_t id = cells.layout == INSITU_LAYOUT_MIXED ? load_id(connectivity, first + i)
                                                                  : load_id(connectivity, c, i);
      to[std::size_t(i)] = mesh::from_base(id, cells.index_base);
      if (to[std::size_t(i)] < 0 || to[std::size_t(i)] >= vertices)
        return 0;
    }
    return type;
  }

  /// Counts the ids; whether connectivity has them all in the cells' order, from 0 on.
  bool count_ids() {
    bool in_order = cells.index_base == 0 && !ghosts.given();
    if (cells.layout == INSITU_LAYOUT_UNIFORM && in_order) {
      ids = cells.count * connectivity.components;
      return cells.count == connectivity.layout.count;
    }
    std::array<std::int64_t, 8> some;
    for (std::int64_t c = 0; c < cells.count; ++c) {
      if (cells.layout == INSITU_LAYOUT_MIXED)
        in_order = in_order && load_id(offsets, c) == ids;
      ids += mesh::vertex_count_of(cell(c, some));
    }
    return in_order && cells.layout != INSITU_LAYOUT_PADDED &&
           ids == connectivity.layout.count * connectivity.components;
  }
};

/// What all processes are to have alike; the least of all.
struct VtkShown::Facts {
  std::int64_t is_grid = 1, links_points = 1, links_ids = 1;
  std::int64_t id_type = no_matter, id_type_back = no_matter; ///< back: the negative number
  std::int64_t point_type = no_matter, point_type_back = no_matter;
  std::int64_t no_ghosts = 1, no_cells = 1;
};

VtkShown::VtkShown(const commit::CommittedMesh& mesh, std::string folder, parallel::World& world)
    : folder_(std::move(folder)) {
  const mesh::Mesh& given = mesh.mesh();
  Facts facts;
  world.agree_after([&] {
    facts.is_grid = !given.is_adaptive();
    for (std::int32_t p = 0; p < given.given_piece_count() && facts.is_grid; ++p)
      look_at(given.given_piece(p), facts);
  });
  constexpr std::size_t count = sizeof(Facts) / sizeof(std::int64_t);
  std::array<std::int64_t, count> least;
  std::memcpy(least.data(), &facts, sizeof facts);
  world.reduce(least, parallel::Reduction::least);
  std::memcpy(static_cast<void*>(&facts), least.data(), sizeof facts);
  if (facts.is_grid && !facts.no_cells) {
    form_ = Form::grid;
    has_ghosts_ = !facts.no_ghosts;
    links_points_ = facts.links_points && facts.point_type == -facts.point_type_back;
    if (links_points_)
      point_type_ = insitu_type(facts.point_type);
    links_ids_ = facts.links_ids && facts.id_type == -facts.id_type_back;
    if (links_ids_)
      id_type_ = insitu_type(facts.id_type);
    return;
  }
  pieces_.clear();
  if (world.size() > 1 || given.is_adaptive())
    return;
  for (std::int32_t p = 0; p < given.given_piece_count(); ++p) {
    const mesh::GivenPiece piece = given.given_piece(p);
    const auto* const block = std::get_if<insitu_block>(&piece.cells);
    if (!block || block->kind != INSITU_BLOCK_UNIFORM ||
        *std::min_element(block->vertices, block->vertices + 3) < 2)
      return;
    auto shown = std::make_shared<Piece>();
    shown->block = *block;
    shown->ghosts = piece.ghosts;
    pieces_.push_back(std::move(shown));
  }
  if (pieces_.size() == 1)
    form_ = Form::image;
}

VtkShown::~VtkShown() = default;

void VtkShown::look_at(const mesh::GivenPiece& given, Facts& facts) {
  auto piece = std::make_shared<Piece>();
  piece->points = given.points;
  if (!given.points.empty()) {
    piece->vertices = given.points[0].layout.count;
    facts.links_points = facts.links_points && mesh::components_of(given.points) == 3;
    facts.point_type = std::min<std::int64_t>(facts.point_type, given.points[0].type);
    facts.point_type_back = std::min<std::int64_t>(facts.point_type_back, -given.points[0].type);
  }
  if (const auto* const cells = std::get_if<insitu_cells>(&given.cells)) {
    piece->cells = *cells;
    piece->ghosts = given.ghosts;
    piece->convention = given.convention;
    for (const auto& [name, array] : given.cell_arrays)
      (name == "types"     ? piece->types
       : name == "offsets" ? piece->offsets
                           : piece->connectivity) = array;
    facts.links_ids = piece->count_ids() && facts.links_ids;
    facts.id_type = std::min<std::int64_t>(facts.id_type, piece->connectivity.type);
    facts.id_type_back = std::min<std::int64_t>(facts.id_type_back, -piece->connectivity.type);
    if (piece->connectivity.type == INSITU_INT32 &&
        piece->ids > std::numeric_limits<std::int32_t>::max())
      facts.links_ids = 0; // offsets are of the ids' type
    facts.no_ghosts = facts.no_ghosts && !given.ghosts.given();
    facts.no_cells = facts.no_cells && cells->count == 0;
  } else if (!std::holds_alternative<std::monostate>(given.cells)) {
    facts.is_grid = 0;
  }
  pieces_.push_back(std::move(piece));
}

namespace {

template <class Number>
RecordRun numbers_run(std::int64_t items, std::function<Number(std::int64_t)> at) {
  return {items, nullptr,
          [at = std::move(at)](std::int64_t begin, std::int64_t end, std::byte* to) {
            for (std::int64_t i = begin; i < end; ++i, to += sizeof(Number)) {
              const Number number = at(i);
              std::memcpy(to, &number, sizeof number);
            }
          }};
}

using PiecePointer = std::shared_ptr<const VtkShown::Piece>;

RecordRun types_run(const PiecePointer& piece) {
  return numbers_run<std::uint8_t>(piece->cells.count, [piece](std::int64_t c) {
    std::array<std::int64_t, 8> ids;
    return std::uint8_t(piece->cell(c, ids));
  });
}

/// Where the ids of cells begin, and the end of the last one's.
template <class Number>
RecordRun offsets_run(const PiecePointer& piece) {
  return numbers_run<Number>(piece->cells.count + 1,
                             [piece, next = std::int64_t(0)](std::int64_t c) mutable {
                               const auto now = Number(next);
                               std::array<std::int64_t, 8> ids;
                               if (c < piece->cells.count)
                                 next += mesh::vertex_count_of(piece->cell(c, ids));
                               return now;
                             });
}

RecordRun ids_run(const PiecePointer& piece) {
  return numbers_run<std::int64_t>(piece->ids,
                                   [piece, cell = std::int64_t(-1), at = 0, count = 0,
                                    ids = std::array<std::int64_t, 8>()](std::int64_t) mutable {
                                     while (at == count) { // those of the next cell that has any
                                       count = mesh::vertex_count_of(piece->cell(++cell, ids));
                                       at = 0;
                                     }
                                     return ids[std::size_t(at++)];
                                   });
}

RecordRun points_run(const PiecePointer& piece) {
  const int components = piece->points.empty() ? 0 : mesh::components_of(piece->points);
  return {piece->vertices, nullptr,
          [piece, components](std::int64_t begin, std::int64_t end, std::byte* to) {
            for (std::int64_t i = begin; i < end; ++i)
              for (int c = 0; c < 3; ++c, to += sizeof(double)) {
                const bool one = piece->points.size() == 1;
                const ExternalArray& array =
                    piece->points[one || c >= components ? 0 : std::size_t(c)];
                const double x = c < components ? mesh::load_real(array.at(i, one ? c : 0),
                                                                  array.type == INSITU_FLOAT32)
                                                : 0.0;
                std::memcpy(to, &x, sizeof x);
              }
          }};
}

RecordRun ghosts_run(const PiecePointer& piece) {
  return numbers_run<std::uint8_t>(piece->cells.count, [piece](std::int64_t c) {
    const ExternalArray& ghosts = piece->ghosts;
    const auto bits = ghosts.given() && c < ghosts.layout.count
                          ? std::to_integer<std::uint8_t>(*ghosts.at(c, 0))
                          : std::uint8_t(0);
    return std::uint8_t(piece->convention == INSITU_GHOSTS_VTK ? bits : bits != 0);
  });
}

RecordRun number_run(std::int64_t number) {
  return numbers_run<std::int64_t>(1, [number](std::int64_t) { return number; });
}

} // namespace

std::vector<RecordStream> VtkShown::streams() const {
  if (form_ != Form::grid)
    return {};
  std::vector<RecordStream> out = {
      {"/VTKHDF/NumberOfCells", INSITU_INT64, 1, {}},
      {"/VTKHDF/NumberOfPoints", INSITU_INT64, 1, {}},
      {"/VTKHDF/NumberOfConnectivityIds", INSITU_INT64, 1, {}},
      {"/VTKHDF/Types", INSITU_UINT8, 1, {}},
      {"/VTKHDF/Offsets", id_type_, 1, {}},
  };
  if (!links_ids_)
    out.push_back({"/VTKHDF/Connectivity", INSITU_INT64, 1, {}});
  if (!links_points_)
    out.push_back({"/VTKHDF/Points", INSITU_FLOAT64, 3, {}});
  if (has_ghosts_)
    out.push_back({"/VTKHDF/CellData/vtkGhostType", INSITU_UINT8, 1, {}});
  for (const auto& piece : pieces_) {
    std::size_t s = 0;
    out[s++].runs.push_back(number_run(piece->cells.count));
    out[s++].runs.push_back(number_run(piece->vertices));
    out[s++].runs.push_back(number_run(piece->ids));
    out[s++].runs.push_back(types_run(piece));
    out[s++].runs.push_back(id_type_ == INSITU_INT32 ? offsets_run<std::int32_t>(piece)
                                                     : offsets_run<std::int64_t>(piece));
    if (!links_ids_)
      out[s++].runs.push_back(ids_run(piece));
    if (!links_points_)
      out[s++].runs.push_back(points_run(piece));
    if (has_ghosts_)
      out[s++].runs.push_back(ghosts_run(piece));
  }
  return out;
}

std::map<std::string, std::vector<std::int64_t>>
VtkShown::extents(const std::vector<RecordStream>& of_mesh) const {
  std::map<std::string, std::vector<std::int64_t>> out;
  if (form_ != Form::image)
    return out;
  const insitu_block& block = pieces_[0]->block;
  for (const RecordStream& stream : of_mesh) {
    std::vector<std::int64_t> extents(block.vertices, block.vertices + 3);
    std::reverse(extents.begin(), extents.end());
    if (!stream.where.starts_with(folder_ + "/" + vertex_field) ||
        extents[0] * extents[1] * extents[2] != stream.items())
      continue;
    if (stream.components > 1)
      extents.push_back(stream.components);
    out[stream.where] = std::move(extents);
  }
  return out;
}

std::string VtkShown::dataset(const char* name, insitu_type type, int components) const {
  return folder_ + "/" + name + "." + mesh::type_name(type) +
         (components > 1 ? "x" + std::to_string(components) : "");
}

/// Gives second paths to the fields that have values on all of the parts.
void VtkShown::link_fields(RecordFile& file, const std::string& prefix, const std::string& group,
                           std::int64_t items) const {
  file.at_root()->make_group(group);
  const std::string begin = folder_ + "/" + prefix;
  file.for_each_dataset([&](const std::string& where, std::int64_t count) {
    if (!where.starts_with(begin) || count != items)
      return;
    const std::string name = where.substr(begin.size(), where.rfind('.') - begin.size());
    if (name != "vtkGhostType" && name != "." && !name.empty())
      file.at_root()->link(group + "/" + name, where);
  });
}

void VtkShown::finish(RecordFile& file, std::int64_t cycle, double time) const {
  output::HdfWriter& hdf = *file.at_root();
  const std::string root = "/VTKHDF";
  hdf.make_group(root);
  const auto set = [&](const char* name, std::vector<std::int64_t> numbers) {
    hdf.set_attribute(root, name, std::span<const std::int64_t>(numbers));
  };
  const auto field_data = [&](const std::string& name, insitu_type type, std::int64_t bits) {
    const std::string where = root + "/FieldData/" + name;
    const std::int64_t one = 1;
    hdf.make_dataset(where, type, std::span(&one, 1));
    hdf.write(where, 0, std::as_bytes(std::span(&bits, 1)));
  };
  set("Version", {1, 0});
  const std::int64_t cells = file.items(root + "/Types");
  std::int64_t points = 0;
  if (form_ == Form::grid) {
    hdf.set_attribute(root, "Type", "UnstructuredGrid");
    if (links_ids_)
      hdf.link(root + "/Connectivity", dataset("connectivity", id_type_, 1));
    if (links_points_)
      hdf.link(root + "/Points", dataset("points", point_type_, 3));
    points = file.items(links_points_ ? dataset("points", point_type_, 3) : root + "/Points");
  } else {
    const insitu_block& block = pieces_[0]->block;
    hdf.set_attribute(root, "Type", "ImageData");
    std::vector<std::int64_t> whole;
    double origin[3];
    points = 1;
    for (int a = 0; a < 3; ++a) {
      whole.insert(whole.end(), {0, block.vertices[a] - 1});
      origin[a] = block.origin[a] + double(block.first[a]) * block.spacing[a];
      points *= block.vertices[a];
    }
    set("WholeExtent", whole);
    hdf.set_attribute(root, "Origin", std::span<const double>(origin));
    hdf.set_attribute(root, "Spacing", std::span<const double>(block.spacing));
    const double direction[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    hdf.set_attribute(root, "Direction", std::span<const double>(direction));
  }
  link_fields(file, vertex_field, root + "/PointData", points);
  // VTK 9.1's reader takes an ImageData's cell data for as many values as it has points, and then
  // shows nothing.
  link_fields(file, cell_field, root + "/CellData", form_ == Form::grid ? cells : -1);
  if (form_ != Form::grid)
    return; // of an ImageData that reader takes field data for arrays of three extents
  field_data("CYCLE", INSITU_INT64, cycle);
  field_data("TimeValue", INSITU_FLOAT64, real_bits(time));
}

} // namespace insitu::scene
