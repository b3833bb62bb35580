#include "mesh/registered/cells_copy.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace insitu::mesh {

namespace {

constexpr std::int64_t grain = 1 << 14; ///< cells a task

std::int64_t aligned(std::int64_t at) {
  return (at + 7) & ~std::int64_t(7);
}

template <class T>
void store(std::byte* to, T value) {
  std::memcpy(to, &value, sizeof value);
}

/// The cell's shape in a copy: of a cell that owns no point none, where looking it up could read
/// past the arrays, since such cells may hold garbage.
Shape copied_shape(const PieceView& from, std::int64_t cell) {
  return from.layout == CellLayout::uniform || from.exists(cell) ? from.shape(cell) : Shape::none;
}

} // namespace

/// The ids of all cells; before: of those before each task's.
std::int64_t CellsCopy::count_ids(const PieceView& from, const core::Threads& threads,
                                  std::vector<std::int64_t>& before) {
  before.assign(std::size_t((from.cell_count + grain - 1) / grain + 1), 0);
  if (from.layout == CellLayout::block)
    return 0;
  threads.parallel_for(from.cell_count, grain, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t sum = 0;
    for (std::int64_t c = begin; c < end; ++c)
      sum += vertex_count(copied_shape(from, c));
    before[std::size_t(begin / grain) + 1] = sum;
  });
  for (std::size_t i = 1; i < before.size(); ++i)
    before[i] += before[i - 1];
  return before.back();
}

/// Where a piece's arrays lie from `at` on; returns where they end.
std::int64_t CellsCopy::place(Piece& p, const PieceView& from, std::int64_t ids, std::int64_t at) {
  const bool block = from.layout == CellLayout::block, uniform = from.layout == CellLayout::uniform;
  p.layout = std::int64_t(block     ? CellLayout::block
                          : uniform ? CellLayout::uniform
                                    : CellLayout::mixed);
  p.shape = std::int64_t(block || uniform ? from.uniform_shape : Shape::none);
  p.cells = from.cell_count;
  p.vertices = from.vertex_count;
  for (int a = 0; a < 3; ++a)
    p.block[a] = from.block_vertices[a];
  p.pole = from.pole;
  p.id_count = ids;
  p.ids_are_int32 = from.vertex_count <= std::numeric_limits<std::int32_t>::max();
  const auto next = [&](std::int64_t& place, std::int64_t bytes) {
    place = at;
    at = aligned(at + bytes);
  };
  if (!block)
    next(p.ids, ids * (p.ids_are_int32 ? 4 : 8));
  if (!block && !uniform) {
    next(p.offsets, p.cells * 8);
    next(p.types, p.cells);
  }
  if (from.ghosts)
    next(p.owns, p.cells);
  return at;
}

void CellsCopy::fill(const Piece& p, const PieceView& from, const std::vector<std::int64_t>& before,
                     const core::Threads& threads) {
  std::byte* const base = bytes_.data();
  threads.parallel_for(p.cells, grain, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t at = before[std::size_t(begin / grain)], ids[8];
    for (std::int64_t c = begin; c < end; ++c) {
      if (p.owns >= 0)
        store(base + p.owns + c, std::uint8_t(from.exists(c) ? 0 : 2));
      if (p.ids < 0)
        continue;
      const Shape shape = copied_shape(from, c);
      const int count = shape == Shape::none ? 0 : from.vertex_ids(c, ids);
      if (p.offsets >= 0) {
        store(base + p.offsets + 8 * c, at);
        store(base + p.types + c, std::uint8_t(shape));
      }
      for (int v = 0; v < count; ++v, ++at)
        if (p.ids_are_int32)
          store(base + p.ids + 4 * at, std::int32_t(ids[v]));
        else
          store(base + p.ids + 8 * at, ids[v]);
    }
  });
}

std::int64_t CellsCopy::bytes_for(const MeshView& mesh, const core::Threads& threads) {
  std::int64_t end = 0;
  std::vector<std::int64_t> before;
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    Piece piece;
    end = place(piece, mesh.pieces[p], count_ids(mesh.pieces[p], threads, before), end);
  }
  return end;
}

void CellsCopy::copy(const MeshView& from, const core::Threads& threads) {
  pieces_.clear();
  traits_ = (from.one_mesh ? one_mesh : 0) | (from.is_flat ? flat : 0);
  std::int64_t end = 0;
  std::vector<Piece> pieces(std::size_t(from.piece_count));
  std::vector<std::vector<std::int64_t>> before(pieces.size());
  for (std::size_t p = 0; p < pieces.size(); ++p)
    end = place(pieces[p], from.pieces[p], count_ids(from.pieces[p], threads, before[p]), end);
  bytes_.resize_discard(std::size_t(end));
  // What fills arrays up to whole words goes into checkpoints, too.
  for (const Piece& piece : pieces)
    for (const std::int64_t start : {piece.ids, piece.offsets, piece.types, piece.owns})
      if (start > 0)
        std::memset(bytes_.data() + start - 8, 0, 8);
  if (end > 0)
    std::memset(bytes_.data() + end - 8, 0, 8);
  for (std::size_t p = 0; p < pieces.size(); ++p)
    fill(pieces[p], from.pieces[p], before[p], threads);
  pieces_ = std::move(pieces);
}

void CellsCopy::append(const CellsCopy& behind) {
  const std::size_t at = bytes_.size(); // whole words
  bytes_.resize(at + behind.bytes_.size());
  std::copy(behind.bytes_.begin(), behind.bytes_.end(), bytes_.begin() + at);
  for (Piece piece : behind.pieces_) {
    for (std::int64_t* const place : {&piece.ids, &piece.offsets, &piece.types, &piece.owns})
      if (*place >= 0)
        *place += std::int64_t(at);
    pieces_.push_back(piece);
  }
  set_one_mesh(false); // whether pieces share interior was looked for in each part alone
}

void CellsCopy::release() {
  pieces_.clear();
  bytes_.release();
}

const MeshView& CellsCopy::on(const math::Vec3d* points) {
  views_.clear();
  first_cell_.assign(1, 0);
  first_vertex_.assign(1, 0);
  const auto at = [&](std::int64_t offset) {
    return offset < 0 ? nullptr : bytes_.data() + offset;
  };
  for (const Piece& p : pieces_) {
    PieceView& v = views_.emplace_back();
    v.layout = CellLayout(p.layout);
    v.uniform_shape = Shape(p.shape);
    v.cell_count = p.cells;
    v.vertex_count = p.vertices;
    std::copy(p.block, p.block + 3, v.block_vertices);
    v.pole = std::int8_t(p.pole);
    if (p.ids >= 0) {
      const std::int64_t size = p.ids_are_int32 ? 4 : 8;
      const bool uniform = v.layout == CellLayout::uniform;
      const std::int64_t a_cell = uniform ? PieceView::vertex_count_of(v.uniform_shape) : 1;
      v.connectivity = {at(p.ids), uniform ? p.cells : p.id_count, a_cell * size,
                        p.ids_are_int32 != 0};
      v.id_stride = size;
    }
    if (p.offsets >= 0) {
      v.offsets = {at(p.offsets), p.cells, 8, false};
      v.types = at(p.types);
    }
    if (p.owns >= 0) {
      v.ghosts = at(p.owns);
      v.ghost_layout = {p.cells, {p.cells, 1}, {1, p.cells, p.cells}};
      v.ghost_mask = 2; // none a duplicate that lends its values
    }
    const std::byte* base =
        reinterpret_cast<const std::byte*>(points ? points + first_vertex_.back() : nullptr);
    for (int a = 0; a < 3; ++a)
      v.points.component[a] = base + a * sizeof(double);
    const std::int64_t stride = sizeof(math::Vec3d);
    v.points.layout = {p.vertices, {p.vertices, 1}, {stride, p.vertices * stride, 0}};
    first_cell_.push_back(first_cell_.back() + p.cells);
    first_vertex_.push_back(first_vertex_.back() + p.vertices);
  }
  view_ = {};
  view_.pieces = views_.data();
  view_.first_cell = first_cell_.data();
  view_.first_vertex = first_vertex_.data();
  view_.piece_count = std::int32_t(pieces_.size());
  view_.one_mesh = (traits_ & one_mesh) != 0;
  view_.is_flat = (traits_ & flat) != 0;
  return view_;
}

void CellsCopy::keep(core::Archive& archive) {
  archive.array("earlier cells' pieces", pieces_);
  archive.array("earlier cells", bytes_);
  archive.value("earlier cells are one", traits_);
}

} // namespace insitu::mesh
