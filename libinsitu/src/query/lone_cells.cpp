#include "query/lone_cells.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <new>

#include "cells/exact/decide.h"
#include "cells/kernels/kernels.h"
#include "core/status.h"
#include "mesh/box.h"
#include "mesh/piece_borders.h"
#include "query/batch/candidates.h"
#include "query/point_query.h"

namespace insitu::query {

namespace {

using math::Vec3d;
using Word = std::atomic_ref<std::uint64_t>;

/// From how many points a cell on finding out pays: see doc/notes/locating.md.
constexpr double price_with_faces = 4.0, price = 1.5;
/// Faces that are kept at most: so many a cell, and some more for small meshes.
constexpr double most_faces_a_cell = 0.25;
constexpr std::int64_t more_faces = 4096;

constexpr std::uint64_t bit_of(std::int64_t cell) {
  return std::uint64_t(1) << (unsigned(cell) & 63);
}

mesh::Box box_of(const mesh::MeshView& mesh, const accel::FaceVertices& face) {
  const std::int32_t p = mesh::piece_of_vertex(mesh, face.vertices[0]);
  const auto point = [&](int k) {
    return mesh.pieces[p].point(std::int64_t(face.vertices[k]) - mesh.first_vertex[p]);
  };
  const Vec3d first = point(0);
  mesh::Box box{first, first};
  for (int k = 1; k < 4 && face.vertices[k] != accel::none; ++k) {
    const Vec3d x = point(k);
    box.extend({x, x});
  }
  return box;
}

/// Whether cells that follow each other mostly share a vertex, or are few. Where they do not,
/// finding the faces took 0.8 to 1.3 us a cell, and saved nothing at random points.
bool are_numbered_in_order(const mesh::MeshView& mesh) {
  constexpr std::int64_t few = 1 << 16, samples = 1000;
  if (mesh.cell_count() <= few)
    return true;
  std::int64_t asked = 0, sharing = 0;
  mesh::CellVertices a, b;
  for (std::int64_t i = 0; i < samples; ++i) {
    const std::int64_t cell = i * (mesh.cell_count() / samples);
    const std::int32_t p = mesh.piece_of(cell);
    const mesh::PieceView& piece = mesh.pieces[p];
    const std::int64_t local = cell - mesh.first_cell[p];
    if (cell + 1 >= mesh.first_cell[p + 1] || !piece.exists(local) || !piece.exists(local + 1))
      continue;
    mesh::gather(mesh, cell, a);
    mesh::gather(mesh, cell + 1, b);
    ++asked;
    sharing +=
        std::find_first_of(a.ids, a.ids + a.count, b.ids, b.ids + b.count) != a.ids + a.count;
  }
  return 2 * sharing >= asked;
}

/// Which vertices hang together through cells, by the lowest vertex of each lot.
class Lots {
public:
  Lots(std::int64_t vertices, core::Memory& memory) : lower_(memory, INSITU_MEMORY_BUILD) {
    lower_.resize_discard(std::size_t(vertices));
    for (std::size_t v = 0; v < lower_.size(); ++v)
      lower_[v] = std::uint32_t(v);
  }
  std::uint32_t lowest(std::int64_t vertex) {
    auto v = std::uint32_t(vertex);
    while (lower_[v] != v)
      v = lower_[v] = lower_[lower_[v]];
    return v;
  }
  void join(std::int64_t a, std::int64_t b) {
    const std::uint32_t low_a = lowest(a), low_b = lowest(b);
    lower_[std::max(low_a, low_b)] = std::min(low_a, low_b);
  }

private:
  core::Buffer<std::uint32_t> lower_;
};

/// A point of the interior that no symmetry of a mesh of such cells puts on a face.
Vec3d inner_point(mesh::Shape shape, int turn) {
  const double by = 0.0137 * turn;
  switch (shape) {
  case mesh::Shape::tetrahedron:
    return {0.2213 + by, 0.2671 - by, 0.2417};
  case mesh::Shape::wedge:
    return {0.3119 + by, 0.3427 - by, 0.4783};
  case mesh::Shape::pyramid:
    return {0.4831 + by, 0.5213 - by, 0.1927};
  default:
    return {0.4813 + by, 0.5231 - by, 0.4719};
  }
}

enum class Cover : std::uint8_t { unknown, once, otherwise };

/// How many cells hold a point in the interior of this one.
Cover cover_of(const PointQuery& query, std::int64_t flat, int turn) {
  mesh::CellVertices cell;
  mesh::gather(query.mesh, flat, cell);
  const Vec3d p = cells::map_to_physical(cell.shape, cell.x, inner_point(cell.shape, turn));
  float lower[3], upper[3];
  if (!query.box_rule().box(p, lower, upper))
    return Cover::unknown;
  int holding = 0;
  bool own = false;
  for (const Candidate& c : query.candidates_in(lower, upper)) {
    const std::int64_t other = query.tree.cells()[c.slot];
    mesh::gather(query.mesh, other, cell);
    const cells::Decision why = decide(cell.shape, cell.x, p);
    if (!why)
      continue;
    if (why.is_on_boundary())
      return Cover::unknown; // a point on a face tells nothing
    ++holding;
    own = own || other == flat;
  }
  return !own ? Cover::unknown : holding == 1 ? Cover::once : Cover::otherwise;
}

} // namespace

void LoneCells::begin(bool serves) {
  serves_ = serves;
  forget();
  has_faces_ = false;
  faces_.release();
  bits_.release();
}

void LoneCells::forget() {
  known_ = false;
  is_settled_ = !serves_;
  asked_ = 0;
}

void LoneCells::find_if_due(const mesh::MeshView& mesh, const core::Threads& threads) const {
  if (is_settled_.load(std::memory_order_relaxed))
    return;
  const double due = (has_faces_ ? price : price_with_faces) * double(mesh.cell_count());
  if (double(asked_.load(std::memory_order_relaxed)) > due)
    find(mesh, threads);
}

void LoneCells::find(const mesh::MeshView& mesh, const core::Threads& threads) const {
  if (!mesh.free_of_folds && tree_.odd().empty())
    return;                       // which cells fold may be found out later
  if (is_settled_.exchange(true)) // others do without meanwhile
    return;
  try {
    find_all(mesh, threads);
  } catch (const std::bad_alloc&) {
    bits_.release();
  } catch (const core::Error& error) {
    bits_.release();
    if (error.status() != INSITU_ERROR_MEMORY)
      throw;
  }
}

void LoneCells::find_all(const mesh::MeshView& mesh, const core::Threads& threads) const {
  if (tree_.empty() || mesh.first_single_cell() > 0 || !accel::can_pair_faces(mesh) ||
      !are_numbered_in_order(mesh))
    return;
  if (!has_faces_) {
    accel::find_unpaired_faces(mesh, threads, memory_, faces_);
    faces_.shrink();
    has_faces_ = true;
    if (std::int64_t(faces_.size()) >
        std::int64_t(most_faces_a_cell * double(mesh.cell_count())) + more_faces)
      serves_ = false;
  }
  if (!serves_) {
    faces_.release();
    return;
  }
  bits_.resize_discard(std::size_t(mesh.cell_count() + 63) / 64);
  std::fill(bits_.begin(), bits_.end(), std::uint64_t(0));
  for (std::int64_t slot = 0; slot < tree_.cell_count(); ++slot)
    bits_[tree_.cells()[slot] >> 6] |= bit_of(tree_.cells()[slot]);
  const auto odd = tree_.odd().boxes();
  const auto odd_box = [&](std::int64_t i) { return odd[std::size_t(i)]; };
  const auto face_box = [&](std::int64_t i) { return box_of(mesh, faces_[std::size_t(i)]); };
  if (!strike(std::int64_t(odd.size()), threads, odd_box) ||
      !strike(std::int64_t(faces_.size()), threads, face_box))
    return;
  keep_covered_once(mesh);
  known_.store(true, std::memory_order_release);
}

/// Strikes the cells whose boxes meet those of `count` boxes: box(i). False: one is not finite.
template <class Box>
bool LoneCells::strike(std::int64_t count, const core::Threads& threads, const Box& box) const {
  struct Batch {
    QueryBoxes boxes;
    TraversalScratch traversal;
  };
  const BoxRule rule(tree_.origin());
  std::atomic<bool> all_finite{true};
  threads.parallel_for(count, batch_size, [&](std::int64_t begin, std::int64_t end) {
    const auto batch = std::make_unique<Batch>(); // too large for a thread's stack
    batch->boxes.count = int(end - begin);
    for (std::int64_t i = begin; i < end; ++i) {
      const mesh::Box of = box(i);
      float lower[3], upper[3], other[3];
      if (!rule.box(of.low, lower, other) || !rule.box(of.high, other, upper))
        all_finite = false;
      float* const bounds = batch->boxes.bounds[i - begin];
      for (int a = 0; a < 3; ++a) {
        bounds[2 * a] = upper[a];
        bounds[2 * a + 1] = -lower[a];
      }
    }
    if (!all_finite)
      return;
    find_candidates(tree_, batch->boxes, batch->traversal);
    for (std::size_t c = 0; c < batch->traversal.found; ++c) {
      const std::int64_t cell = tree_.cells()[batch->traversal.candidates[c].slot];
      Word word(bits_[std::size_t(cell) >> 6]);
      if (word.load(std::memory_order_relaxed) & bit_of(cell))
        word.fetch_and(~bit_of(cell), std::memory_order_relaxed);
    }
  });
  return all_finite;
}

/// Of these, leaves the lots that cover space once. A lot hangs together through vertices, and
/// meets no face that stays.
void LoneCells::keep_covered_once(const mesh::MeshView& mesh) const {
  constexpr int most_turns = 8;
  const PointQuery query{mesh, tree_, {}};
  Lots lots(mesh.vertex_count(), memory_);
  const auto for_each = [&](auto&& f) {
    std::int32_t piece = 0;
    for (std::size_t w = 0; w < bits_.size(); ++w)
      for (std::uint64_t left = bits_[w]; left; left &= left - 1) {
        const auto cell = std::int64_t(w * 64) + std::countr_zero(left);
        while (cell >= mesh.first_cell[piece + 1])
          ++piece;
        std::int64_t ids[8];
        const int n = mesh.pieces[piece].vertex_ids(cell - mesh.first_cell[piece], ids);
        f(cell, mesh.first_vertex[piece], ids, n);
      }
  };
  for_each([&](std::int64_t, std::int64_t first, const std::int64_t* ids, int n) {
    for (int v = 1; v < n; ++v)
      lots.join(first + ids[0], first + ids[v]);
  });
  struct Verdict {
    Cover cover;
    std::uint8_t turns;
  };
  core::Buffer<Verdict> verdicts(memory_, INSITU_MEMORY_BUILD); // [vertex], of a lot's lowest
  verdicts.resize_discard(std::size_t(mesh.vertex_count()));
  std::fill(verdicts.begin(), verdicts.end(), Verdict{Cover::unknown, 0});
  for_each([&](std::int64_t cell, std::int64_t first, const std::int64_t* ids, int) {
    Verdict& of_lot = verdicts[lots.lowest(first + ids[0])];
    if (of_lot.cover == Cover::unknown && of_lot.turns < most_turns)
      of_lot.cover = cover_of(query, cell, of_lot.turns++);
  });
  for_each([&](std::int64_t cell, std::int64_t first, const std::int64_t* ids, int) {
    if (verdicts[lots.lowest(first + ids[0])].cover != Cover::once)
      bits_[std::size_t(cell) >> 6] &= ~bit_of(cell);
  });
}

} // namespace insitu::query
