#include "mesh/piece_borders.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "mesh/box.h"

namespace insitu::mesh {

using math::Vec3d;

namespace {

/// The vertices of a piece that its owning cells have.
std::vector<std::uint8_t> used_vertices(const PieceView& piece) {
  const bool all = !piece.may_not_exist();
  std::vector<std::uint8_t> used(std::size_t(piece.vertex_count), all);
  std::int64_t ids[8];
  for (std::int64_t cell = 0; !all && cell < piece.cell_count; ++cell) {
    if (!piece.exists(cell))
      continue;
    const int n = piece.vertex_ids(cell, ids);
    for (int v = 0; v < n; ++v)
      used[std::size_t(ids[v])] = 1;
  }
  return used;
}

Box box_of(const PieceView& piece, const std::vector<std::uint8_t>& used) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Box box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (std::int64_t v = 0; v < piece.vertex_count; ++v)
    if (used[std::size_t(v)]) {
      const Vec3d x = piece.point(v);
      box.extend({x, x});
    }
  return box;
}

bool meet(const Box& a, const Box& b, Boxes boxes) {
  for (int axis = 0; axis < 3; ++axis) {
    const double overlap =
        std::min(a.high[axis], b.high[axis]) - std::max(a.low[axis], b.low[axis]);
    if (!(boxes == Boxes::touch ? overlap >= 0.0 : overlap > 0.0))
      return false;
  }
  return true;
}

/// A vertex of a border, ordered by place and then by id.
struct Place {
  double x, y, z;
  std::int64_t flat;

  bool coincides(const Place& other) const { return x == other.x && y == other.y && z == other.z; }
};

} // namespace

Vec3d middle_of(const CellVertices& cell) {
  Vec3d sum;
  for (int v = 0; v < cell.count; ++v)
    sum += cell.x[v];
  return sum / double(cell.count);
}

AmongOthers find_among_others(const MeshView& mesh, Boxes boxes, bool with_cells,
                              const core::Threads& threads) {
  const auto count = std::size_t(mesh.piece_count);
  std::vector<std::vector<std::uint8_t>> used(count);
  std::vector<Box> box(count);
  const auto each_piece = [&](auto&& body) {
    threads.parallel_for(mesh.piece_count, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t p = begin; p < end; ++p)
        body(std::size_t(p), mesh.pieces[p]);
    });
  };
  each_piece([&](std::size_t p, const PieceView& piece) {
    used[p] = used_vertices(piece);
    box[p] = box_of(piece, used[p]);
  });
  std::vector<AmongOthers> found(count);
  each_piece([&](std::size_t p, const PieceView& piece) {
    std::vector<Box> others;
    for (std::size_t o = 0; o < count; ++o)
      if (o != p && meet(box[o], box[p], boxes))
        others.push_back(box[o]);
    if (others.empty())
      return;
    const auto among = [&](const Vec3d& x) {
      return std::any_of(others.begin(), others.end(), [&](const Box& o) { return o.holds(x); });
    };
    for (std::int64_t v = 0; v < piece.vertex_count; ++v)
      if (used[p][std::size_t(v)] && among(piece.point(v)))
        found[p].vertices.push_back(mesh.first_vertex[p] + v);
    CellVertices cell;
    for (std::int64_t c = 0; with_cells && c < piece.cell_count; ++c) {
      if (!piece.exists(c))
        continue;
      gather(mesh, mesh.first_cell[p] + c, cell);
      if (among(middle_of(cell)))
        found[p].cells.push_back(mesh.first_cell[p] + c);
    }
  });
  AmongOthers all;
  for (const AmongOthers& some : found) {
    all.vertices.insert(all.vertices.end(), some.vertices.begin(), some.vertices.end());
    all.cells.insert(all.cells.end(), some.cells.begin(), some.cells.end());
  }
  return all;
}

JoinedVertices join_pieces(const MeshView& mesh, const core::Threads& threads) {
  std::vector<Place> places;
  for (const std::int64_t flat : find_among_others(mesh, Boxes::touch, false, threads).vertices) {
    const std::int32_t piece = piece_of_vertex(mesh, flat);
    const Vec3d p = mesh.pieces[piece].point(flat - mesh.first_vertex[piece]);
    places.push_back({p.x + 0.0, p.y + 0.0, p.z + 0.0, flat});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return std::tie(a.x, a.y, a.z, a.flat) < std::tie(b.x, b.y, b.z, b.flat);
  });
  JoinedVertices joined;
  for (auto first = places.begin(); first != places.end();) {
    const auto last = std::find_if(first, places.end(),
                                   [&](const Place& other) { return !other.coincides(*first); });
    const auto begin = joined.flat.size();
    for (auto at = first; at != last; ++at) {
      const std::int32_t piece = piece_of_vertex(mesh, at->flat);
      const auto in_piece = [&](const Place& other) {
        return other.flat >= mesh.first_vertex[piece] && other.flat < mesh.first_vertex[piece + 1];
      };
      if (std::count_if(first, last, in_piece) == 1)
        joined.flat.push_back(at->flat);
    }
    if (joined.flat.size() - begin < 2)
      joined.flat.resize(begin);
    else
      joined.end.push_back(std::int64_t(joined.flat.size()));
    first = last;
  }
  return joined;
}

} // namespace insitu::mesh
