/// The step before a change of topology, where it is spread over processes.
#include <algorithm>
#include <limits>

#include "commit/earlier/earlier_mesh.h"
#include "commit/halo/cells_near.h"
#include "core/status.h"
#include "mesh/cell_name.h"
#include "mesh/registered/earlier_parts.h"
#include "query/directory.h"

namespace insitu::commit {

using math::Vec3d;
using mesh::CellName;
using parallel::ByteReader;
using parallel::ByteWriter;
using parallel::Parcel;

/// Refuses places where others had cells that are not here.
class EarlierMesh::Beyond final : public query::Outlook {
public:
  Beyond(std::vector<mesh::Box> here, query::Directory others, int rank)
      : here_(std::move(here)), others_(std::move(others)), rank_(rank) {}

  void missed(const Vec3d& point, double) const override {
    if (std::ranges::any_of(here_, [&](const mesh::Box& box) { return box.holds(point); }))
      return;
    for (int r = 0; r < others_.size(); ++r)
      if (r != rank_ && others_.may_hold(r, point))
        throw core::Error(INSITU_ERROR_UNSUPPORTED,
                          "tracer: a step over a change of cells goes to (" +
                              std::to_string(point.x) + ", " + std::to_string(point.y) + ", " +
                              std::to_string(point.z) +
                              "), where another process had cells: shorter steps, such as "
                              "'integrator: {max_step}', do not");
  }

private:
  std::vector<mesh::Box> here_;
  query::Directory others_;
  int rank_;
};

namespace {

/// What comes from one process.
struct Part {
  std::vector<CellName> names;
  std::vector<std::int64_t> offsets; ///< one more than cells
  std::vector<std::int64_t> ids;
  std::vector<std::uint8_t> types;
  mesh::EarlierStep step; ///< of these cells
};

Part read(const Parcel& parcel) {
  ByteReader from(parcel.bytes);
  Part part;
  const auto count = [&] { return std::size_t(from.value<std::int64_t>()); };
  const std::size_t cells = count(), vertices = count(), ids = count(), fields = count();
  part.names = from.array<CellName>(cells);
  for (CellName& name : part.names)
    name.rank = parcel.rank;
  part.offsets = from.array<std::int64_t>(cells + 1);
  part.ids = from.array<std::int64_t>(ids);
  part.types = from.array<std::uint8_t>(cells);
  part.step.points = from.array<Vec3d>(vertices);
  for (std::size_t f = 0; f < fields; ++f) {
    mesh::EarlierStep::Field& field = part.step.fields.emplace_back();
    const std::vector<char> name = from.array<char>(count());
    field.name.assign(name.begin(), name.end());
    field.association = insitu_association(from.value<std::int32_t>());
    field.components = from.value<std::int32_t>();
    field.steps.push_back(from.array<double>((field.association == INSITU_CELL ? cells : vertices) *
                                             std::size_t(field.components)));
  }
  return part;
}

/// Cells of several parts in the order of their names, and what they have.
struct Joined {
  std::vector<std::int64_t> offsets, ids;
  std::vector<std::uint8_t> types;
  mesh::EarlierStep step;

  explicit Joined(const std::vector<Part>& parts) {
    std::vector<std::int64_t> first{0}; // vertex of each part
    std::vector<std::pair<std::size_t, std::size_t>> cells;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const std::vector<Vec3d>& points = parts[p].step.points;
      first.push_back(first.back() + std::int64_t(points.size()));
      step.points.insert(step.points.end(), points.begin(), points.end());
      for (std::size_t c = 0; c < parts[p].names.size(); ++c)
        cells.emplace_back(p, c);
    }
    std::ranges::sort(cells, {}, [&](const auto& of) { return parts[of.first].names[of.second]; });
    for (const auto& [p, c] : cells) {
      const Part& part = parts[p];
      offsets.push_back(std::int64_t(ids.size()));
      types.push_back(part.types[c]);
      for (std::int64_t k = part.offsets[c]; k < part.offsets[c + 1]; ++k)
        ids.push_back(first[p] + part.ids[std::size_t(k)]);
    }
    for (std::size_t f = 0; f < parts.front().step.fields.size(); ++f) {
      const mesh::EarlierStep::Field& of = parts.front().step.fields[f];
      const auto values_of = [&](const Part& part) -> const std::vector<double>& {
        return part.step.fields[f].steps.front();
      };
      std::vector<double> values;
      if (of.association == INSITU_CELL)
        for (const auto& [p, c] : cells) {
          const double* from = values_of(parts[p]).data() + c * std::size_t(of.components);
          values.insert(values.end(), from, from + of.components);
        }
      else
        for (const Part& part : parts)
          values.insert(values.end(), values_of(part).begin(), values_of(part).end());
      step.fields.push_back({of.name, of.association, of.components, {std::move(values)}});
    }
  }

  /// The cells, copied.
  mesh::CellsCopy copy(core::Memory& memory, const core::Threads& threads) const {
    const auto bytes = [](const auto& v) { return reinterpret_cast<const std::byte*>(v.data()); };
    mesh::PieceView piece;
    piece.layout = mesh::CellLayout::mixed;
    piece.cell_count = std::int64_t(types.size());
    piece.vertex_count = std::int64_t(step.points.size());
    piece.connectivity = {bytes(ids), std::int64_t(ids.size()), sizeof(std::int64_t), false};
    piece.id_stride = sizeof(std::int64_t);
    piece.offsets = {bytes(offsets), std::int64_t(offsets.size()), sizeof(std::int64_t), false};
    piece.types = bytes(types);
    const std::int64_t first_cell[] = {0, piece.cell_count},
                       first_vertex[] = {0, piece.vertex_count};
    mesh::MeshView view;
    view.pieces = &piece;
    view.piece_count = 1;
    view.first_cell = first_cell;
    view.first_vertex = first_vertex;
    mesh::CellsCopy cells(memory);
    cells.copy(view, threads);
    return cells;
  }
};

/// The boxes of a view's first cells, exactly, of many that follow each other.
std::vector<mesh::Box> exact_boxes(const mesh::MeshView& view, std::int64_t cells) {
  constexpr auto most = std::int64_t(query::Directory::most_boxes);
  const std::int64_t grain = std::max<std::int64_t>((cells + most - 1) / most, 1);
  std::vector<mesh::Box> boxes;
  std::int64_t last = -1; // of the box that is made
  mesh::CellVertices c;
  for (std::int64_t flat = 0; flat < cells; ++flat) {
    const std::int32_t piece = view.piece_of(flat);
    if (!view.pieces[piece].exists(flat - view.first_cell[piece]))
      continue;
    mesh::gather(view, flat, c);
    const mesh::Box box = mesh::box_of(c);
    if (flat / grain == last)
      boxes.back().extend(box);
    else
      boxes.push_back(box);
    last = flat / grain;
  }
  return boxes;
}

} // namespace

/// This process's own cells that meet the boxes, with all that was kept of them.
void EarlierMesh::write_cells(std::span<const mesh::Box> boxes, ByteWriter& to) const {
  std::vector<CellName> names;
  std::vector<std::int64_t> flats, offsets{0}, ids, vertices;
  std::vector<std::uint8_t> types;
  const mesh::MeshView& view = *view_;
  std::int64_t of_cell[8];
  for (const std::int64_t flat : cells_near(view, tree_, boxes)) {
    const std::int32_t p = view.piece_of(flat);
    const mesh::PieceView& piece = view.pieces[p];
    const std::int64_t cell = flat - view.first_cell[p];
    if (flat >= own_.cells || !piece.exists(cell))
      continue;
    flats.push_back(flat);
    names.push_back({own_.global.empty() ? -1 : own_.global[std::size_t(flat)], -1, 0, flat});
    types.push_back(std::uint8_t(piece.shape(cell)));
    const int n = piece.vertex_ids(cell, of_cell);
    for (int v = 0; v < n; ++v)
      ids.push_back(view.first_vertex[p] + of_cell[v]);
    offsets.push_back(std::int64_t(ids.size()));
  }
  vertices = ids;
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (std::int64_t& id : ids)
    id = std::ranges::lower_bound(vertices, id) - vertices.begin();
  for (const std::size_t count : {flats.size(), vertices.size(), ids.size(), step_.fields.size()})
    to.value(std::int64_t(count));
  to.array(std::span<const CellName>(names));
  to.array(std::span<const std::int64_t>(offsets));
  to.array(std::span<const std::int64_t>(ids));
  to.array(std::span<const std::uint8_t>(types));
  const auto piece_of = [&](const std::int64_t* first, std::int64_t flat) {
    return std::upper_bound(first, first + view.piece_count + 1, flat) - first - 1;
  };
  for (const std::int64_t v : vertices) {
    const auto p = piece_of(view.first_vertex, v);
    to.value(view.pieces[p].point(v - view.first_vertex[p]));
  }
  for (const auto& field : step_.fields) {
    const bool of_cells = field->association == INSITU_CELL;
    const mesh::FieldView values = field->view(0);
    to.value(std::int64_t(field->name.size()));
    to.array(std::span<const char>(field->name));
    to.value(std::int32_t(field->association));
    to.value(std::int32_t(field->components));
    for (const std::int64_t item : of_cells ? flats : vertices) {
      const std::int64_t* const first = of_cells ? view.first_cell : view.first_vertex;
      const auto p = piece_of(first, item);
      for (int c = 0; c < field->components; ++c)
        to.value(values.pieces[p].load(item - first[p], c));
    }
  }
}

std::unique_ptr<EarlierMesh> EarlierMesh::gathered(const EarlierMesh* here, const accel::Tree& now,
                                                   parallel::World& world, core::Memory& memory,
                                                   const core::Threads& threads) {
  std::vector<mesh::Box> wanted, own;
  world.agree_after([&] {
    if (here) {
      here->fit_.complete();
      own = exact_boxes(*here->view_, here->own_.cells);
    }
    wanted = query::boxes_of(now);
    wanted.insert(wanted.end(), own.begin(), own.end());
    for (mesh::Box& box : wanted) { // steps are tried beside cells, too
      const Vec3d little = 0.05 * box.size();
      box = {box.low - little, box.high + little};
    }
  });
  query::Directory all, before;
  all.gather(wanted, world);
  before.gather(own, world);
  std::vector<Parcel> parcels;
  world.agree_after([&] {
    for (int r = 0; r < world.size() && here; ++r) {
      ByteWriter to;
      here->write_cells(all.boxes(r), to);
      parcels.push_back({r, to.bytes()});
    }
  });
  const std::vector<Parcel> received = world.exchange(parcels);
  std::unique_ptr<EarlierMesh> mesh;
  world.agree_after([&] {
    std::vector<Part> parts;
    for (const Parcel& parcel : received)
      parts.push_back(read(parcel));
    if (parts.empty())
      return;
    for (const Part& part : parts)
      if (!mesh::have_same_fields(part.step, parts.front().step))
        throw core::Error(INSITU_ERROR_INTERNAL, "processes have kept different fields");
    const Joined joined(parts);
    mesh = restored(joined.step, joined.copy(memory, threads), std::nullopt, memory, threads);
    if (mesh)
      mesh->beyond_ = std::make_shared<Beyond>(std::move(wanted), std::move(before), world.rank());
  });
  return mesh;
}

} // namespace insitu::commit
