#include "commit/earlier/earlier_cells.h"

#include <algorithm>
#include <limits>

#include "core/status.h"
#include "mesh/registered/earlier_parts.h"
#include "parallel/bytes.h"

namespace insitu::commit {

using parallel::ByteReader;
using parallel::ByteWriter;

namespace {

template <class T>
void write(ByteWriter& to, const std::vector<T>& items) {
  to.value(std::int64_t(items.size()));
  to.array(std::span<const T>(items));
}

template <class T>
void read(ByteReader& from, std::vector<T>& items) {
  const auto count = std::size_t(from.value<std::int64_t>());
  items = from.array<T>(count);
}

/// Calls f(array) for all arrays of plain data, in one order.
template <class Cells, class F>
void for_arrays(Cells& cells, F&& f) {
  f(cells.names);
  f(cells.offsets);
  f(cells.ids);
  f(cells.types);
  f(cells.poles);
  f(cells.step.points);
  f(cells.spots);
  f(cells.gridlets);
  f(cells.leaves);
}

} // namespace

parallel::Parcel EarlierCells::parcel(int to) const {
  ByteWriter out;
  for_arrays(*this, [&](const auto& items) { write(out, items); });
  out.value(lattice);
  out.value(std::int64_t(step.fields.size()));
  for (const mesh::EarlierStep::Field& field : step.fields) {
    write(out, std::vector<char>(field.name.begin(), field.name.end()));
    out.value(std::int32_t(field.association));
    out.value(std::int32_t(field.components));
    write(out, field.steps.front());
  }
  return {to, out.bytes()};
}

EarlierCells EarlierCells::read(const parallel::Parcel& parcel) {
  ByteReader from(parcel.bytes);
  EarlierCells cells;
  for_arrays(cells, [&](auto& items) { commit::read(from, items); });
  for (mesh::CellName& name : cells.names)
    name.rank = parcel.rank;
  cells.lattice = from.value<mesh::Lattice>();
  const auto fields = from.value<std::int64_t>();
  for (std::int64_t f = 0; f < fields; ++f) {
    mesh::EarlierStep::Field& field = cells.step.fields.emplace_back();
    std::vector<char> name;
    commit::read(from, name);
    field.name.assign(name.begin(), name.end());
    field.association = insitu_association(from.value<std::int32_t>());
    field.components = from.value<std::int32_t>();
    commit::read(from, field.steps.emplace_back());
  }
  return cells;
}

EarlierCells EarlierCells::joined(const std::vector<EarlierCells>& parts) {
  EarlierCells all;
  std::vector<std::int64_t> first{0}; // vertex of each part
  std::vector<std::pair<std::size_t, std::size_t>> cells;
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (!mesh::have_same_fields(parts[p].step, parts.front().step))
      throw core::Error(INSITU_ERROR_INTERNAL, "processes have kept different fields");
    append(all.step.points, parts[p].step.points);
    append(all.gridlets, parts[p].gridlets);
    append(all.leaves, parts[p].leaves);
    first.push_back(std::int64_t(all.step.points.size()));
    for (std::size_t c = 0; c < parts[p].count(); ++c)
      cells.emplace_back(p, c);
  }
  if (parts.empty())
    return all;
  all.lattice = parts.front().lattice;
  std::ranges::sort(cells, {}, [&](const auto& of) { return parts[of.first].names[of.second]; });
  for (const auto& [p, c] : cells) {
    const EarlierCells& part = parts[p];
    all.names.push_back(part.names[c]);
    all.types.push_back(part.types[c]);
    for (std::int64_t k = part.offsets[c]; k < part.offsets[c + 1]; ++k)
      all.ids.push_back(first[p] + part.ids[std::size_t(k)]);
    all.offsets.push_back(std::int64_t(all.ids.size()));
    if (!part.poles.empty())
      all.poles.push_back(part.poles[c]);
    if (!part.spots.empty())
      all.spots.push_back(part.spots[c]);
  }
  for (std::size_t f = 0; f < parts.front().step.fields.size(); ++f) {
    const mesh::EarlierStep::Field& of = parts.front().step.fields[f];
    const auto values_of = [&](const EarlierCells& part) -> const std::vector<double>& {
      return part.step.fields[f].steps.front();
    };
    std::vector<double> values;
    if (of.association == INSITU_CELL)
      for (const auto& [p, c] : cells) {
        const double* const from = values_of(parts[p]).data() + c * std::size_t(of.components);
        values.insert(values.end(), from, from + of.components);
      }
    else
      for (const EarlierCells& part : parts)
        append(values, values_of(part));
    all.step.fields.push_back({of.name, of.association, of.components, {std::move(values)}});
  }
  return all;
}

void EarlierCells::order_vertices(std::span<const std::int64_t> number) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto order = [&](auto& items, std::size_t of_each, const auto& missing) {
    std::remove_reference_t<decltype(items)> ordered;
    ordered.reserve(number.size() * of_each);
    for (const std::int64_t v : number)
      for (std::size_t c = 0; c < of_each; ++c)
        ordered.push_back(v < 0 ? missing : items[std::size_t(v) * of_each + c]);
    items = std::move(ordered);
  };
  order(step.points, 1, math::Vec3d{none, none, none});
  for (mesh::EarlierStep::Field& field : step.fields)
    if (field.association == INSITU_VERTEX)
      order(field.steps.front(), std::size_t(field.components), none);
}

mesh::CellsCopy EarlierCells::copy(core::Memory& memory, const core::Threads& threads) {
  std::vector<mesh::PieceView> pieces;
  std::vector<std::int64_t> first_cell{0}, first_vertex{0}, order;
  std::vector<std::int64_t> local(ids.size()), number(step.points.size(), -1);
  const auto bytes = [](const auto* items) { return reinterpret_cast<const std::byte*>(items); };
  std::size_t begin = 0, end = 0;
  do { // one piece at least
    const auto chart = names.empty() ? 0 : names[begin].chart;
    for (; end < count() && names[end].chart == chart; ++end)
      for (std::int64_t k = offsets[end]; k < offsets[end + 1]; ++k) {
        std::int64_t& at = number[std::size_t(ids[std::size_t(k)])];
        if (at < first_vertex.back()) {
          at = std::int64_t(order.size());
          order.push_back(ids[std::size_t(k)]);
        }
        local[std::size_t(k)] = at - first_vertex.back();
      }
    mesh::PieceView& piece = pieces.emplace_back();
    piece.layout = mesh::CellLayout::mixed;
    piece.cell_count = std::int64_t(end - begin);
    piece.vertex_count = std::int64_t(order.size()) - first_vertex.back();
    piece.connectivity = {bytes(local.data()), std::int64_t(local.size()), sizeof(std::int64_t),
                          false};
    piece.id_stride = sizeof(std::int64_t);
    piece.offsets = {bytes(offsets.data() + begin), piece.cell_count, sizeof(std::int64_t), false};
    piece.types = bytes(types.data() + begin);
    piece.pole = poles.empty() ? std::int8_t(0) : poles[begin];
    first_cell.push_back(std::int64_t(end));
    first_vertex.push_back(std::int64_t(order.size()));
    begin = end;
  } while (end < count());
  order_vertices(order);
  mesh::MeshView view;
  view.pieces = pieces.data();
  view.piece_count = std::int32_t(pieces.size());
  view.first_cell = first_cell.data();
  view.first_vertex = first_vertex.data();
  mesh::CellsCopy cells(memory);
  cells.copy(view, threads);
  return cells;
}

} // namespace insitu::commit
