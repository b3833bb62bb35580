#include "amr/stitching.h"

#include <atomic>
#include <bit>
#include <string>

#include "amr/cell_runs.h"
#include "core/status.h"

namespace insitu::amr {

namespace {

/// Sets bits that many threads share; most are set already.
template <class Word>
void set_bits(Word& word, Word bits) {
  const std::atomic_ref<Word> shared(word);
  if ((shared.load(std::memory_order_relaxed) & bits) != bits)
    shared.fetch_or(bits, std::memory_order_relaxed);
}

/// Numbers vertices without sorting: a bit for each leaf that has some, and for each of those, in
/// the order of their ids, a bit for each of its 27 possible ones.
class Numbering {
public:
  explicit Numbering(std::int64_t leaves)
      : words_(std::size_t(leaves + 63) / 64, 0), before_(words_.size(), 0) {}

  void add_leaf(std::uint32_t leaf) { set_bits(words_[leaf / 64], std::uint64_t(1) << leaf % 64); }
  void count_leaves() {
    std::uint32_t sum = 0;
    for (std::size_t w = 0; w < words_.size(); ++w) {
      before_[w] = sum;
      sum += std::uint32_t(std::popcount(words_[w]));
    }
    moves_.assign(sum, 0);
    first_.resize(sum);
  }
  void add(const VertexKey& key) { set_bits(moves_[rank(key.leaf)], 1u << key.moves); }
  /// Returns how many vertices there are.
  std::int64_t count_vertices() {
    std::int64_t sum = 0;
    for (std::size_t r = 0; r < moves_.size(); ++r) {
      first_[r] = std::uint32_t(sum);
      sum += std::popcount(moves_[r]);
    }
    return sum;
  }
  std::uint32_t number(const VertexKey& key) const {
    const std::size_t r = rank(key.leaf);
    return first_[r] + std::uint32_t(std::popcount(moves_[r] & ((1u << key.moves) - 1)));
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
    return before_[leaf / 64] + std::size_t(std::popcount(words_[leaf / 64] & below));
  }

  std::vector<std::uint64_t> words_;
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

} // namespace

Stitching::Stitching(core::Memory& memory)
    : ids_(memory, INSITU_MEMORY_AMR), points_(memory, INSITU_MEMORY_AMR),
      leaves_(memory, INSITU_MEMORY_AMR) {}

void Stitching::clear() {
  ids_.resize_discard(0);
  points_.resize_discard(0);
  leaves_.resize_discard(0);
}

void Stitching::build(const std::vector<DualPart>& parts, const mesh::AmrView& mesh,
                      const VirtualLeaves& virtual_leaves, const core::Threads& threads) {
  clear();
  std::vector<std::int64_t> first(parts.size() + 1, 0);
  for (std::size_t p = 0; p < parts.size(); ++p)
    first[p + 1] = first[p] + std::int64_t(parts[p].cells.size());
  Numbering numbering(
      first.back() == 0 ? 0 : mesh.cell_count() + std::int64_t(virtual_leaves.cells.size()));
  for_cells(parts, threads, [&](const DualCell& c) {
    for (int v = 0; v < mesh::vertex_count(c.shape); ++v)
      numbering.add_leaf(c.vertices[v].leaf);
  });
  numbering.count_leaves();
  for_cells(parts, threads, [&](const DualCell& c) {
    for (int v = 0; v < mesh::vertex_count(c.shape); ++v)
      numbering.add(c.vertices[v]);
  });
  const std::int64_t vertices = numbering.count_vertices();
  if (vertices > INT32_MAX)
    throw core::Error(INSITU_ERROR_MESH, "the stitching cells of an adaptive mesh have " +
                                             std::to_string(vertices) +
                                             " vertices; at most 2^31 - 1 can be numbered");

  ids_.resize_discard(std::size_t(8 * first.back()));
  threads.parallel_for(std::int64_t(parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p) {
      std::int32_t* id = ids_.data() + 8 * first[std::size_t(p)];
      for (const DualCell& c : parts[std::size_t(p)].cells)
        for (int v = 0; v < 8; ++v)
          *id++ =
              v < mesh::vertex_count(c.shape) ? std::int32_t(numbering.number(c.vertices[v])) : -1;
    }
  });
  points_.resize_discard(std::size_t(3 * vertices));
  leaves_.resize_discard(std::size_t(vertices));
  threads.parallel_for(numbering.word_count(), 256, [&](std::int64_t begin, std::int64_t end) {
    mesh::AmrCell cell;
    std::uint32_t cell_of = BrickStore::nothing;
    for (std::int64_t w = begin; w < end; ++w)
      numbering.for_vertices(w, [&](std::uint32_t leaf, std::uint32_t moves, std::uint32_t v) {
        if (leaf != cell_of) {
          cell_of = leaf;
          if (leaf >= mesh.cell_count())
            cell = virtual_leaves.cells[std::size_t(leaf - mesh.cell_count())];
          else
            cell = cell_at(mesh, leaf);
        }
        leaves_[v] = leaf;
        for (int a = 0; a < 3; ++a)
          points_[3 * std::size_t(v) + std::size_t(a)] =
              mesh.lattice.place(a, cell.depth, halves(cell.index[a], moves, a));
      });
  });
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
