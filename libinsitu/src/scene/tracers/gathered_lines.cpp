#include "scene/tracers/gathered_lines.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "core/status.h"
#include "parallel/bytes.h"

namespace insitu::scene {

using parallel::ByteReader;
using parallel::ByteWriter;

namespace {

struct Vertex {
  math::Vec3d point;
  double time;
  OwnCell cell;
};
/// In the place of one that has no cell where its piece was made.
struct Replaced {
  std::int64_t rank, piece, number;
  Vertex vertex;
};
/// Of a line, on one process.
struct Piece {
  std::int64_t line;
  std::int32_t hops;
  std::uint64_t first;
  std::size_t order; ///< on its process
  std::vector<Vertex> vertices;
  std::vector<double> values;
};

} // namespace

GatheredLines::GatheredLines(const advect::LinePieces& here, const TracerAction& tracer,
                             const commit::CommittedMesh& mesh,
                             std::span<const mesh::FieldView> fields, parallel::World& world,
                             core::Memory& memory, std::int64_t per_seed)
    : lines(memory) {
  std::size_t width = 0;
  for (const mesh::FieldView& field : fields)
    width += std::size_t(field.components);
  std::vector<std::byte> mine;
  world.agree_after([&] {
    std::vector<math::Vec3d> points;
    std::vector<std::int64_t> at;
    for (const advect::LinePiece& piece : here.pieces)
      for (const advect::LineVertex& v : piece.vertices) {
        points.push_back(v.point);
        at.push_back(v.cell);
      }
    for (const advect::LinePieces::OfOther& of : here.of_others) {
      points.push_back(of.vertex.point);
      at.push_back(of.vertex.cell);
    }
    const std::vector<double> all = tracer.sample(mesh, fields, points, at);
    ByteWriter to;
    to.value(std::int64_t(here.pieces.size()));
    std::size_t first = 0;
    for (const advect::LinePiece& piece : here.pieces) {
      const std::size_t count = piece.vertices.size();
      to.value(piece.line);
      to.value(piece.hops);
      to.value(piece.first);
      to.value(std::int64_t(count));
      for (const advect::LineVertex& v : piece.vertices)
        to.value(Vertex{v.point, v.time, own_cell(mesh, v.cell, v.point, world)});
      to.array(std::span<const double>(all).subspan(first * width, count * width));
      first += count;
    }
    to.value(std::int64_t(here.of_others.size()));
    for (const advect::LinePieces::OfOther& of : here.of_others) {
      const advect::LineVertex& v = of.vertex;
      to.value(Replaced{
          of.rank, of.piece, of.number, {v.point, v.time, own_cell(mesh, v.cell, v.point, world)}});
      to.array(std::span<const double>(all).subspan(first++ * width, width));
    }
    to.value(std::int64_t(here.ends.size()));
    to.array(std::span<const advect::LinePieces::End>(here.ends));
    mine = to.bytes();
  });
  std::map<int, std::vector<std::byte>> gathered;
  world.gather(mine, std::size_t(1) << 20, [&](int rank, std::span<const std::byte> bytes) {
    gathered[rank].insert(gathered[rank].end(), bytes.begin(), bytes.end());
  });
  world.agree_after([&] {
    std::vector<Piece> pieces;
    std::vector<advect::LinePieces::End> ends;
    std::map<int, std::size_t> first_of; // the place of a process's first piece
    std::vector<std::pair<Replaced, std::vector<double>>> replaced;
    for (const auto& [rank, bytes] : gathered) {
      first_of[rank] = pieces.size();
      ByteReader from(bytes);
      const auto count = from.value<std::int64_t>();
      for (std::int64_t k = 0; k < count; ++k) {
        Piece& piece = pieces.emplace_back();
        piece.line = from.value<std::int64_t>();
        piece.hops = from.value<std::int32_t>();
        piece.first = from.value<std::uint64_t>();
        piece.order = std::size_t(k);
        const auto vertices = std::size_t(from.value<std::int64_t>());
        piece.vertices = from.array<Vertex>(vertices);
        piece.values = from.array<double>(vertices * width);
      }
      for (auto left = from.value<std::int64_t>(); left > 0; --left) {
        const auto vertex = from.value<Replaced>();
        replaced.emplace_back(vertex, from.array<double>(width));
      }
      const std::vector<advect::LinePieces::End> more =
          from.array<advect::LinePieces::End>(std::size_t(from.value<std::int64_t>()));
      ends.insert(ends.end(), more.begin(), more.end());
    }
    for (const auto& [by, with] : replaced) {
      Piece& piece = pieces[first_of.at(int(by.rank)) + std::size_t(by.piece)];
      piece.vertices[std::size_t(by.number)] = by.vertex;
      std::ranges::copy(with, piece.values.begin() + by.number * std::ptrdiff_t(width));
    }
    std::ranges::sort(pieces, {},
                      [](const Piece& p) { return std::tuple(p.line, p.hops, p.order); });
    std::ranges::sort(ends, {}, &advect::LinePieces::End::line);
    lines.offsets.push_back(0);
    std::size_t next = 0;
    for (const advect::LinePieces::End& end : ends) {
      const std::size_t begin = cells.size();
      for (; next < pieces.size() && pieces[next].line == end.line; ++next) {
        const Piece& piece = pieces[next];
        const std::size_t keep = begin + std::size_t(piece.first);
        if (keep > cells.size())
          throw core::Error(INSITU_ERROR_INTERNAL,
                            "tracer: a part of line " + std::to_string(end.line) + " is missing");
        lines.points.resize(keep);
        lines.times.resize(keep);
        cells.resize(keep);
        values.resize(keep * width);
        for (const Vertex& v : piece.vertices) {
          lines.points.push_back(v.point);
          lines.times.push_back(v.time);
          cells.push_back(v.cell);
        }
        values.insert(values.end(), piece.values.begin(), piece.values.end());
      }
      lines.particles.push_back(end.line / per_seed);
      lines.endings.push_back(std::uint8_t(end.ending));
      lines.offsets.push_back(std::int64_t(cells.size()));
    }
  });
}

} // namespace insitu::scene
