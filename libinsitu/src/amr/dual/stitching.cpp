#include "amr/dual/stitching.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <string>

#include "amr/dual/cell_runs.h"
#include "amr/values/leaf_gradient.h"
#include "core/count_bits.h"
#include "core/status.h"

namespace insitu::amr {

namespace {

using core::count_bits;
using math::Vec3d;

/// Sets bits that many threads share; most are set already.
template <class Word>
void set_bits(Word& word, Word bits) {
  const std::atomic_ref<Word> shared(word);
  if ((shared.load(std::memory_order_relaxed) & bits) != bits)
    shared.fetch_or(bits, std::memory_order_relaxed);
}

/// Numbers vertices without sorting: a bit for each leaf that has some, and for each of those, in
/// the order of their ids, a bit for each of its 27 possible ones. Most leaves have just the one
/// that is not moved; these are noted in one go.
class Numbering {
public:
  explicit Numbering(std::int64_t leaves)
      : words_(std::size_t(leaves + 63) / 64, 0), unmoved_(words_), before_(words_.size(), 0) {}

  void add_unmoved(std::uint32_t leaf) {
    set_bits(unmoved_[leaf / 64], std::uint64_t(1) << leaf % 64);
  }
  /// A leaf of vertices that add() will have.
  void add_leaf(std::uint32_t leaf) { set_bits(words_[leaf / 64], std::uint64_t(1) << leaf % 64); }
  void count_leaves() {
    std::uint32_t sum = 0;
    for (std::size_t w = 0; w < words_.size(); ++w) {
      words_[w] |= unmoved_[w];
      before_[w] = sum;
      sum += count_bits(words_[w]);
    }
    moves_.resize(sum);
    first_.resize(sum);
    std::size_t r = 0;
    for (std::size_t w = 0; w < words_.size(); ++w)
      for (std::uint64_t bits = words_[w]; bits != 0; bits &= bits - 1)
        moves_[r++] = std::uint32_t(unmoved_[w] >> std::countr_zero(bits) & 1);
  }
  void add(const VertexKey& key) { set_bits(moves_[rank(key.leaf)], 1u << key.moves); }
  /// Returns how many vertices there are.
  std::int64_t count_vertices() {
    std::int64_t sum = 0;
    for (std::size_t r = 0; r < moves_.size(); ++r) {
      first_[r] = std::uint32_t(sum);
      sum += count_bits(moves_[r]);
    }
    return sum;
  }
  std::uint32_t number(const VertexKey& key) const {
    const std::size_t r = rank(key.leaf);
    return key.moves == 0 ? first_[r] : first_[r] + count_bits(moves_[r] & ((1u << key.moves) - 1));
  }

  std::int64_t word_count() const { return std::int64_t(words_.size()); }
  /// Calls f(leaf, moves, number) for every vertex of the leaves of one word.
  template <class F>
  void for_vertices(std::int64_t word, F&& f) const {
    std::size_t r = before_[std::size_t(word)];
    for (std::uint64_t bits = words_[std::size_t(word)]; bits != 0; bits &= bits - 1, ++r) {
      std::uint32_t number = first_[r];
      for (std::uint32_t moves = moves_[r]; moves != 0; moves &= moves - 1)
        f(std::uint32_t(64 * word + std::countr_zero(bits)), std::uint32_t(std::countr_zero(moves)),
          number++);
    }
  }

private:
  std::size_t rank(std::uint32_t leaf) const {
    const std::uint64_t below = (std::uint64_t(1) << leaf % 64) - 1;
    return before_[leaf / 64] + count_bits(words_[leaf / 64] & below);
  }

  std::vector<std::uint64_t> words_, unmoved_;
  std::vector<std::uint32_t> before_;        ///< leaves before a word
  std::vector<std::uint32_t> moves_, first_; ///< of each leaf that has vertices
};

/// Calls f(cell) for the cells of every part, at once for several parts.
template <class F>
void for_cells(const std::vector<DualPart>& parts, const core::Threads& threads, F&& f) {
  threads.parallel_for(std::int64_t(parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p)
      for (const DualCell& c : parts[std::size_t(p)].cells)
        f(c);
  });
}

bool before(const Vec3d& a, const Vec3d& b) {
  return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// Whether a leaf's vertex is moved to the boundary where the solver has a ghost cell beyond.
bool meets_ghost(const mesh::AmrView& mesh, std::uint32_t real_leaf, std::uint32_t moves) {
  for (int a = 0; a < 3; ++a)
    if (const int move = int(move_along(moves, a)); move != 0)
      if (has_ghost(mesh, real_leaf, 2 * a + move - 1))
        return true;
  return false;
}

/// All parts' means, one for each place.
std::vector<MeanVertex> merge_means(const std::vector<DualPart>& parts) {
  std::vector<MeanVertex> means;
  for (const DualPart& part : parts)
    means.insert(means.end(), part.means.begin(), part.means.end());
  std::sort(means.begin(), means.end(),
            [](const MeanVertex& a, const MeanVertex& b) { return before(a.x, b.x); });
  means.erase(std::unique(means.begin(), means.end(),
                          [](const MeanVertex& a, const MeanVertex& b) { return a.x == b.x; }),
              means.end());
  return means;
}

} // namespace

Stitching::Stitching(core::Memory& memory)
    : ids_(memory, INSITU_MEMORY_AMR), points_(memory, INSITU_MEMORY_AMR),
      leaves_(memory, INSITU_MEMORY_AMR), corners_(memory) {}

void Stitching::clear() {
  ids_.resize_discard(0);
  points_.resize_discard(0);
  means_.clear();
  on_boundary_.clear();
  places_.clear();
  leaves_.resize_discard(0);
  corners_.clear();
}

void Stitching::build(const std::vector<DualPart>& parts, const mesh::AmrView& mesh,
                      const VirtualLeaves& virtual_leaves, bool with_corners,
                      const core::Threads& threads) {
  clear();
  for (const DualPart& part : parts)
    places_.insert(places_.end(), part.places.begin(), part.places.end());
  std::vector<std::int64_t> first(parts.size() + 1, 0);
  for (std::size_t p = 0; p < parts.size(); ++p)
    first[p + 1] = first[p] + std::int64_t(parts[p].cells.size());
  Numbering numbering(
      first.back() == 0 ? 0 : mesh.cell_count() + std::int64_t(virtual_leaves.leaves.size()));
  for_cells(parts, threads, [&](const DualCell& c) {
    for (int v = 0; v < mesh::vertex_count(c.shape); ++v)
      if (!c.boundary)
        numbering.add_unmoved(c.leaves[v]);
      else if (c.moves[v] != mean_moves)
        numbering.add_leaf(c.leaves[v]);
  });
  numbering.count_leaves();
  for_cells(parts, threads, [&](const DualCell& c) {
    for (int v = 0; c.boundary && v < mesh::vertex_count(c.shape); ++v)
      if (c.moves[v] != mean_moves)
        numbering.add(c.vertex(v));
  });
  const std::int64_t of_leaves = numbering.count_vertices();
  means_ = merge_means(parts);
  const std::int64_t vertices = of_leaves + std::int64_t(means_.size());
  if (vertices > INT32_MAX)
    throw core::Error(INSITU_ERROR_MESH, "the stitching cells of an adaptive mesh have " +
                                             std::to_string(vertices) +
                                             " vertices; at most 2^31 - 1 can be numbered");

  ids_.resize_discard(std::size_t(8 * first.back()));
  threads.parallel_for(std::int64_t(parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p) {
      const DualPart& part = parts[std::size_t(p)];
      const auto number = [&](const VertexKey& key) {
        if (key.moves != mean_moves)
          return std::int64_t(numbering.number(key));
        const auto at = std::lower_bound(
            means_.begin(), means_.end(), part.means[key.leaf],
            [](const MeanVertex& a, const MeanVertex& b) { return before(a.x, b.x); });
        return of_leaves + (at - means_.begin());
      };
      std::int32_t* id = ids_.data() + 8 * first[std::size_t(p)];
      for (const DualCell& c : part.cells)
        for (int v = 0; v < 8; ++v)
          *id++ = v < mesh::vertex_count(c.shape) ? std::int32_t(number(c.vertex(v))) : -1;
    }
  });
  if (with_corners)
    corners_.build(parts, first, threads);
  points_.resize_discard(std::size_t(3 * vertices));
  leaves_.resize_discard(std::size_t(vertices));
  // Of each vertex that ghost cells give a value; else 0.
  std::vector<std::uint8_t> moves_of(mesh.has_ghosts() ? std::size_t(of_leaves) : 0, 0);
  threads.parallel_for(numbering.word_count(), 256, [&](std::int64_t begin, std::int64_t end) {
    mesh::AmrCell cell;
    std::uint32_t cell_of = BrickStore::nothing, real = cell_of;
    for (std::int64_t w = begin; w < end; ++w)
      numbering.for_vertices(w, [&](std::uint32_t leaf, std::uint32_t moves, std::uint32_t v) {
        if (leaf != cell_of) {
          cell_of = real = leaf;
          if (leaf >= mesh.cell_count()) {
            const VirtualLeaves::Leaf& made =
                virtual_leaves.leaves[std::size_t(leaf - mesh.cell_count())];
            cell = made.cell;
            real = made.real_id;
          } else {
            cell = cell_at(mesh, leaf);
          }
        }
        leaves_[v] = leaf;
        if (moves != 0 && !moves_of.empty() && meets_ghost(mesh, real, moves))
          moves_of[v] = std::uint8_t(moves);
        for (int a = 0; a < 3; ++a)
          points_[3 * std::size_t(v) + std::size_t(a)] =
              mesh.lattice.place(a, cell.depth, halves(cell.index[a], moves, a));
      });
  });
  const std::int64_t first_mean = mesh.cell_count() + std::int64_t(virtual_leaves.leaves.size());
  number_on_boundary(moves_of, first_mean + std::int64_t(means_.size()));
  for (std::size_t m = 0; m < means_.size(); ++m) {
    const std::size_t v = std::size_t(of_leaves) + m;
    leaves_[v] = std::uint32_t(first_mean + std::int64_t(m));
    for (int a = 0; a < 3; ++a)
      points_[3 * v + std::size_t(a)] = means_[m].x[a];
  }
}

void Stitching::number_on_boundary(const std::vector<std::uint8_t>& moves, std::int64_t first) {
  for (std::size_t v = 0; v < moves.size(); ++v)
    if (moves[v] != 0) {
      on_boundary_.push_back({leaves_[v], moves[v]});
      leaves_[v] = std::uint32_t(first++);
    }
  if (first > std::int64_t(UINT32_MAX))
    throw core::Error(INSITU_ERROR_MESH,
                      "an adaptive mesh needs " + std::to_string(first) +
                          " values of leaves, split leaves and vertices on the boundary; at most "
                          "2^32 - 1 can be numbered");
}

mesh::PieceView Stitching::piece() const {
  mesh::PieceView p;
  p.layout = mesh::CellLayout::padded;
  p.uniform_shape = mesh::Shape::hexahedron;
  p.cell_count = cell_count();
  p.vertex_count = vertex_count();
  p.connectivity.data = reinterpret_cast<const std::byte*>(ids_.data());
  p.connectivity.count = cell_count();
  p.connectivity.stride = 8 * sizeof(std::int32_t);
  p.id_stride = sizeof(std::int32_t);
  for (int a = 0; a < 3; ++a)
    p.points.component[a] = reinterpret_cast<const std::byte*>(points_.data() + a);
  p.points.layout.count = vertex_count();
  p.points.layout.stride[0] = 3 * sizeof(double);
  return p;
}

} // namespace insitu::amr
