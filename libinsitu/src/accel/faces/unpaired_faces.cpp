#include "accel/faces/unpaired_faces.h"

#include <algorithm>
#include <vector>

#include "accel/faces/half_faces.h"
#include "accel/locator.h"

namespace insitu::accel {

namespace {

/// The same triangle or the same cyclic quad from its other side; the lowest vertices are equal.
bool are_opposite(const FaceVertices& a, const FaceVertices& b) {
  const std::uint32_t *v = a.vertices, *w = b.vertices;
  if (v[3] == none || w[3] == none)
    return v[3] == w[3] && v[1] == w[2] && v[2] == w[1];
  return v[2] == w[2] && v[1] == w[3] && v[3] == w[1];
}

/// Cancels the faces whose lowest vertex is in one bucket; a thread's own.
class Canceller {
public:
  /// Leaves the faces that stay at the front, and returns their number. Their lowest vertices are
  /// from `first` on.
  std::size_t cancel(FaceVertices* faces, std::size_t n, std::uint32_t first,
                     std::size_t vertices) {
    head_.assign(vertices, none);
    next_.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      std::uint32_t* link = &head_[faces[i].vertices[0] - first];
      std::uint32_t* const head = link;
      while (*link != none && !are_opposite(faces[*link], faces[i]))
        link = &next_[*link];
      if (*link != none) {
        faces[*link].vertices[0] = faces[i].vertices[0] = none;
        *link = next_[*link];
      } else {
        next_[i] = *head;
        *head = i;
      }
    }
    return std::size_t(std::remove_if(faces, faces + n,
                                      [](const FaceVertices& f) { return f.vertices[0] == none; }) -
                       faces);
  }

private:
  std::vector<std::uint32_t> head_, next_; ///< chains of faces with the same lowest vertex
};

} // namespace

bool can_pair_faces(const mesh::MeshView& mesh) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    if (!mesh.pieces[p].shares_vertices())
      return false;
  return mesh.cell_count() < std::int64_t(none) && mesh.vertex_count() < std::int64_t(none);
}

void find_unpaired_faces(const mesh::MeshView& mesh, const core::Threads& threads,
                         core::Memory& memory, core::Buffer<FaceVertices>& out) {
  HalfFaces half(mesh, threads);
  core::Buffer<FaceVertices> all(memory, INSITU_MEMORY_BUILD);
  all.resize_discard(half.count());
  half.fill(all.data(), [](const MeshFaces::Face& face, int) {
    FaceVertices f;
    std::copy_n(face.vertices, 4, f.vertices);
    return f;
  });
  std::vector<std::size_t> left(half.buckets());
  threads.parallel_for(std::int64_t(half.buckets()), 8, [&](std::int64_t begin, std::int64_t end) {
    Canceller canceller;
    for (auto b = std::size_t(begin); b < std::size_t(end); ++b)
      left[b] = canceller.cancel(all.data() + half.start(b), half.start(b + 1) - half.start(b),
                                 half.first_vertex(b), half.vertices());
  });
  std::size_t sum = 0;
  for (const std::size_t n : left)
    sum += n;
  out.resize_discard(sum);
  FaceVertices* to = out.data();
  for (std::size_t b = 0; b < left.size(); ++b)
    to = std::copy_n(all.data() + half.start(b), left[b], to);
}

} // namespace insitu::accel
