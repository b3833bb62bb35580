#include "accel/faces/unpaired_faces.h"

#include <algorithm>
#include <vector>

#include "accel/faces/half_faces.h"
#include "accel/locator.h"

namespace insitu::accel {

namespace {

using Faces = core::Buffer<FaceVertices>;

/// The same triangle or the same cyclic quad from its other side; the lowest vertices are equal.
bool are_opposite(const FaceVertices& a, const FaceVertices& b) {
  const std::uint32_t *v = a.vertices, *w = b.vertices;
  if (v[3] == none || w[3] == none)
    return v[3] == w[3] && v[1] == w[2] && v[2] == w[1];
  return v[2] == w[2] && v[1] == w[3] && v[3] == w[1];
}

/// Cancels faces of cells that are near each other by number: a table of the latest faces, in which
/// a face takes the place of an older one. A thread's own.
class Window {
public:
  explicit Window(core::Memory& memory) : faces_(memory, INSITU_MEMORY_BUILD) {
    faces_.resize_discard(std::size_t(1) << log_size);
    std::fill(faces_.begin(), faces_.end(), FaceVertices{{none, none, none, none}});
  }

  /// What falls out of the window is added to `left`.
  void put(const FaceVertices& face, Faces& left) {
    const std::uint32_t* v = face.vertices;
    // From either side the same: the lowest vertex, that opposite in a quad, and the other two.
    const bool quad = v[3] != none;
    const std::uint64_t others = quad ? std::uint64_t(v[1]) + v[3] : std::uint64_t(v[1]) + v[2];
    const std::uint64_t hash =
        (v[0] + (others << 20) + (quad ? std::uint64_t(v[2]) << 40 : 0)) * 0x9e3779b97f4a7c15u;
    FaceVertices& at = faces_[hash >> (64 - log_size)];
    if (at.vertices[0] == v[0] && are_opposite(at, face)) {
      at.vertices[0] = none;
      return;
    }
    if (at.vertices[0] != none)
      left.push_back(at);
    at = face;
  }
  void empty(Faces& left) {
    for (const FaceVertices& face : faces_)
      if (face.vertices[0] != none)
        left.push_back(face);
  }

private:
  static constexpr int log_size = 16; ///< a megabyte, which caches hold
  Faces faces_;
};

/// Adds the faces of the cells [begin, end) that do not cancel within a window.
void add_faces_of(const mesh::MeshView& mesh, std::int64_t begin, std::int64_t end, Window& window,
                  Faces& left) {
  half_faces::for_each(mesh, begin, end, [&](const MeshFaces::Face& face, int) {
    FaceVertices vertices;
    std::copy_n(face.vertices, 4, vertices.vertices);
    window.put(vertices, left);
  });
  window.empty(left);
}

/// Cancels what is left of all cells, with the faces of each lowest vertex in a chain. Leaves those
/// that stay.
void cancel_rest(std::int64_t vertex_count, core::Memory& memory, Faces& faces) {
  core::Buffer<std::uint32_t> head(memory, INSITU_MEMORY_BUILD), next(memory, INSITU_MEMORY_BUILD);
  head.resize_discard(std::size_t(vertex_count));
  std::fill(head.begin(), head.end(), none);
  next.resize_discard(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    std::uint32_t* const first = &head[faces[i].vertices[0]];
    std::uint32_t* link = first;
    while (*link != none && !are_opposite(faces[*link], faces[i]))
      link = &next[*link];
    if (*link != none) {
      faces[*link].vertices[0] = faces[i].vertices[0] = none;
      *link = next[*link];
    } else {
      next[i] = *first;
      *first = std::uint32_t(i);
    }
  }
  FaceVertices* const end = std::remove_if(
      faces.begin(), faces.end(), [](const FaceVertices& f) { return f.vertices[0] == none; });
  faces.resize(std::size_t(end - faces.begin()));
}

} // namespace

bool can_pair_faces(const mesh::MeshView& mesh) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    if (!mesh.pieces[p].shares_vertices())
      return false;
  constexpr std::int64_t most_cells = std::int64_t(1) << 29; // whose faces 32 bits can count
  return mesh.cell_count() <= most_cells && mesh.vertex_count() < std::int64_t(none);
}

void find_unpaired_faces(const mesh::MeshView& mesh, const core::Threads& threads,
                         core::Memory& memory, core::Buffer<FaceVertices>& out) {
  constexpr std::int64_t grain = 1 << 18;
  std::vector<Faces> left;
  for (std::int64_t begin = 0; begin < mesh.cell_count(); begin += grain)
    left.emplace_back(memory, INSITU_MEMORY_BUILD);
  threads.parallel_for(mesh.cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    Window window(memory);
    add_faces_of(mesh, begin, end, window, left[std::size_t(begin / grain)]);
  });
  std::size_t sum = 0;
  for (const Faces& faces : left)
    sum += faces.size();
  out.resize_discard(sum);
  FaceVertices* to = out.data();
  for (Faces& faces : left) {
    to = std::copy(faces.begin(), faces.end(), to);
    faces.release();
  }
  cancel_rest(mesh.vertex_count(), memory, out);
}

} // namespace insitu::accel
