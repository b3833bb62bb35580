#pragma once

#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "fixtures/parts.h"
#include "part_of_mesh.h"
#include "threaded_world.h"

/// Parts of one whole mesh on processes that are threads, and what they answer.
namespace insitu::test {

inline TestMesh mesh_of(std::uint64_t seed, double jitter = 0.2) {
  MeshOptions options;
  options.size = 4;
  options.jitter = jitter;
  options.kind = MeshKind(seed % 6);
  return make_mesh(options, seed);
}

/// A process's part of a whole mesh, committed, with a field on vertices and one on cells.
struct Process : PartOfMesh<fixtures::Part> {
  Process(const TestMesh& whole, const fixtures::Partition& partition, parallel::World& world_,
          bool ids = true)
      : PartOfMesh(world_, whole, partition) {
    part.give(mesh.mesh(), ids);
    give_fields(whole, 1.0);
    commit();
  }
  void give_fields(const TestMesh& whole, double factor) {
    std::vector<double> of_cells, of_vertices;
    for (std::size_t c = 0; c < whole.cells.size(); ++c)
      of_cells.push_back(factor * double(c));
    for (const math::Vec3d& x : whole.vertices)
      of_vertices.insert(of_vertices.end(), {factor * std::sin(3 * x.x), x.y * x.z});
    part.give_field(mesh.mesh(), "cell", INSITU_CELL, 1, of_cells);
    part.give_field(mesh.mesh(), "vertex", INSITU_VERTEX, 2, of_vertices);
  }
  void commit() {
    mesh.commit(threads, log, memory, false);
    mesh.update_halo(world, threads, log);
  }
};

/// Vertices, middles of cells and of pairs of vertices, and points anywhere.
inline std::vector<math::Vec3d> hard_points(const TestMesh& mesh) {
  std::vector<math::Vec3d> points = mesh.vertices;
  for (const MeshCell& cell : mesh.cells) {
    const int n = mesh::vertex_count(cell.shape);
    const auto x = [&](int v) {
      return mesh.vertices[std::size_t(cell.vertices[std::size_t(v % n)])];
    };
    for (int v = 0; v < n; ++v)
      points.push_back(0.5 * (x(v) + x(v + 1)));
    points.push_back(0.25 * (x(0) + x(1) + x(2) + x(3)));
  }
  for (std::uint64_t i = 0; i < 300; ++i)
    points.push_back({4.4 * core::random_unit(3, i, 0) - 0.2,
                      4.4 * core::random_unit(3, i, 1) - 0.2,
                      4.4 * core::random_unit(3, i, 2) - 0.2});
  return points;
}

struct Answer {
  std::int64_t cell = -1;
  math::Vec3d parametric;
  double values[3] = {0, 0, 0};
};

inline Answer answer_of(const Process& p, const math::Vec3d& x, bool one_by_one,
                        const query::Location& found) {
  const query::Sampler sampler = p.mesh.sampler();
  const query::Location at = one_by_one ? sampler.locate(x) : found;
  Answer a;
  if (!at || !sampler.mesh().pieces[sampler.mesh().piece_of(at.cell)].owns(
                 at.cell - sampler.mesh().first_cell[sampler.mesh().piece_of(at.cell)]))
    return a;
  a.cell = p.mesh.name(at.cell).global;
  a.parametric = at.parametric;
  sampler.interpolate(p.mesh.mesh().field("cell"), at, a.values);
  sampler.interpolate(p.mesh.mesh().field("vertex"), at, a.values + 1);
  return a;
}

inline std::vector<Answer> answers_of(const Process& p, const std::vector<math::Vec3d>& points,
                                      bool batch) {
  std::vector<query::Location> found(points.size());
  if (batch)
    p.mesh.sampler().locate(p.threads, points, found);
  std::vector<Answer> all;
  for (std::size_t i = 0; i < points.size(); ++i)
    all.push_back(answer_of(p, points[i], !batch, found[i]));
  return all;
}

} // namespace insitu::test
