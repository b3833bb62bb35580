#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "accel/faces/mesh_faces.h"
#include "cells/kernels/faces.h"
#include "core/parallel.h"
#include "mesh/view.h"

/// The faces of each owning cell, before they are matched; for the tables of faces alone.
namespace insitu::accel {

namespace half_faces {

using Face = MeshFaces::Face;

inline constexpr cells::FaceTable tables[] = {
    cells::face_table(mesh::Shape::tetrahedron), cells::face_table(mesh::Shape::voxel),
    cells::face_table(mesh::Shape::hexahedron), cells::face_table(mesh::Shape::wedge),
    cells::face_table(mesh::Shape::pyramid)};

/// The cycle from its lowest vertex on.
inline void set_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, Face& out) {
  const std::uint32_t twice[] = {a, b, c, a, b};
  const int low = a < b ? (a < c ? 0 : 2) : (b < c ? 1 : 2);
  std::copy_n(twice + low, 3, out.vertices);
  out.vertices[3] = none;
}
inline void set_quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d,
                     Face& out) {
  const std::uint32_t twice[] = {a, b, c, d, a, b, c};
  const int low = std::min(a, b) < std::min(c, d) ? int(b < a) : 2 + int(d < c);
  std::copy_n(twice + low, 4, out.vertices);
}

/// With repeated vertices: neighbours that coincide are one; false if that leaves no area.
inline bool collapsed_quad(const std::uint32_t* v, Face& out) {
  std::uint32_t left[4];
  int m = 0;
  for (int k = 0; k < 4; ++k)
    if (m == 0 || left[m - 1] != v[k])
      left[m++] = v[k];
  m -= m > 1 && left[m - 1] == left[0];
  if (m != 3) // of four, two opposite ones coincide
    return false;
  set_triangle(left[0], left[1], left[2], out);
  return true;
}

/// A face by its flat vertices, the lowest first; false if repeated vertices leave no area of it.
inline bool half_face(const cells::Face& face, const std::uint32_t* ids, Face& out) {
  const auto& at = face.vertices;
  const std::uint32_t v[4] = {ids[at[0]], ids[at[1]], ids[at[2]], ids[at[3]]};
  bool distinct = (v[0] != v[1]) & (v[1] != v[2]) & (v[2] != v[0]);
  if (face.vertex_count == 3) {
    if (!distinct)
      return false;
    set_triangle(v[0], v[1], v[2], out);
    return true;
  }
  distinct &= (v[3] != v[0]) & (v[3] != v[1]) & (v[3] != v[2]);
  if (!distinct)
    return collapsed_quad(v, out);
  set_quad(v[0], v[1], v[2], v[3], out);
  return true;
}

/// Calls put(face, f) for the half faces f of the cells [begin, end) that exist, in their order.
template <class Put>
void for_each(const mesh::MeshView& mesh, std::int64_t begin, std::int64_t end, Put&& put) {
  std::int32_t piece = mesh.piece_of(begin);
  MeshFaces::Face face{{}, 0, none};
  for (std::int64_t flat = begin; flat < end; ++flat) {
    while (flat >= mesh.first_cell[piece + 1])
      ++piece;
    const mesh::PieceView& p = mesh.pieces[piece];
    const std::int64_t cell = flat - mesh.first_cell[piece];
    if (!p.exists(cell))
      continue;
    std::int64_t local[8];
    std::uint32_t ids[8];
    const int n = p.vertex_ids(cell, local);
    for (int v = 0; v < n; ++v)
      ids[v] = std::uint32_t(mesh.first_vertex[piece] + local[v]);
    face.cell = std::uint32_t(flat);
    const cells::FaceTable& table = tables[int(p.shape(cell)) - int(mesh::Shape::tetrahedron)];
    for (int f = 0; f < table.face_count; ++f)
      if (half_face(table.faces[f], ids, face))
        put(face, f);
  }
}

} // namespace half_faces

/// Half faces in buckets of lowest vertices, in the order of the cells, whatever the threads.
class HalfFaces {
public:
  HalfFaces(const mesh::MeshView& mesh, const core::Threads& threads)
      : mesh_(mesh), threads_(threads) {
    const std::int64_t cells = mesh.cell_count();
    const std::int64_t chunks = threads.count() == 1 ? 1 : 4 * threads.count();
    grain_ = std::max<std::int64_t>(16384, (cells + chunks - 1) / chunks);
    while (mesh.vertex_count() >> shift_ > 1024)
      ++shift_;
    buckets_ = std::size_t(mesh.vertex_count() >> shift_) + 1;
    next_.assign(std::size_t((cells + grain_ - 1) / grain_) * buckets_, 0);
    start_.resize(buckets_ + 1);
  }

  std::size_t buckets() const { return buckets_; }
  std::size_t start(std::size_t bucket) const { return start_[bucket]; }
  std::uint32_t first_vertex(std::size_t bucket) const { return std::uint32_t(bucket << shift_); }
  std::size_t vertices() const { return std::size_t(1) << shift_; } ///< of a bucket

  /// Their number; then fill() puts them to [start(b), start(b + 1)).
  std::size_t count() {
    for_each([](std::size_t& next, const Face&, int) { ++next; });
    std::size_t sum = 0;
    for (std::size_t b = 0; b < buckets_; ++b) {
      start_[b] = sum;
      for (std::size_t at = b; at < next_.size(); at += buckets_)
        sum += std::exchange(next_[at], sum);
    }
    return start_[buckets_] = sum;
  }
  /// record(face, f): what stands for face f of the cell; 'other' of it is `none`.
  template <class Record, class Make>
  void fill(Record* records, Make&& record) {
    for_each(
        [&](std::size_t& next, const Face& face, int f) { records[next++] = record(face, f); });
  }

private:
  using Face = MeshFaces::Face;

  template <class Put>
  void for_each(Put&& put) {
    threads_.parallel_for(mesh_.cell_count(), grain_, [&](std::int64_t begin, std::int64_t end) {
      std::size_t* next = &next_[std::size_t(begin / grain_) * buckets_];
      half_faces::for_each(mesh_, begin, end, [&](const Face& face, int f) {
        put(next[face.vertices[0] >> shift_], face, f);
      });
    });
  }

  const mesh::MeshView& mesh_;
  const core::Threads& threads_;
  std::int64_t grain_;
  int shift_ = 10; ///< a bucket's faces fit a core's cache
  std::size_t buckets_;
  std::vector<std::size_t> next_; ///< where a chunk's next face of a bucket goes
  std::vector<std::size_t> start_;
};

} // namespace insitu::accel
