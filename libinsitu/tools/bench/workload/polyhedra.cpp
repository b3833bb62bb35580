#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "cells/kernels/faces.h"
#include "core/random.h"
#include "workload/mesh.h"

namespace insitu::workload {

namespace {

using Corner = std::array<int, 3>;

/// The faces of a truncated octahedron, as rings of corners about its centre: six squares, then
/// eight hexagons.
std::vector<std::vector<Corner>> rings_of_octahedron() {
  std::vector<std::vector<Corner>> rings;
  for (int a = 0; a < 3; ++a)
    for (const int side : {-2, 2}) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      std::vector<Corner>& ring = rings.emplace_back();
      for (const auto& [u, v] : {std::array{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
        Corner x{};
        x[std::size_t(a)] = side;
        x[std::size_t(b)] = u;
        x[std::size_t(c)] = v;
        ring.push_back(x);
      }
    }
  for (int k = 0; k < 8; ++k) {
    std::vector<Corner>& ring = rings.emplace_back();
    for (const Corner& x : std::initializer_list<Corner>{
             {0, 1, 2}, {1, 0, 2}, {2, 0, 1}, {2, 1, 0}, {1, 2, 0}, {0, 2, 1}})
      ring.push_back({k & 1 ? -x[0] : x[0], k & 2 ? -x[1] : x[1], k & 4 ? -x[2] : x[2]});
  }
  return rings;
}

} // namespace

/// Truncated octahedra about the points of a body-centred lattice, four units a cube.
Mesh make_octahedra(int n, double jitter) {
  Mesh mesh;
  mesh.cell_size = 1.0 / n;
  mesh.smallest_edge = std::sqrt(2.0) / (4.0 * n);
  mesh.face_offsets.push_back(0);
  mesh.cell_offsets.push_back(0);
  const std::uint64_t side = std::uint64_t(4 * n + 1); // coordinates from -2 to 4 n - 2
  std::unordered_map<std::uint64_t, std::int32_t> vertices, faces;
  const auto key = [&](const Corner& x) {
    return (std::uint64_t(x[0] + 2) * side + std::uint64_t(x[1] + 2)) * side +
           std::uint64_t(x[2] + 2);
  };
  const auto vertex = [&](const Corner& x) {
    const auto [at, fresh] = vertices.emplace(key(x), std::int32_t(mesh.vertex_count()));
    for (std::size_t a = 0; fresh && a < 3; ++a)
      mesh.points.push_back(
          (x[a] + 2 + jitter * (2 * core::random_unit(1, key(x), std::uint64_t(a)) - 1)) /
          (4.0 * n));
    return at->second;
  };
  const auto rings = rings_of_octahedron();
  const auto add = [&](const Corner& centre) {
    for (const auto& ring : rings) {
      Corner middle{}; // of the face, twice: its key
      for (const Corner& x : ring)
        for (std::size_t a = 0; a < 3; ++a)
          middle[a] += x[a];
      std::uint64_t face = 0;
      for (std::size_t a = 0; a < 3; ++a)
        face =
            face * (4 * side) + std::uint64_t(2 * centre[a] + 2 * middle[a] / int(ring.size()) + 8);
      const auto [at, fresh] = faces.emplace(face, std::int32_t(mesh.face_offsets.size()) - 1);
      for (std::size_t k = 0; fresh && k < ring.size(); ++k)
        mesh.face_vertices.push_back(
            vertex({centre[0] + ring[k][0], centre[1] + ring[k][1], centre[2] + ring[k][2]}));
      if (fresh)
        mesh.face_offsets.push_back(std::int64_t(mesh.face_vertices.size()));
      mesh.cell_faces.push_back(at->second);
    }
    mesh.cell_offsets.push_back(std::int64_t(mesh.cell_faces.size()));
  };
  for (const int shift : {0, 2})
    for (int k = 0; k < (shift ? n - 1 : n); ++k)
      for (int j = 0; j < (shift ? n - 1 : n); ++j)
        for (int i = 0; i < (shift ? n - 1 : n); ++i)
          add({4 * i + shift, 4 * j + shift, 4 * k + shift});
  return mesh;
}

Mesh by_faces(Mesh mesh) {
  std::map<std::array<std::int32_t, 4>, std::int32_t> known; // by their vertices, ascending
  mesh.face_offsets.push_back(0);
  std::vector<std::int64_t> cell_offsets{0};
  for (std::int64_t c = 0; c < mesh.cell_count(); ++c) {
    const cells::FaceTable table = cells::face_table(mesh.shape(c));
    for (int f = 0; f < table.face_count; ++f) {
      std::array<std::int32_t, 4> ring{}, key{};
      const auto count = std::size_t(table.faces[f].vertex_count);
      for (std::size_t v = 0; v < count; ++v)
        ring[v] = mesh.ids(c)[table.faces[f].vertices[v]];
      key = ring;
      if (count == 3)
        key[3] = -1;
      std::ranges::sort(key);
      const auto [at, fresh] = known.emplace(key, std::int32_t(mesh.face_offsets.size()) - 1);
      if (fresh) {
        mesh.face_vertices.insert(mesh.face_vertices.end(), ring.begin(),
                                  ring.begin() + std::ptrdiff_t(count));
        mesh.face_offsets.push_back(std::int64_t(mesh.face_vertices.size()));
      }
      mesh.cell_faces.push_back(at->second);
    }
    cell_offsets.push_back(std::int64_t(mesh.cell_faces.size()));
  }
  mesh.cell_offsets = std::move(cell_offsets);
  mesh.connectivity.clear();
  mesh.types.clear();
  mesh.offsets.clear();
  mesh.uniform_shape = mesh::Shape::none;
  return mesh;
}

} // namespace insitu::workload
