#include "render/surface/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "accel/faces/mesh_faces.h"
#include "accel/tree/tree.h"
#include "cells/kernels/faces.h"
#include "mesh/box.h"
#include "mesh/piece_borders.h"
#include "render/surface/leaf_faces.h"

namespace insitu::render {

namespace {

using accel::none;
using math::Vec3d;
using Face = accel::MeshFaces::Face;

bool lower(const Vec3d& a, const Vec3d& b) {
  if (a.x != b.x)
    return a.x < b.x;
  return a.y != b.y ? a.y < b.y : a.z < b.z;
}
bool same(const Vec3d& a, const Vec3d& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

/// A face's corners, the lowest first.
struct Corners {
  std::array<Vec3d, 4> x;
  int count;

  friend bool operator<(const Corners& a, const Corners& b) {
    if (a.count != b.count)
      return a.count < b.count;
    for (std::size_t k = 0; k < std::size_t(a.count); ++k)
      if (!same(a.x[k], b.x[k]))
        return lower(a.x[k], b.x[k]);
    return false;
  }
};

int corner_count(const Face& face) {
  return face.vertices[3] == none ? 3 : 4;
}

void corners(const mesh::MeshView& mesh, const Face& face, Vec3d* x) {
  const std::int32_t piece = mesh.piece_of(face.cell);
  for (int k = 0; k < corner_count(face); ++k)
    x[k] = mesh.pieces[piece].point(std::int64_t(face.vertices[k]) - mesh.first_vertex[piece]);
}

/// A vertex is looked for where the solver has it, though it may be a copy's.
class SolversPlaces {
public:
  SolversPlaces(const mesh::MeshView& mesh, const ChartCopies* copies) : mesh_(mesh) {
    if (!copies)
      return;
    std::size_t at = 0;
    for (const std::int64_t end : copies->joined.end)
      for (const std::size_t first = at; at < std::size_t(end); ++at)
        first_of_.emplace_back(copies->joined.flat[at], copies->joined.flat[first]);
    std::sort(first_of_.begin(), first_of_.end());
  }
  Vec3d operator()(std::int64_t vertex) const {
    const auto at = std::ranges::lower_bound(first_of_, vertex, {}, &Pair::first);
    if (at != first_of_.end() && at->first == vertex)
      vertex = at->second;
    const std::int32_t piece = mesh::piece_of_vertex(mesh_, vertex);
    return mesh_.pieces[piece].point(vertex - mesh_.first_vertex[piece]);
  }

private:
  using Pair = std::pair<std::int64_t, std::int64_t>;
  const mesh::MeshView& mesh_;
  std::vector<Pair> first_of_; ///< ascending
};

/// Whether cells that touch may number their vertices apart, so that their faces meet by places.
bool has_faces_apart(const mesh::MeshView& mesh) {
  return mesh.piece_count > 1 ||
         std::any_of(mesh.pieces, mesh.pieces + mesh.piece_count,
                     [](const mesh::PieceView& piece) { return !piece.shares_vertices(); });
}

/// Removes faces with the same corners as another cell's: those of neighbouring pieces, or
/// gridlets, whose vertices are numbered apart, and of copies.
void remove_pairs(const mesh::MeshView& mesh, const ChartCopies* copies,
                  core::CountedVector<Face>& faces, const core::Threads& threads) {
  const SolversPlaces places(mesh, copies);
  core::CountedVector<Corners> keys(faces.size(), faces.get_allocator());
  threads.parallel_for(std::int64_t(faces.size()), 1024, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
      keys[i].count = corner_count(faces[i]);
      for (int k = 0; k < keys[i].count; ++k)
        keys[i].x[std::size_t(k)] = places(faces[i].vertices[k]);
      std::sort(keys[i].x.begin(), keys[i].x.begin() + keys[i].count, lower);
    }
  });
  core::CountedVector<std::uint32_t> order(faces.size(), faces.get_allocator());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (keys[a] < keys[b] || keys[b] < keys[a])
      return keys[a] < keys[b];
    return a < b;
  });
  /// Of two copies the first.
  const auto cell_of = [&](std::uint32_t i) {
    const std::int64_t cell = faces[i].cell;
    return copies && copies->is_second(cell) ? cell - 1 : cell;
  };
  std::vector<bool> gone(faces.size(), false);
  for (std::size_t i = 0, end = 0; i < order.size(); i = end) {
    bool of_one_cell = true;
    for (end = i + 1; end < order.size() && !(keys[order[i]] < keys[order[end]]); ++end)
      of_one_cell = of_one_cell && copies && cell_of(order[end]) == cell_of(order[i]);
    for (std::size_t k = i; k < end && !of_one_cell; ++k)
      gone[order[k]] = true;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (!gone[i])
      faces[kept++] = faces[i];
  faces.resize(kept);
}

} // namespace

TriangleMesh::TriangleMesh(core::Memory& memory)
    : memory_(&memory), points_(memory, INSITU_MEMORY_FRAME),
      triangles_(memory, INSITU_MEMORY_FRAME), vertices_(memory, INSITU_MEMORY_FRAME),
      cells_(memory, INSITU_MEMORY_FRAME) {}

std::unique_ptr<TriangleMesh> TriangleMesh::boundary(const mesh::MeshView& mesh,
                                                     const mesh::Box& bounds,
                                                     const ChartCopies* copies,
                                                     const core::Threads& threads,
                                                     core::Memory& memory) {
  const core::CountedAllocator<Face> counted(memory, INSITU_MEMORY_FRAME);
  core::CountedVector<Face> faces(counted);
  {
    accel::MeshFaces table(memory);
    table.build(mesh, threads);
    faces.reserve(std::size_t(table.boundary_faces()));
    for (const Face& face : table.faces())
      if (face.other == none && mesh.pieces[mesh.piece_of(face.cell)].pole == 0)
        faces.push_back(face);
  }
  if (has_leaf_faces(mesh))
    remove_faces_inside(mesh, faces);
  else if (has_faces_apart(mesh))
    remove_pairs(mesh, copies, faces, threads);
  std::erase_if(faces, [&](const Face& face) { return !mesh.is_own(face.cell); });

  std::unique_ptr<TriangleMesh> out(new TriangleMesh(memory));
  core::CountedVector<std::uint32_t> ids(counted);
  ids.reserve(4 * faces.size());
  for (const Face& face : faces)
    ids.insert(ids.end(), face.vertices, face.vertices + corner_count(face));
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  out->vertices_.resize_discard(ids.size());
  std::copy(ids.begin(), ids.end(), out->vertices_.begin());
  out->points_.resize_discard(ids.size());
  const auto place = [&](std::uint32_t id) {
    return std::uint32_t(std::lower_bound(ids.begin(), ids.end(), id) - ids.begin());
  };
  for (const Face& face : faces) {
    Vec3d x[4];
    corners(mesh, face, x);
    std::uint32_t at[4];
    const int count = corner_count(face);
    for (int k = 0; k < count; ++k) {
      at[k] = place(face.vertices[k]);
      out->points_[at[k]] = x[k];
    }
    if (count == 3) { // from the lowest corner on, so that roundings do not hang on numbers
      const auto first = std::size_t(std::min_element(x, x + 3, lower) - x);
      out->triangles_.push_back({at[first], at[(first + 1) % 3], at[(first + 2) % 3]});
    } else {
      const cells::Quad q = cells::canonical_order(cells::Face{4, {0, 1, 2, 3}}, x);
      const auto& v = q.vertices;
      out->triangles_.push_back({at[v[0]], at[v[1]], at[v[2]]});
      out->triangles_.push_back({at[v[0]], at[v[2]], at[v[3]]});
      out->cells_.push_back(face.cell);
    }
    out->cells_.push_back(face.cell);
  }
  out->bounds_ = bounds;
  out->build(threads, &out->bounds_);
  return out;
}

std::unique_ptr<TriangleMesh>
TriangleMesh::body(const TriangleList& list, const core::Threads& threads, core::Memory& memory) {
  std::unique_ptr<TriangleMesh> out(new TriangleMesh(memory));
  out->points_.resize_discard(list.corners.size());
  std::copy(list.corners.begin(), list.corners.end(), out->points_.begin());
  out->triangles_.resize_discard(list.corners.size() / 3);
  for (std::uint32_t i = 0; i < out->triangles_.size(); ++i)
    out->triangles_[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  out->build(threads, nullptr);
  return out;
}

void TriangleMesh::build(const core::Threads& threads, const mesh::Box* bounds) {
  triangles_.shrink();
  cells_.shrink();
  rays_ = std::make_unique<accel::TriangleRays>(points_.span(), triangles_.span(), bounds, threads,
                                                *memory_);
}

namespace {

/// Of Embree's triangles for rays: vertices as floats, and what its tree takes, as measured (four
/// triangles to a block of indices, in nodes of four or eight children).
constexpr double embree_vertex = 3 * sizeof(float), embree_triangle = 50, embree_scene = 2048;

} // namespace

std::int64_t TriangleMesh::bytes_about(std::int64_t triangles) {
  const double each =
      3 * (sizeof(Vec3d) + embree_vertex) + sizeof(accel::TriangleRays::Ids) + embree_triangle;
  return std::int64_t(embree_scene + each * double(triangles));
}

std::int64_t TriangleMesh::bytes_about(const query::Sampler& sampler) {
  const accel::Tree& tree = sampler.tree();
  const mesh::MeshView& mesh = sampler.mesh();
  if (tree.empty())
    return 0;
  // Cells as if they were hexahedra, with the proportions of mean boxes.
  constexpr std::int64_t most = 1024;
  const std::int64_t items = tree.cell_count(), count = std::min(items, most);
  double hexahedra = 0;
  Vec3d mean;
  mesh::CellVertices cell;
  for (std::int64_t i = 0; i < count; ++i) {
    mesh::gather(mesh, tree.cells()[i * items / count], cell);
    mean += mesh::box_of(cell).size();
    hexahedra += cell.shape == mesh::Shape::wedge         ? 1.0 / 2
                 : cell.shape == mesh::Shape::tetrahedron ? 1.0 / 6
                 : cell.shape == mesh::Shape::pyramid     ? 1.0 / 6
                                                          : 1.0;
  }
  hexahedra *= double(items) / double(count);
  const Vec3d extent = tree.bounds_max() - tree.bounds_min();
  double across[3], product = 1;
  for (int a = 0; a < 3; ++a) {
    across[a] = mean[a] > 0 ? std::max(1.0, extent[a] / (mean[a] / double(count))) : 1.0;
    product *= across[a];
  }
  const double scale = std::cbrt(hexahedra / product);
  double faces = 0;
  for (int a = 0; a < 3; ++a)
    faces += 2 * std::max(1.0, scale * across[a]) * std::max(1.0, scale * across[(a + 1) % 3]);
  const double vertex = sizeof(Vec3d) + sizeof(std::uint32_t) + embree_vertex;
  const double each = sizeof(accel::TriangleRays::Ids) + sizeof(std::uint32_t) + embree_triangle;
  return std::int64_t(embree_scene + faces * (vertex + 2 * each));
}

std::int64_t TriangleMesh::most_bytes_while_made(const mesh::MeshView& mesh,
                                                 const core::Threads& threads) {
  // What is taken from the table is no more than it held, but for what finds faces by places.
  return (has_faces_apart(mesh) ? 3 : 1) * accel::MeshFaces::most_bytes_while_built(mesh, threads);
}

std::int64_t TriangleMesh::bytes() const {
  return std::int64_t(points_.bytes() + triangles_.bytes() + vertices_.bytes() + cells_.bytes()) +
         rays_->bytes();
}

} // namespace insitu::render
