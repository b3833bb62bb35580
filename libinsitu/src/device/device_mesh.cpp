#include "device/device_mesh.h"

#include <algorithm>
#include <cstring>

#include "core/status.h"
#include "device/local_frame.h"
#include "mesh/registered/host_mirror.h"

namespace insitu::device {

using core::Error;

namespace {

std::uint32_t changes_of(mesh::Mesh::ArrayKind kind) {
  switch (kind) {
  case mesh::Mesh::ArrayKind::geometry:
    return INSITU_CHANGED_GEOMETRY;
  case mesh::Mesh::ArrayKind::topology:
    return INSITU_CHANGED_TOPOLOGY;
  default:
    return INSITU_CHANGED_FIELDS;
  }
}

template <class T>
std::size_t append(std::vector<std::byte>& to, const T* items, std::size_t count) {
  to.resize((to.size() + 15) / 16 * 16);
  const std::size_t at = to.size();
  const auto* bytes = reinterpret_cast<const std::byte*>(items);
  to.insert(to.end(), bytes, bytes + count * sizeof(T));
  return at;
}

template <class T>
const T* at(const Buffer<std::byte>& buffer, std::size_t offset) {
  return reinterpret_cast<const T*>(buffer.data() + offset);
}

} // namespace

DeviceMesh::DeviceMesh(core::Memory& memory)
    : memory_(&memory), tables_(memory), vertices_(memory) {}

void DeviceMesh::commit(const mesh::Mesh& mesh, std::uint32_t what, StreamHandle stream) {
  copy_ranges(mesh, what, stream);
  translate_pieces(mesh.view());
  field_tables_.clear();
  std::vector<std::byte> host;
  const std::size_t n = pieces_.size();
  const std::size_t pieces = append(host, pieces_.data(), n);
  const std::size_t cells = append(host, first_cell_.data(), n + 1);
  const std::size_t vertices = append(host, first_vertex_.data(), n + 1);
  tables_.resize_discard(host.size());
  copy_to_device(tables_.data(), host.data(), host.size(), stream,
                 "copying the pieces' descriptions");
  view_ = host_view_;
  view_.pieces = at<mesh::PieceView>(tables_, pieces);
  view_.first_cell = at<std::int64_t>(tables_, cells);
  view_.first_vertex = at<std::int64_t>(tables_, vertices);
  if (what & INSITU_CHANGED_TOPOLOGY)
    origin_ = middle_of_cells(view_, cell_count(), *memory_, stream);
  if (wants_vertices_ && (what & (INSITU_CHANGED_TOPOLOGY | INSITU_CHANGED_GEOMETRY)))
    fill_vertices(stream);
  wait(stream, "bringing the mesh's copies up to date");
}

/// Copies what lies on the host: anew where arrays lie elsewhere than before, or were changed.
void DeviceMesh::copy_ranges(const mesh::Mesh& mesh, std::uint32_t what, StreamHandle stream) {
  struct Needed {
    mesh::ExternalArray::Range range;
    std::uint32_t kinds;
  };
  std::vector<Needed> needed;
  device_ranges_.clear();
  mesh.visit_arrays(
      [&](const mesh::ExternalArray& array, const std::string&, mesh::Mesh::ArrayKind kind) {
        const mesh::ExternalArray::Range range = array.range();
        if (range.begin == range.end)
          return;
        if (array.memory == INSITU_DEVICE)
          device_ranges_.push_back(range);
        else
          needed.push_back({range, changes_of(kind)});
      });
  std::sort(needed.begin(), needed.end(),
            [](const Needed& a, const Needed& b) { return a.range.begin < b.range.begin; });
  std::vector<Needed> merged;
  for (const Needed& n : needed) {
    if (merged.empty() || n.range.begin >= merged.back().range.end) {
      merged.push_back(n);
      continue;
    }
    merged.back().range.end = std::max(merged.back().range.end, n.range.end);
    merged.back().kinds |= n.kinds;
  }

  std::vector<Range> before = std::move(ranges_);
  ranges_.clear();
  // Copies that stay, and then those whose memory can serve others, before new memory is asked for.
  std::vector<Range*> free;
  std::vector<Range*> same(merged.size(), nullptr);
  std::size_t next = 0;
  for (Range& old : before) {
    while (next < merged.size() && merged[next].range.begin < old.begin)
      ++next;
    if (next < merged.size() && merged[next].range.begin == old.begin &&
        merged[next].range.end == old.end)
      same[next] = &old;
    else
      free.push_back(&old);
  }
  for (Range* old : free)
    old->copy.release();
  for (std::size_t i = 0; i < merged.size(); ++i) {
    const Needed& n = merged[i];
    Range range{n.range.begin, n.range.end, n.kinds, Buffer<std::byte>(*memory_), 0};
    const std::size_t bytes = n.range.end - n.range.begin;
    range.shift = n.range.begin % 16;
    const bool copied = same[i] && !(what & n.kinds);
    if (same[i])
      range.copy = std::move(same[i]->copy);
    range.copy.resize_discard(bytes + range.shift);
    if (!copied)
      copy_to_device(range.copy.data() + range.shift, reinterpret_cast<const void*>(n.range.begin),
                     bytes, stream, "copying the mesh's arrays");
    ranges_.push_back(std::move(range));
  }
}

const std::byte* DeviceMesh::on_device(const std::byte* p, const std::string& name) const {
  const auto address = reinterpret_cast<std::uintptr_t>(p);
  const auto above =
      std::upper_bound(ranges_.begin(), ranges_.end(), address,
                       [](std::uintptr_t a, const Range& range) { return a < range.begin; });
  if (above != ranges_.begin()) {
    const Range& range = *(above - 1);
    if (address < range.end)
      return range.copy.data() + range.shift + (address - range.begin);
  }
  for (const mesh::ExternalArray::Range& range : device_ranges_)
    if (address >= range.begin && address < range.end)
      return p;
  throw Error(INSITU_ERROR_FIELD, name + ": not on the device; it is no array of the mesh that was "
                                         "committed");
}

void DeviceMesh::translate_pieces(const mesh::MeshView& from) {
  const auto n = std::size_t(from.piece_count);
  pieces_.assign(from.pieces, from.pieces + n);
  first_cell_.assign(from.first_cell, from.first_cell + n + 1);
  first_vertex_.assign(from.first_vertex, from.first_vertex + n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    const std::string name = "piece " + std::to_string(i);
    mesh::for_each_array(pieces_[i],
                         [&](const std::byte*& p, std::int64_t count, const char* array) {
                           p = p && count > 0 ? on_device(p, name + " " + array) : nullptr;
                         });
  }
  host_view_ = from;
  host_view_.pieces = pieces_.data();
  host_view_.first_cell = first_cell_.data();
  host_view_.first_vertex = first_vertex_.data();
  host_view_.earlier_points = nullptr;
  host_view_.largest_displacement = 0.0;
}

namespace {

/// The shape that all cells have, if kernels are made for it.
mesh::Shape only_shape(const mesh::MeshView& mesh) {
  if (mesh.piece_count != 1 || (mesh.pieces[0].layout != mesh::CellLayout::uniform &&
                                mesh.pieces[0].layout != mesh::CellLayout::block))
    return mesh::Shape::none;
  const mesh::Shape shape = mesh.pieces[0].uniform_shape;
  return shape == mesh::Shape::tetrahedron || shape == mesh::Shape::hexahedron ? shape
                                                                               : mesh::Shape::none;
}

} // namespace

KernelMesh DeviceMesh::in_kernels() const {
  KernelMesh out;
  out.view = view_;
  out.shape = only_shape(host_view_);
  if (host_view_.piece_count > 0)
    out.piece = host_view_.pieces[0];
  return out;
}

const float* DeviceMesh::vertices(StreamHandle stream) {
  if (!wants_vertices_) {
    wants_vertices_ = true;
    fill_vertices(stream);
  }
  return vertices_.data();
}

void DeviceMesh::release_vertices() {
  wants_vertices_ = false;
  vertices_.release();
}

void DeviceMesh::fill_vertices(StreamHandle stream) {
  vertices_.resize_discard(std::size_t(3 * vertex_count()));
  float_vertices(view_, vertex_count(), origin_, vertices_.data(), stream);
}

const KernelField* DeviceMesh::fields(std::span<const mesh::FieldView> fields,
                                      StreamHandle stream) const {
  if (fields.empty())
    return nullptr;
  const std::size_t pieces = pieces_.size();
  std::vector<std::byte> key;
  for (const mesh::FieldView& field : fields) {
    append(key, &field.association, 1);
    append(key, &field.components, 1);
    for (std::size_t p = 0; p < pieces; ++p) {
      append(key, field.pieces[p].component, std::size_t(field.components));
      append(key, field.pieces[p].layout.stride, 3);
      append(key, &field.pieces[p].is_float32, 1);
    }
  }
  for (const FieldTable& table : field_tables_)
    if (table.key == key)
      return at<KernelField>(table.data, 0);

  // Offsets become pointers once the memory is there.
  std::vector<KernelField> heads;
  std::vector<mesh::FieldPieceView> views;
  std::vector<const std::byte*> components;
  for (const mesh::FieldView& field : fields) {
    heads.push_back({field.association, field.components, nullptr});
    for (std::size_t p = 0; p < pieces; ++p) {
      if (field.pieces[p].behind)
        throw core::Error(INSITU_ERROR_UNSUPPORTED,
                          std::string("field '") + field.name +
                              "': items behind pointers are not read on a device");
      views.push_back(field.pieces[p]);
      for (int c = 0; c < field.components; ++c)
        components.push_back(
            field.pieces[p].layout.count > 0
                ? on_device(field.pieces[p].component[c], std::string("field '") + field.name + "'")
                : nullptr);
    }
  }
  constexpr std::size_t most_tables = 64; // whoever asks for more gets them made anew
  if (field_tables_.size() == most_tables) {
    wait_for_all("waiting for queries");
    field_tables_.clear();
  }
  FieldTable table{std::move(key), Buffer<std::byte>(*memory_), {}};
  const std::size_t head_at = append(table.host, heads.data(), heads.size());
  const std::size_t view_at = append(table.host, views.data(), views.size());
  const std::size_t component_at = append(table.host, components.data(), components.size());
  table.data.resize_discard(table.host.size());
  auto* const head = reinterpret_cast<KernelField*>(table.host.data() + head_at);
  auto* const view = reinterpret_cast<mesh::FieldPieceView*>(table.host.data() + view_at);
  const auto* const component = at<const std::byte*>(table.data, component_at);
  std::size_t used = 0;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    head[f].pieces = at<mesh::FieldPieceView>(table.data, view_at) + f * pieces;
    for (std::size_t p = 0; p < pieces; ++p) {
      view[f * pieces + p].component = component + used;
      used += std::size_t(fields[f].components);
    }
  }
  constexpr const char* what = "copying the fields' descriptions";
  copy_to_device(table.data.data(), table.host.data(), table.host.size(), stream, what);
  wait(stream, what); // other streams use it
  field_tables_.push_back(std::move(table));
  return at<KernelField>(field_tables_.back().data, head_at);
}

std::int64_t DeviceMesh::bytes() const {
  std::int64_t sum = tables_.bytes() + vertices_.bytes();
  for (const Range& range : ranges_)
    sum += range.copy.bytes();
  for (const FieldTable& table : field_tables_)
    sum += table.data.bytes();
  return sum;
}

std::int64_t DeviceMesh::bytes_copied() const {
  std::int64_t sum = 0;
  for (const Range& range : ranges_)
    sum += std::int64_t(range.end - range.begin);
  return sum;
}

} // namespace insitu::device
