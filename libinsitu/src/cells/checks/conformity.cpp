#include "cells/checks/conformity.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <numeric>
#include <vector>

#include "cells/kernels/faces.h"

namespace insitu::cells {

namespace {

using math::Vec3d;

constexpr FaceTable tables[] = {face_table(mesh::Shape::tetrahedron),
                                face_table(mesh::Shape::voxel), face_table(mesh::Shape::hexahedron),
                                face_table(mesh::Shape::wedge), face_table(mesh::Shape::pyramid)};
const FaceTable& table_of(mesh::Shape shape) {
  return tables[int(shape) - int(mesh::Shape::tetrahedron)];
}

/// A face by its vertices' places: sorted; of a quad also the corner opposite to the lowest. Equal
/// for the same triangle or the same cyclic quad. A triangle's last two numbers are -1.
using Face5 = std::array<std::int64_t, 5>;
/// The same without the lowest vertex.
using Rest = std::array<std::int64_t, 4>;

struct Place {
  std::uint64_t hash;
  std::int64_t vertex;
};

std::uint64_t hash_of(const Vec3d& p) {
  std::uint64_t h = 0;
  for (int a = 0; a < 3; ++a) { // + 0.0: a zero has one sign
    h = (h ^ std::bit_cast<std::uint64_t>(p[a] + 0.0)) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
  }
  return h;
}

class Checker {
public:
  Checker(const mesh::MeshView& mesh, const core::Threads& threads)
      : mesh_(mesh), threads_(threads) {}

  Conformity run() {
    find_places();
    sort_faces();
    count();
    return result_;
  }

private:
  static constexpr std::int64_t grain = 4096;

  /// Calls visit(shape, flat vertex ids, their count) for every cell that can own points.
  template <class Visit>
  void for_each_cell(std::int64_t begin, std::int64_t end, Visit&& visit) const {
    for (std::int64_t flat = begin; flat < end; ++flat) {
      const std::int32_t piece = mesh_.piece_of(flat);
      const mesh::PieceView& p = mesh_.pieces[piece];
      const std::int64_t cell = flat - mesh_.first_cell[piece];
      if (!p.exists(cell))
        continue;
      std::int64_t ids[8];
      const int n = p.vertex_ids(cell, ids);
      for (int v = 0; v < n; ++v)
        ids[v] += mesh_.first_vertex[piece];
      visit(p.shape(cell), ids, n);
    }
  }

  Vec3d point(std::int64_t flat) const {
    const std::int64_t* first = mesh_.first_vertex;
    const auto piece = std::upper_bound(first, first + mesh_.piece_count, flat) - first - 1;
    return mesh_.pieces[piece].point(flat - first[piece]);
  }

  /// place_[v]: the lowest of the used vertices at v's place.
  void find_places() {
    place_.assign(std::size_t(mesh_.vertex_count()), -1);
    threads_.parallel_for(mesh_.cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
      for_each_cell(begin, end, [&](mesh::Shape, const std::int64_t* ids, int n) {
        for (int v = 0; v < n; ++v) // several cells store the same number
          std::atomic_ref(place_[std::size_t(ids[v])]).store(ids[v], std::memory_order_relaxed);
      });
    });
    std::vector<Place> places;
    places.reserve(place_.size());
    for (std::int64_t v = 0; v < mesh_.vertex_count(); ++v)
      if (place_[std::size_t(v)] == v)
        places.push_back({hash_of(point(v)), v});
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
      return a.hash != b.hash ? a.hash < b.hash : a.vertex < b.vertex;
    });
    std::vector<std::int64_t> distinct; // places of one hash: nearly always one
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i == 0 || places[i].hash != places[i - 1].hash)
        distinct.clear();
      const std::int64_t v = places[i].vertex;
      const auto same = std::find_if(distinct.begin(), distinct.end(),
                                     [&](std::int64_t d) { return point(d) == point(v); });
      if (same == distinct.end()) {
        distinct.push_back(v);
      } else {
        place_[std::size_t(v)] = *same;
        ++result_.coincident_vertices;
      }
    }
  }

  /// The face as its places have it; false if no area is left of it.
  bool key(const Face& face, const std::int64_t* ids, Face5& out) const {
    std::int64_t at[4];
    int n = 0;
    for (int k = 0; k < face.vertex_count; ++k) { // neighbours that coincide are one
      const std::int64_t p = place_[std::size_t(ids[face.vertices[k]])];
      if (n == 0 || at[n - 1] != p)
        at[n++] = p;
    }
    if (n > 1 && at[n - 1] == at[0])
      --n;
    if (n < 3 || (n == 4 && (at[0] == at[2] || at[1] == at[3])))
      return false;
    out = {at[0], at[1], at[2], n == 3 ? INT64_MAX : at[3], -1};
    for (const auto& [i, k] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}, {1, 2}})
      if (out[std::size_t(k)] < out[std::size_t(i)])
        std::swap(out[std::size_t(i)], out[std::size_t(k)]);
    if (n == 3)
      out[3] = -1;
    else
      out[4] = at[(std::find(at, at + 4, out[0]) - at + 2) % 4];
    return true;
  }

  template <class Visit>
  void for_each_face(Visit&& visit) const {
    for_each_cell(0, mesh_.cell_count(), [&](mesh::Shape shape, const std::int64_t* ids, int) {
      const FaceTable& table = table_of(shape);
      Face5 face;
      for (int f = 0; f < table.face_count; ++f)
        if (key(table.faces[f], ids, face))
          visit(face);
    });
  }

  /// All faces, by their lowest vertex: faces_[first_[v], first_[v + 1]).
  void sort_faces() {
    first_.assign(place_.size() + 1, 0);
    for_each_face([&](const Face5& f) { ++first_[std::size_t(f[0]) + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    faces_.resize(std::size_t(first_.back()));
    std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
    for_each_face([&](const Face5& f) {
      faces_[std::size_t(next[std::size_t(f[0])]++)] = {f[1], f[2], f[3], f[4]};
    });
    threads_.parallel_for(std::int64_t(place_.size()), grain,
                          [&](std::int64_t begin, std::int64_t end) {
                            for (std::int64_t v = begin; v < end; ++v)
                              std::sort(faces_.begin() + first_[std::size_t(v)],
                                        faces_.begin() + first_[std::size_t(v) + 1]);
                          });
  }

  /// Whether the triangle is a face of one cell alone.
  bool is_single_triangle(std::int64_t a, std::int64_t b, std::int64_t c) const {
    std::int64_t at[3] = {a, b, c};
    std::sort(at, at + 3);
    const auto begin = faces_.begin() + first_[std::size_t(at[0])],
               end = faces_.begin() + first_[std::size_t(at[0]) + 1];
    const auto [low, high] = std::equal_range(begin, end, Rest{at[1], at[2], -1, -1});
    return high - low == 1;
  }

  /// Whether two such triangles cover the quad, along either diagonal.
  bool meets_triangles(std::int64_t lowest, const Rest& quad) const {
    const std::int64_t opposite = quad[3];
    std::int64_t side[2];
    std::remove_copy(quad.begin(), quad.begin() + 3, side, opposite);
    return (is_single_triangle(lowest, side[0], opposite) &&
            is_single_triangle(lowest, side[1], opposite)) ||
           (is_single_triangle(lowest, side[0], side[1]) &&
            is_single_triangle(opposite, side[0], side[1]));
  }

  void count() {
    for (std::size_t v = 0; v + 1 < first_.size(); ++v) {
      const auto begin = faces_.begin() + first_[v], end = faces_.begin() + first_[v + 1];
      for (auto face = begin; face != end;) {
        const auto next = std::upper_bound(face, end, *face);
        result_.crowded_faces += next - face > 2;
        if (next - face == 1 && (*face)[2] >= 0) {
          // Corners in another order sort next to each other; the later counts.
          const bool turned =
              face != begin && std::equal(face->begin(), face->begin() + 3, (face - 1)->begin());
          result_.split_faces += turned || meets_triangles(std::int64_t(v), *face);
        }
        face = next;
      }
    }
  }

  const mesh::MeshView& mesh_;
  const core::Threads& threads_;
  std::vector<std::int64_t> place_, first_;
  std::vector<Rest> faces_; ///< without their lowest vertex
  Conformity result_;
};

} // namespace

Conformity check_conformity(const mesh::MeshView& mesh, const core::Threads& threads) {
  return Checker(mesh, threads).run();
}

} // namespace insitu::cells
