#include "accel/faces/mesh_faces.h"

#include <algorithm>
#include <atomic>
#include <vector>

#include "accel/faces/half_faces.h"
#include "cells/kernels/faces.h"
#include "core/status.h"

namespace insitu::accel {

namespace {

using Face = MeshFaces::Face;

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

} // namespace

MeshFaces::MeshFaces(core::Memory& memory) : memory_(&memory), faces_(memory, INSITU_MEMORY_TREE) {}

void MeshFaces::build(const mesh::MeshView& mesh, const core::Threads& threads) {
  faces_.release();
  boundary_ = crowded_ = turned_ = split_ = 0;
  if (mesh.vertex_count() > std::int64_t(none))
    throw core::Error(INSITU_ERROR_MESH, "face methods: more than 2^32 - 1 vertices");
  HalfFaces half(mesh, threads);
  core::Buffer<Face> unmatched(*memory_, INSITU_MEMORY_BUILD);
  unmatched.resize_discard(half.count());
  half.fill(unmatched.data(), [](const Face& face, int) { return face; });
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

std::int64_t MeshFaces::most_bytes_while_built(const mesh::MeshView& mesh,
                                               const core::Threads& threads) {
  std::atomic<std::int64_t> halves{0};
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    threads.parallel_for(mesh.first_cell[p + 1] - mesh.first_cell[p], 4096,
                         [&](std::int64_t begin, std::int64_t end) {
                           std::int64_t sum = 0;
                           for (std::int64_t cell = begin; cell < end; ++cell)
                             sum += piece.exists(cell)
                                        ? cells::face_table(piece.shape(cell)).face_count
                                        : 0;
                           halves += sum;
                         });
  }
  return 2 * halves * std::int64_t(sizeof(Face)); // all of them unmatched, at most
}

} // namespace insitu::accel
