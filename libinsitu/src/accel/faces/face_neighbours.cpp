#include "accel/faces/face_neighbours.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <span>
#include <vector>

#include "accel/faces/half_faces.h"

namespace insitu::accel {

namespace {

constexpr std::int64_t grain = 1 << 16;

/// The most faces of a cell of the mesh.
std::int64_t most_faces(const mesh::MeshView& mesh, const core::Threads& threads) {
  std::atomic<int> most{0};
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const mesh::PieceView& piece = mesh.pieces[p];
    const bool mixes =
        piece.layout == mesh::CellLayout::mixed || piece.layout == mesh::CellLayout::padded;
    threads.parallel_for(mixes ? piece.cell_count : std::min<std::int64_t>(piece.cell_count, 1),
                         grain, [&](std::int64_t begin, std::int64_t end) {
                           int found = 0;
                           for (std::int64_t c = begin; c < end; ++c)
                             found = std::max(found, cells::face_table(piece.shape(c)).face_count);
                           for (int so_far = most;
                                found > so_far && !most.compare_exchange_weak(so_far, found);) {
                           }
                         });
  }
  return most;
}

/// A cell's face: the vertices as a hash of 61 bits, which tells the faces of a bucket apart but
/// for a chance of 1e-10; a neighbour is a guess that is proven anyway.
struct HalfFace {
  std::uint32_t cell; ///< `none`: it has its neighbour
  std::uint32_t hash;
  std::uint32_t hash_and_face; ///< the face in the lowest three bits

  bool is_same(const HalfFace& b) const {
    return hash == b.hash && (hash_and_face ^ b.hash_and_face) < 8;
  }
  std::size_t place(std::int64_t faces) const {
    return std::size_t(cell) * std::size_t(faces) + (hash_and_face & 7U);
  }
};

std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  return hash ^ hash >> 32;
}

/// The same from either side: the lowest vertex, that opposite in a quad, and the other two.
HalfFace half_face_of(const MeshFaces::Face& face, int f) {
  const std::uint32_t* v = face.vertices;
  const bool quad = v[3] != none;
  const std::uint32_t a = v[1], b = quad ? v[3] : v[2], opposite = quad ? v[2] : none;
  const std::uint64_t hash = mix(mix(mix(v[0], opposite), std::min(a, b)), std::max(a, b));
  return {face.cell, std::uint32_t(hash >> 32), (std::uint32_t(hash) & ~7U) | std::uint32_t(f)};
}

/// Matches the half faces of a bucket; a thread's own.
class Matcher {
public:
  /// to(half face): where its neighbour goes.
  template <class To>
  void match(std::span<HalfFace> half, To&& to) {
    const std::size_t slots = std::bit_ceil(2 * half.size() + 1);
    slots_.assign(slots, none);
    for (std::uint32_t i = 0; i < half.size(); ++i) {
      HalfFace& face = half[i];
      std::size_t s = face.hash & (slots - 1);
      while (slots_[s] != none && !half[slots_[s]].is_same(face))
        s = (s + 1) & (slots - 1);
      if (slots_[s] == none) {
        slots_[s] = i;
        continue;
      }
      HalfFace& other = half[slots_[s]];
      if (other.cell == none)
        continue; // a third one
      to(face) = other.cell;
      to(other) = face.cell;
      other.cell = none;
    }
  }

private:
  std::vector<std::uint32_t> slots_;
};

} // namespace

FaceNeighbours::FaceNeighbours(core::Memory& memory)
    : memory_(&memory), cells_(memory, INSITU_MEMORY_NEIGHBOURS) {}

bool FaceNeighbours::fits(const mesh::MeshView& mesh) {
  for (std::int32_t p = 0; p < mesh.piece_count; ++p)
    if (!mesh.pieces[p].shares_vertices())
      return false;
  return mesh.cell_count() < std::int64_t(none) && mesh.vertex_count() < std::int64_t(none);
}

std::int64_t FaceNeighbours::bytes(const mesh::MeshView& mesh, const core::Threads& threads) {
  return mesh.cell_count() * most_faces(mesh, threads) * std::int64_t(sizeof(std::uint32_t));
}

void FaceNeighbours::build(const mesh::MeshView& mesh, const core::Threads& threads) {
  faces_ = most_faces(mesh, threads);
  cells_.release();
  cells_.resize_discard(std::size_t(mesh.cell_count() * faces_));
  threads.parallel_for(std::int64_t(cells_.size()), grain,
                       [&](std::int64_t begin, std::int64_t end) {
                         std::fill(cells_.data() + begin, cells_.data() + end, none);
                       });
  HalfFaces half(mesh, threads);
  core::Buffer<HalfFace> all(*memory_, INSITU_MEMORY_BUILD);
  all.resize_discard(half.count());
  half.fill(all.data(), half_face_of);
  threads.parallel_for(std::int64_t(half.buckets()), 8, [&](std::int64_t begin, std::int64_t end) {
    Matcher matcher;
    for (auto b = std::size_t(begin); b < std::size_t(end); ++b)
      matcher.match({all.data() + half.start(b), half.start(b + 1) - half.start(b)},
                    [&](const HalfFace& f) -> std::uint32_t& { return cells_[f.place(faces_)]; });
  });
}

} // namespace insitu::accel
