#include "mesh/facts.h"

#include <bit>
#include <cmath>
#include <mutex>

namespace insitu::mesh {

namespace {

constexpr int key_shift = 49; ///< of a double's bits: three of the mantissa stay
constexpr std::uint32_t key_count = 1u << (63 - key_shift);

/// Gathers facts of one thread's cells.
class Gatherer {
public:
  Gatherer() : counts_(key_count), least_(key_count) {}

  /// cells: with boxes of this size.
  void note(const Box& box, const math::Vec3d& size, std::int64_t cells) {
    if (facts_.cells == 0)
      facts_.bounds = box;
    else
      facts_.bounds.extend(box);
    facts_.cells += cells;
    const double volume = size.x * size.y * size.z;
    const auto key = std::uint32_t(std::bit_cast<std::uint64_t>(volume) >> key_shift) % key_count;
    least_[key] = counts_[key] == 0 ? volume : std::min(least_[key], volume);
    counts_[key] += cells;
  }

  MeshFacts take() {
    for (std::uint32_t key = 0; key < key_count; ++key)
      if (counts_[key] > 0)
        facts_.sizes.push_back({key, counts_[key], least_[key]});
    return std::move(facts_);
  }

private:
  MeshFacts facts_;
  std::vector<std::int64_t> counts_; ///< [key]
  std::vector<double> least_;
};

/// The full cells of a gridlet that are the process's, all of one size.
void note_gridlet(const PieceView& piece, std::int64_t gridlet, Gatherer& to) {
  const GridletsView& all = *piece.gridlets;
  const std::uint64_t* const layers = all.full + Gridlet::side * gridlet;
  const std::uint64_t* const foreign =
      piece.foreign ? piece.foreign + Gridlet::side * gridlet : nullptr;
  int count = 0, first[3] = {Gridlet::side, Gridlet::side, Gridlet::side}, last[3] = {-1, -1, -1};
  const auto extend = [&](int axis, int lowest, int highest) {
    first[axis] = std::min(first[axis], lowest);
    last[axis] = std::max(last[axis], highest);
  };
  for (int k = 0; k < Gridlet::side; ++k) {
    const std::uint64_t layer = foreign ? layers[k] & ~foreign[k] : layers[k];
    if (layer == 0)
      continue;
    count += std::popcount(layer);
    extend(2, k, k);
    extend(1, std::countr_zero(layer) / Gridlet::side,
           (63 - std::countl_zero(layer)) / Gridlet::side);
    std::uint64_t row = layer;
    for (int shift = 32; shift >= Gridlet::side; shift /= 2)
      row |= row >> shift;
    row &= 0xff;
    extend(0, std::countr_zero(row), 63 - std::countl_zero(row));
  }
  if (count == 0)
    return;
  const Gridlet& g = all.gridlets[gridlet];
  Box box;
  math::Vec3d size;
  for (int a = 0; a < 3; ++a) {
    box.low[a] = all.coordinate(g, a, first[a]);
    box.high[a] = all.coordinate(g, a, last[a] + 1);
    size[a] = all.coordinate(g, a, 1) - all.coordinate(g, a, 0);
  }
  to.note(box, size, count);
}

} // namespace

void MeshFacts::add(const MeshFacts& other) {
  if (other.cells == 0)
    return;
  if (cells == 0)
    bounds = other.bounds;
  else
    bounds.extend(other.bounds);
  cells += other.cells;
  std::vector<SizeClass> all;
  auto a = sizes.begin();
  auto b = other.sizes.begin();
  while (a != sizes.end() || b != other.sizes.end()) {
    if (b == other.sizes.end() || (a != sizes.end() && a->key < b->key))
      all.push_back(*a++);
    else if (a == sizes.end() || b->key < a->key)
      all.push_back(*b++);
    else {
      all.push_back({a->key, a->cells + b->cells, std::min(a->least, b->least)});
      ++a, ++b;
    }
  }
  sizes = std::move(all);
}

double MeshFacts::diagonal() const {
  const math::Vec3d d = bounds.size();
  const double length = cells > 0 ? std::sqrt(dot(d, d)) : 0.0;
  return length > 0 ? length : 1.0;
}

double MeshFacts::cell_size() const {
  const double across = diagonal();
  if (cells == 0)
    return across;
  std::int64_t before = 0;
  auto median = sizes.begin();
  while (before + median->cells <= cells / 2)
    before += median++->cells;
  const double size = std::cbrt(median->least);
  return size > 0 ? std::max(size, across / 16384) : across / 256;
}

MeshFacts find_facts(const MeshView& mesh, const core::Threads* threads) {
  MeshFacts facts;
  std::mutex mutex;
  const auto in_parallel = [&](std::int64_t count, std::int64_t grain, auto&& note) {
    const auto look = [&](std::int64_t begin, std::int64_t end) {
      Gatherer gatherer;
      for (std::int64_t i = begin; i < end; ++i)
        note(i, gatherer);
      const MeshFacts part = gatherer.take();
      const std::lock_guard lock(mutex);
      facts.add(part);
    };
    if (threads)
      threads->parallel_for(count, grain, look);
    else if (count > 0)
      look(0, count);
  };
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const PieceView& piece = mesh.pieces[p];
    if (piece.pole != 0)
      continue;
    if (piece.gridlets)
      in_parallel(piece.gridlets->count, 1 << 12,
                  [&](std::int64_t i, Gatherer& to) { note_gridlet(piece, i, to); });
    else
      in_parallel(piece.cell_count, 1 << 16, [&](std::int64_t i, Gatherer& to) {
        if (!piece.owns(i))
          return;
        CellVertices cell;
        gather(mesh, mesh.first_cell[p] + i, cell);
        const Box box = box_of(cell);
        to.note(box, box.size(), 1);
      });
  }
  return facts;
}

} // namespace insitu::mesh
