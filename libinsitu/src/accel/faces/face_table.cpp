#include "accel/faces/face_table.h"

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

#include "cells/faces.h"
#include "core/status.h"

namespace insitu::accel {

namespace {

using Face = FaceTable::Face;

constexpr cells::FaceTable tables[] = {
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
bool collapsed_quad(const std::uint32_t* v, Face& out) {
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

/// The same triangle or the same cyclic quad; the lowest vertices are equal.
bool is_same(const Face& a, const Face& b) {
  const std::uint32_t *v = a.vertices, *w = b.vertices;
  if (v[3] == none || w[3] == none)
    return v[3] == w[3] && ((v[1] == w[1] && v[2] == w[2]) || (v[1] == w[2] && v[2] == w[1]));
  return v[2] == w[2] && ((v[1] == w[1] && v[3] == w[3]) || (v[1] == w[3] && v[3] == w[1]));
}

bool has_vertex(const Face& f, std::uint32_t v) {
  return std::find(f.vertices, f.vertices + 4, v) != f.vertices + 4;
}

/// Whether all vertices of b are the quad's.
bool covers(const Face& quad, const Face& b) {
  return has_vertex(quad, b.vertices[1]) && has_vertex(quad, b.vertices[2]) &&
         (b.vertices[3] == none || has_vertex(quad, b.vertices[3]));
}

struct Counts {
  std::int64_t faces = 0, boundary = 0, crowded = 0, turned = 0, split = 0;
};

/// Matches the faces of cells whose lowest vertex is in one bucket, in place.
class Bucket {
public:
  /// Faces of the cells in order; their vertices are from `first` on. The matched faces are left at
  /// the front.
  Counts match(Face* faces, std::size_t n, std::uint32_t first, std::size_t vertices) {
    faces_ = faces;
    first_ = first;
    head_.assign(vertices, none);
    next_.resize(n);
    rank_.resize(n);
    Counts counts;
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Face face = faces[i];
      std::uint32_t& head = head_[face.vertices[0] - first];
      std::uint32_t same = head;
      while (same != none && !is_same(faces[same], face))
        same = next_[same];
      if (same != none && rank_[same] == alone) {
        faces[same].other = face.cell;
        counts.turned += faces[same].vertices[1] == face.vertices[1];
        rank_[same] = paired;
        continue;
      }
      faces[count] = face;
      if (same != none) {
        counts.crowded += rank_[same] == paired;
        rank_[same] = crowd;
        rank_[count] = further;
      } else {
        rank_[count] = alone;
        next_[count] = head;
        head = count;
      }
      ++count;
    }
    counts.faces = count;
    for (std::uint32_t i = 0; i < count; ++i) {
      counts.boundary += rank_[i] == alone;
      counts.split += rank_[i] == alone && faces[i].vertices[3] != none && meets_others(i);
    }
    return counts;
  }

private:
  enum Rank : std::uint8_t { alone, paired, crowd, further };

  /// Whether the quad, of one cell alone, meets such a triangle or its corners in another order.
  bool meets_others(std::uint32_t quad) const {
    for (std::uint32_t k = head_[faces_[quad].vertices[0] - first_]; k != none; k = next_[k])
      if (k != quad && rank_[k] == alone && covers(faces_[quad], faces_[k]))
        return true;
    return false;
  }

  Face* faces_ = nullptr;
  std::uint32_t first_ = 0;
  std::vector<std::uint32_t> head_, next_; ///< chains of faces with the same lowest vertex
  std::vector<std::uint8_t> rank_;
};

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
    for_each([](std::size_t& next, const Face&) { ++next; });
    std::size_t sum = 0;
    for (std::size_t b = 0; b < buckets_; ++b) {
      start_[b] = sum;
      for (std::size_t at = b; at < next_.size(); at += buckets_)
        sum += std::exchange(next_[at], sum);
    }
    return start_[buckets_] = sum;
  }
  void fill(Face* faces) {
    for_each([faces](std::size_t& next, const Face& face) { faces[next++] = face; });
  }

private:
  template <class Put>
  void for_each(Put&& put) {
    threads_.parallel_for(mesh_.cell_count(), grain_, [&](std::int64_t begin, std::int64_t end) {
      std::size_t* next = &next_[std::size_t(begin / grain_) * buckets_];
      std::int32_t piece = mesh_.piece_of(begin);
      Face face{{}, 0, none};
      for (std::int64_t flat = begin; flat < end; ++flat) {
        while (flat >= mesh_.first_cell[piece + 1])
          ++piece;
        const mesh::PieceView& p = mesh_.pieces[piece];
        const std::int64_t cell = flat - mesh_.first_cell[piece];
        if (!p.owns(cell))
          continue;
        std::int64_t local[8];
        std::uint32_t ids[8];
        const int n = p.vertex_ids(cell, local);
        for (int v = 0; v < n; ++v)
          ids[v] = std::uint32_t(mesh_.first_vertex[piece] + local[v]);
        face.cell = std::uint32_t(flat);
        const cells::FaceTable& table = tables[int(p.shape(cell)) - int(mesh::Shape::tetrahedron)];
        for (int f = 0; f < table.face_count; ++f)
          if (half_face(table.faces[f], ids, face))
            put(next[face.vertices[0] >> shift_], face);
      }
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

} // namespace

FaceTable::FaceTable(core::Memory& memory) : memory_(&memory), faces_(memory, INSITU_MEMORY_TREE) {}

void FaceTable::build(const mesh::MeshView& mesh, const core::Threads& threads) {
  faces_.release();
  boundary_ = crowded_ = turned_ = split_ = 0;
  if (mesh.vertex_count() > std::int64_t(none))
    throw core::Error(INSITU_ERROR_MESH, "face methods: more than 2^32 - 1 vertices");
  HalfFaces half(mesh, threads);
  core::Buffer<Face> unmatched(*memory_, INSITU_MEMORY_BUILD);
  unmatched.resize_discard(half.count());
  half.fill(unmatched.data());
  std::vector<Counts> counts(half.buckets());
  threads.parallel_for(std::int64_t(half.buckets()), 8, [&](std::int64_t begin, std::int64_t end) {
    Bucket bucket;
    for (auto b = std::size_t(begin); b < std::size_t(end); ++b)
      counts[b] = bucket.match(unmatched.data() + half.start(b), half.start(b + 1) - half.start(b),
                               half.first_vertex(b), half.vertices());
  });
  std::vector<std::size_t> to(counts.size());
  std::size_t sum = 0;
  for (std::size_t b = 0; b < counts.size(); ++b) {
    to[b] = sum;
    sum += std::size_t(counts[b].faces);
    boundary_ += counts[b].boundary;
    crowded_ += counts[b].crowded;
    turned_ += counts[b].turned;
    split_ += counts[b].split;
  }
  faces_.resize_discard(sum);
  threads.parallel_for(std::int64_t(counts.size()), 64, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = std::size_t(begin); b < std::size_t(end); ++b)
      std::copy_n(unmatched.data() + half.start(b), counts[b].faces, faces_.data() + to[b]);
  });
}

std::int64_t FaceTable::most_bytes_while_built(const mesh::MeshView& mesh,
                                               const core::Threads& threads) {
  std::atomic<std::int64_t> halves{0};
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    threads.parallel_for(mesh.first_cell[p + 1] - mesh.first_cell[p], 4096,
                         [&](std::int64_t begin, std::int64_t end) {
                           std::int64_t sum = 0;
                           for (std::int64_t cell = begin; cell < end; ++cell)
                             sum += piece.owns(cell)
                                        ? cells::face_table(piece.shape(cell)).face_count
                                        : 0;
                           halves += sum;
                         });
  }
  return 2 * halves * std::int64_t(sizeof(Face)); // all of them unmatched, at most
}

} // namespace insitu::accel
