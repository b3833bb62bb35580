#include "commit/halo/halo.h"

#include <algorithm>
#include <limits>

#include "commit/committed_mesh.h"
#include "core/text.h"

namespace insitu::commit {

using parallel::ByteReader;
using parallel::ByteWriter;
using parallel::Parcel;

mesh::PieceView Halo::Borrowed::view() {
  const auto bytes = [](const auto& buffer) {
    return reinterpret_cast<const std::byte*>(buffer.data());
  };
  mesh::PieceView v;
  v.layout = mesh::CellLayout::mixed;
  v.is_halo = true;
  v.cell_count = std::int64_t(types.size());
  v.vertex_count = std::int64_t(points.size());
  v.connectivity = {bytes(connectivity), std::int64_t(connectivity.size()), sizeof(std::int32_t),
                    true};
  v.id_stride = sizeof(std::int32_t);
  v.offsets = {bytes(offsets), std::int64_t(offsets.size()), sizeof(std::int64_t), false};
  v.types = bytes(types);
  v.types_stride = 1;
  v.part_of = part_of.empty() ? nullptr : part_of.data();
  v.axis_is_float32 = from_float32;
  for (int a = 0; a < 3; ++a)
    v.points.component[a] = bytes(points) + std::size_t(a) * sizeof(double);
  v.points.layout = {v.vertex_count, {v.vertex_count, 1}, {sizeof(math::Vec3d), 0, 0}, true};
  return v;
}

void Halo::swap(parallel::World& world, core::FunctionRef<void(std::vector<ByteWriter>& to)> write,
                core::FunctionRef<void(int rank, ByteReader& from)> read) const {
  std::vector<Parcel> parcels;
  world.agree_after([&] {
    std::vector<ByteWriter> to(std::size_t(world.size()));
    write(to);
    parcels = parallel::parcels_of(to);
    for (const Parcel& parcel : parcels)
      bytes_sent_ += std::int64_t(parcel.bytes.size());
  });
  const std::vector<Parcel> received = world.exchange(parcels);
  world.agree_after([&] {
    for (const Parcel& p : received) {
      ByteReader from(p.bytes);
      read(p.rank, from);
    }
  });
}

/// Writes the cells, grouped by pieces: of each its number and sizes, then its arrays.
void Halo::lend(const CommittedMesh& mesh, const std::vector<std::vector<std::int64_t>>& cells,
                std::vector<ByteWriter>& to) {
  const mesh::MeshView& view = mesh.lent_view();
  const bool has_global = mesh.mesh().has_global_ids(INSITU_CELL);
  std::vector<std::int64_t> global, offsets, numbers;
  std::vector<std::uint32_t> part;
  std::vector<std::int32_t> connectivity;
  std::vector<std::uint8_t> types;
  std::vector<math::Vec3d> points;
  for (std::size_t r = 0; r < cells.size(); ++r)
    for (auto begin = cells[r].begin(); begin != cells[r].end();) {
      const std::int32_t p = view.piece_of(*begin);
      const mesh::PieceView& piece = view.pieces[p];
      const auto end = std::lower_bound(begin, cells[r].end(), view.first_cell[p + 1]);
      Lent& lent = lent_.emplace_back(Lent{int(r), p, {}, {}, {}});
      std::int64_t ids[8];
      for (auto c = begin; c != end; ++c) {
        lent.cells.push_back(*c - view.first_cell[p]);
        const int n = piece.vertex_ids(lent.cells.back(), ids);
        lent.vertices.insert(lent.vertices.end(), ids, ids + n);
      }
      std::ranges::sort(lent.vertices);
      lent.vertices.erase(std::unique(lent.vertices.begin(), lent.vertices.end()),
                          lent.vertices.end());
      global.clear(), offsets.clear(), connectivity.clear(), types.clear(), points.clear();
      numbers.clear(), part.clear();
      for (const std::int64_t cell : lent.cells) {
        const int n = piece.vertex_ids(cell, ids);
        offsets.push_back(std::int64_t(connectivity.size()));
        types.push_back(std::uint8_t(piece.shape(cell)));
        for (int v = 0; v < n; ++v)
          connectivity.push_back(std::int32_t(std::ranges::lower_bound(lent.vertices, ids[v]) -
                                              lent.vertices.begin()));
        const std::int64_t own = mesh.own_of_lent(view.first_cell[p] + cell);
        numbers.push_back(own - mesh.mesh().own_view().first_cell[p]);
        if (piece.part_of)
          part.push_back(std::uint32_t(mesh.stand_in()->place(view.first_cell[p] + cell).copy));
        if (has_global)
          global.push_back(mesh.mesh().global_id(INSITU_CELL, own));
        seam_[std::size_t(own >> 6)] |= std::uint64_t(1) << (own & 63);
      }
      for (const std::int64_t v : lent.vertices)
        points.push_back(piece.point(v));
      to[r].value(p);
      to[r].value(std::int32_t(has_global));
      to[r].value(std::int32_t(piece.part_of != nullptr));
      to[r].value(std::int32_t(piece.points.is_float32 || piece.axis_is_float32));
      to[r].value(std::int64_t(lent.cells.size()));
      to[r].value(std::int64_t(points.size()));
      to[r].value(std::int64_t(connectivity.size()));
      to[r].array(std::span<const std::int64_t>(numbers));
      to[r].array(std::span<const std::uint32_t>(part));
      to[r].array(std::span<const std::int64_t>(global));
      to[r].array(std::span<const std::int64_t>(offsets));
      to[r].array(std::span<const std::int32_t>(connectivity));
      to[r].array(std::span<const std::uint8_t>(types));
      to[r].array(std::span<const math::Vec3d>(points));
      begin = end;
    }
}

void Halo::borrow(int rank, ByteReader& from) {
  while (!from.at_end()) {
    Borrowed& b = borrowed_.emplace_back(*memory_);
    b.rank = rank;
    b.piece = from.value<std::int32_t>();
    b.has_global = from.value<std::int32_t>() != 0;
    const bool are_parts = from.value<std::int32_t>() != 0;
    b.from_float32 = from.value<std::int32_t>() != 0;
    const auto cells = std::size_t(from.value<std::int64_t>());
    const auto vertices = std::size_t(from.value<std::int64_t>());
    const auto ids = std::size_t(from.value<std::int64_t>());
    const auto read = [&](auto& buffer, std::size_t count) {
      if (count > from.left()) // each item has a byte at least
        throw core::Error(INSITU_ERROR_INTERNAL, "a parcel of cells is too short");
      buffer.resize_discard(count);
      from.array(buffer.span());
    };
    read(b.cells, cells);
    read(b.part, are_parts ? cells : 0);
    b.part_of.resize_discard(b.part.size());
    for (std::size_t c = 0; c < b.part_of.size(); ++c)
      b.part_of[c] = std::uint32_t(b.cells[c]);
    read(b.global, b.has_global ? cells : 0);
    read(b.offsets, cells);
    read(b.connectivity, ids);
    read(b.types, cells);
    read(b.points, vertices);
  }
}

void Halo::find(const CommittedMesh& mesh, const PeriodicAxes& sides, parallel::World& world,
                const core::Threads& threads) {
  const std::vector<std::vector<std::int64_t>> cells = touching_cells(mesh, sides, world, threads);
  std::vector<Borrowed> before;
  swap(
      world,
      [&](std::vector<ByteWriter>& to) {
        lent_.clear();
        seam_.assign(std::size_t((mesh.mesh().own_view().own_cell_count() + 63) / 64), 0);
        lend(mesh, cells, to);
        before = std::exchange(borrowed_, {});
      },
      [&](int rank, ByteReader& from) { borrow(rank, from); });
  world.agree_after([&] {
    views_.clear();
    for (Borrowed& b : borrowed_)
      views_.push_back(b.view());
    near_count_ = borrowed_.size();
  });
}

void Halo::refresh_points(const CommittedMesh& mesh, parallel::World& world) {
  swap(
      world,
      [&](std::vector<ByteWriter>& to) {
        const mesh::MeshView& view = mesh.lent_view();
        for (const Lent& lent : lent_)
          for (const std::int64_t v : lent.vertices)
            to[std::size_t(lent.rank)].value(view.pieces[lent.piece].point(v));
      },
      [&](int rank, ByteReader& from) {
        for (Borrowed& b : borrowed_)
          if (b.rank == rank)
            from.array(b.points.span());
      });
}

void Halo::refresh_values(const CommittedMesh& mesh, parallel::World& world,
                          std::span<double> values, insitu_association association,
                          int components) const {
  const mesh::MeshView& view = mesh.lent_view();
  const bool of_cells = association == INSITU_CELL;
  const std::int64_t* const first = of_cells ? view.first_cell : view.first_vertex;
  const auto n = std::size_t(components);
  swap(
      world,
      [&](std::vector<ByteWriter>& to) {
        for (const Lent& lent : lent_)
          for (const std::int64_t item : of_cells ? lent.cells : lent.vertices)
            to[std::size_t(lent.rank)].array(std::span<const double>(
                values.subspan(std::size_t(first[lent.piece] + item) * n, n)));
      },
      [&](int rank, ByteReader& from) {
        auto piece = view.piece_count - view.halo_piece_count;
        for (const Borrowed& b : borrowed_) {
          const auto begin = std::size_t(first[piece++]) * n;
          if (b.rank == rank)
            from.array(values.subspan(begin, (of_cells ? b.cells.size() : b.points.size()) * n));
        }
      });
}

/// Of a process the names of its fields, as others may have other ones; then of each piece, each of
/// these fields: its association, components, type and values.
void Halo::refresh_fields(const CommittedMesh& mesh, parallel::World& world) {
  swap(
      world,
      [&](std::vector<ByteWriter>& to) {
        std::vector<std::string> names = mesh.mesh().field_names();
        std::erase_if(names, [&](const std::string& name) { return !mesh.lends_field(name); });
        std::ranges::sort(names);
        std::string list;
        for (const std::string& name : names)
          core::join(list, name);
        for (const Lent& lent : lent_) {
          ByteWriter& out = to[std::size_t(lent.rank)];
          if (out.empty()) {
            out.value(std::int64_t(list.size()));
            out.array(std::span<const char>(list));
          }
          for (const std::string& name : names) {
            const mesh::FieldView field = mesh.lent_field(name);
            const mesh::FieldPieceView& values = field.pieces[lent.piece];
            out.value(std::int32_t(field.association));
            out.value(std::int32_t(field.components));
            out.value(std::int32_t(values.is_float32));
            const auto& items = field.association == INSITU_CELL ? lent.cells : lent.vertices;
            const auto put = [&](double value) {
              if (values.is_float32)
                out.value(float(value));
              else
                out.value(value);
            };
            for (const std::int64_t item : items)
              for (int c = 0; c < field.components; ++c)
                put(values.load(item, c));
            for (std::size_t i = 0; i < lent.ghosts.size(); ++i)
              for (int face = 0; face < 6; ++face)
                for (int c = 0; c < field.components && (lent.ghosts[i] >> face & 1); ++c)
                  put(values.load_ghost(lent.cells[i], c, face));
          }
        }
      },
      [&](int rank, ByteReader& from) {
        const std::vector<char> list = from.array<char>(std::size_t(from.value<std::int64_t>()));
        const std::vector<std::string> theirs = core::parted({list.data(), list.size()}),
                                       mine = mesh.mesh().field_names();
        const auto have = [&](const std::string& name) {
          return std::ranges::binary_search(theirs, name);
        };
        for (Borrowed& b : borrowed_) {
          if (b.rank != rank)
            continue;
          for (const std::string& name : theirs) {
            const bool of_cells = from.value<std::int32_t>() == INSITU_CELL;
            const auto components = std::size_t(from.value<std::int32_t>());
            const bool is_float32 = from.value<std::int32_t>() != 0;
            const std::size_t items = b.value_count(of_cells);
            const std::size_t size = is_float32 ? sizeof(float) : sizeof(double);
            if (items * components * size > from.left())
              throw core::Error(INSITU_ERROR_INTERNAL, "a parcel of values is too short");
            std::unique_ptr<Values>& values = b.fields[name];
            if (!values)
              values = std::make_unique<Values>(*memory_);
            values->bytes.resize_discard(items * components * size);
            from.array(values->bytes.span());
            values->components.clear();
            for (std::size_t c = 0; c < components; ++c)
              values->components.push_back(values->bytes.data() + c * size);
            const auto stride = std::int64_t(components * size);
            const auto count = std::int64_t(items);
            values->view = {values->components.data(),
                            {count, {count, 1}, {stride, 0, 0}, true},
                            is_float32,
                            nullptr};
          }
          std::erase_if(b.fields, [&](const auto& f) { return !have(f.first); });
          for (const std::string& name : mine)
            if (!have(name)) { // none of its values is a number
              static constexpr double none = std::numeric_limits<double>::quiet_NaN();
              const mesh::FieldView field = mesh.mesh().own_field(name);
              std::unique_ptr<Values>& values = b.fields[name];
              values = std::make_unique<Values>(*memory_);
              values->components.assign(std::size_t(field.components),
                                        reinterpret_cast<const std::byte*>(&none));
              const auto count = std::int64_t(b.value_count(field.association == INSITU_CELL));
              values->view = {
                  values->components.data(), {count, {count, 1}, {0, 0, 0}, true}, false, nullptr};
            }
        }
      });
}

mesh::FieldPieceView Halo::values(const std::string& field, std::size_t piece) const {
  const auto& fields = borrowed_[piece].fields;
  const auto found = fields.find(field);
  return found == fields.end() ? mesh::FieldPieceView{mesh::no_values, {}, false, nullptr}
                               : found->second->view;
}

CellName Halo::name(std::size_t piece, std::int64_t cell) const {
  const Borrowed& b = borrowed_[piece];
  const auto i = std::size_t(cell);
  CellName name{b.has_global ? b.global[i] : -1, b.rank, b.piece, b.cells[i]};
  name.copy = b.part.empty() ? 0 : std::int32_t(b.part[i]);
  return name;
}

std::pair<std::size_t, std::int64_t> Halo::find(const CellName& name) const {
  const auto of = [](const Borrowed& b) { return std::pair(b.rank, b.piece); };
  const auto near_end = borrowed_.begin() + std::ptrdiff_t(near_count_);
  for (const auto& some : {std::ranges::subrange(borrowed_.begin(), near_end),
                           std::ranges::subrange(near_end, borrowed_.end())}) {
    const auto b = std::ranges::lower_bound(some, std::pair(name.rank, name.piece), {}, of);
    if (b == some.end() || of(*b) != std::pair(name.rank, name.piece))
      continue;
    const auto cell = std::lower_bound(b->cells.begin(), b->cells.end(), name.cell);
    if (cell == b->cells.end() || *cell != name.cell)
      continue;
    std::int64_t at = cell - b->cells.begin();
    for (auto part = at;
         part < std::int64_t(b->part.size()) && b->cells[std::size_t(part)] == name.cell; ++part)
      if (std::int32_t(b->part[std::size_t(part)]) == name.copy)
        at = part;
    return {std::size_t(b - borrowed_.begin()), at};
  }
  return {0, -1};
}

std::int64_t Halo::cell_count() const {
  std::int64_t count = 0;
  for (const mesh::PieceView& piece : views_)
    count += piece.cell_count;
  return count;
}

} // namespace insitu::commit
