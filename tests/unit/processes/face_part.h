#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "fixtures/polyhedra.h"
#include "mesh/registered/mesh.h"
#include "part_fields.h"

/// Meshes whose cells are given by faces, over processes.
namespace insitu::test {

using fixtures::FaceMesh;

/// How the cells of a mesh are dealt to processes.
struct FaceDeal {
  enum Kind { slabs, turns, empty_root };
  int processes = 1;
  Kind kind = slabs;   ///< along x, or one after the other, to all processes or to all but the root
  bool ghosts = false; ///< whether processes have others' cells that touch their own, too

  /// Of each cell, its process.
  std::vector<int> of(const fixtures::FaceMesh& mesh) const {
    std::vector<int> process;
    double low = 1e300, high = -1e300;
    for (const Vec3d& x : mesh.vertices) {
      low = std::min(low, x.x);
      high = std::max(high, x.x);
    }
    for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
      const int face = mesh.cells[cell][0];
      const Vec3d& x = mesh.vertices[std::size_t(mesh.faces[std::size_t(face)][0])];
      const int slab = std::min(processes - 1, int(processes * (x.x - low) / (high - low)));
      process.push_back(kind == slabs   ? slab
                        : kind == turns ? int(cell) % processes
                                        : 1 + int(cell) % (processes - 1));
    }
    return process;
  }
  std::string name() const {
    const char* const kinds[] = {"slabs", "by turns", "empty root"};
    return kinds[kind] + std::string(ghosts ? " with ghosts on " : " on ") +
           std::to_string(processes);
  }
};

/// The cells of a mesh that a process has, in their order, with vertices in another order.
struct FacePart {
  std::vector<int> vertices; ///< of the whole, by local id
  std::vector<std::int64_t> cells, global_vertices;
  std::vector<std::uint8_t> bits; ///< [cell], or empty; ghosts come behind the others
  FaceMesh mesh;
  PartFields fields;
  fixtures::FaceArrays<> arrays;

  /// The cells of a process, and behind them those of others that share a vertex with them.
  static std::vector<std::int64_t> cells_of(const FaceMesh& whole, const FaceDeal& deal, int rank) {
    const std::vector<int> process = deal.of(whole);
    std::vector<std::int64_t> own, ghosts;
    std::set<int> mine;
    const auto each_vertex = [&](std::size_t cell, auto&& visit) {
      for (const int f : whole.cells[cell])
        for (const int v : whole.faces[std::size_t(f)])
          visit(v);
    };
    for (std::size_t cell = 0; cell < whole.cells.size(); ++cell)
      if (process[cell] == rank) {
        own.push_back(std::int64_t(cell));
        each_vertex(cell, [&](int v) { mine.insert(v); });
      }
    for (std::size_t cell = 0; deal.ghosts && cell < whole.cells.size(); ++cell) {
      bool touches = false;
      each_vertex(cell, [&](int v) { touches = touches || mine.contains(v); });
      if (touches && process[cell] != rank)
        ghosts.push_back(std::int64_t(cell));
    }
    own.insert(own.end(), ghosts.begin(), ghosts.end());
    return own;
  }

  static FaceMesh cut(const FaceMesh& whole, int rank, const std::vector<std::int64_t>& cells,
                      std::vector<int>& vertices) {
    FaceMesh out;
    std::map<int, int> local;
    for (auto cell = cells.rbegin(); cell != cells.rend(); ++cell) // numbers as they come
      for (const int f : whole.cells[std::size_t(*cell)])
        for (const int v : whole.faces[std::size_t(f)])
          if (local.emplace(v, int(vertices.size())).second)
            vertices.push_back(v);
    for (const int v : vertices)
      out.vertices.push_back(whole.vertices[std::size_t(v)]);
    for (const std::int64_t cell : cells) {
      std::vector<FaceMesh::Ring> rings;
      for (const int f : whole.cells[std::size_t(cell)]) {
        FaceMesh::Ring ring;
        for (const int v : whole.faces[std::size_t(f)])
          ring.push_back(local.at(v));
        std::ranges::rotate(ring, ring.begin() + rank % int(ring.size()));
        rings.insert(rank % 2 ? rings.begin() : rings.end(), ring);
      }
      out.add_cell(rings);
    }
    return out;
  }

  FacePart(const FaceMesh& whole, const FaceDeal& deal, int rank)
      : cells(cells_of(whole, deal, rank)), mesh(cut(whole, rank, cells, vertices)), arrays(mesh) {
    global_vertices.assign(vertices.begin(), vertices.end());
    const std::vector<int> process = deal.of(whole);
    for (std::size_t i = 0; deal.ghosts && i < cells.size(); ++i)
      bits.push_back(process[std::size_t(cells[i])] != rank); // VTK's DUPLICATECELL
  }
  bool empty() const { return cells.empty(); }
  void give(mesh::Mesh& to) {
    const insitu_array points_array = arrays.point_array();
    const insitu_faces faces = arrays.by_owner();
    to.set_points(0, &points_array, 1);
    to.set_faces(0, &faces);
    insitu_array ids = insitu_array_of(cells.data(), INSITU_INT64, std::int64_t(cells.size()), 1);
    to.set_global_ids(0, INSITU_CELL, &ids);
    ids = insitu_array_of(global_vertices.data(), INSITU_INT64,
                          std::int64_t(global_vertices.size()), 1);
    to.set_global_ids(0, INSITU_VERTEX, &ids);
    const insitu_array ghosts =
        insitu_array_of(bits.data(), INSITU_UINT8, std::int64_t(bits.size()), 1);
    to.set_ghosts(0, bits.empty() ? nullptr : &ghosts, INSITU_GHOSTS_VTK);
  }
  /// The vertices to where they are after so many steps.
  void move(mesh::Mesh& to, int steps) {
    for (std::size_t i = 0; i < arrays.points.size(); ++i) {
      double& x = arrays.points[i] = mesh.vertices[i / 3][int(i % 3)];
      for (int step = 0; step < steps; ++step)
        x += 0.02 * std::sin(x);
    }
    to.set_changed(INSITU_CHANGED_GEOMETRY);
  }
  void give_fields(mesh::Mesh& to, double t) {
    fields.begin(cells, t);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const Vec3d x{arrays.points[3 * v], arrays.points[3 * v + 1], arrays.points[3 * v + 2]};
      fields.p.push_back(std::sin(3 * x.x + t) + x.y * x.z);
      fields.u.insert(fields.u.end(), {-x.y, x.x, 0.1 * std::cos(t)});
    }
    fields.give(to, 0);
  }
};

} // namespace insitu::test
