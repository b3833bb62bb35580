/// The halo of an adaptive mesh: leaves of other processes.
#include <algorithm>

#include "commit/halo/halo.h"

namespace insitu::commit {

using parallel::ByteReader;
using parallel::ByteWriter;

namespace {

/// A dual cell at a corner of this process's leaves takes those that touch them; its neighbours,
/// which decide who owns points on its faces, take those that touch these; and values in split
/// leaves and in re-entrant corners take gradients there, which one layer more gives.
constexpr int layers_of_dual = 3, layers_of_nearest = 1;

} // namespace

/// Leaves of one process and piece after the other become pieces.
void Halo::borrow_leaves(std::span<const ToldLeaf> leaves) {
  const auto of = [](const ToldLeaf& l) { return std::pair(l.name.rank, l.name.piece); };
  for (auto begin = leaves.begin(); begin != leaves.end();) {
    const auto end =
        std::find_if(begin, leaves.end(), [&](const ToldLeaf& l) { return of(l) != of(*begin); });
    Borrowed& b = borrowed_.emplace_back(*memory_);
    b.rank = begin->name.rank;
    b.piece = begin->name.piece;
    b.has_global = begin->name.global >= 0;
    const auto count = std::size_t(end - begin);
    b.cells.resize_discard(count);
    b.global.resize_discard(b.has_global ? count : 0);
    for (std::size_t i = 0; i < count; ++i) {
      b.cells[i] = begin[std::ptrdiff_t(i)].name.cell;
      if (b.has_global)
        b.global[i] = begin[std::ptrdiff_t(i)].name.global;
    }
    b.leaves.emplace(std::span(begin, end));
    begin = end;
  }
}

/// Of each piece its number, how many leaves, and which, with the faces across which ghost cells
/// are wanted.
void Halo::ask_for_leaves(std::vector<ByteWriter>& to) const {
  for (const Borrowed& b : borrowed_) {
    ByteWriter& out = to[std::size_t(b.rank)];
    out.value(b.piece);
    out.value(std::int64_t(b.cells.size()));
    out.array(std::span<const std::int64_t>(b.cells.data(), b.cells.size()));
    out.value(std::int32_t(b.leaves->ghost_count() > 0));
    if (b.leaves->ghost_count() == 0)
      continue;
    const mesh::AmrPieceView view = b.leaves->view();
    for (std::size_t i = 0; i < b.cells.size(); ++i) {
      std::uint8_t faces = 0;
      for (std::size_t face = 0; face < 6; ++face)
        faces = std::uint8_t(faces | (view.ghost_items[6 * i + face] >= 0) << face);
      out.value(faces);
    }
  }
}

void Halo::lend_leaves(const mesh::Mesh& mesh, int rank, ByteReader& from) {
  const mesh::MeshView& view = mesh.own_view();
  while (!from.at_end()) {
    Lent& lent = lent_.emplace_back(Lent{rank, from.value<std::int32_t>(), {}, {}, {}});
    lent.cells = from.array<std::int64_t>(std::size_t(from.value<std::int64_t>()));
    if (from.value<std::int32_t>() != 0)
      lent.ghosts = from.array<std::uint8_t>(lent.cells.size());
    for (const std::int64_t cell : lent.cells) {
      const std::int64_t flat = view.first_cell[lent.piece] + cell;
      seam_[std::size_t(flat >> 6)] |= std::uint64_t(1) << (flat & 63);
      lent_leaves_.push_back({std::uint32_t(flat), rank});
    }
  }
}

void Halo::find_leaves(const mesh::Mesh& mesh, const amr::LeafMap* own, parallel::World& world,
                       const core::Threads& threads) {
  std::int64_t is_dual = mesh.is_adaptive() && mesh.reconstruction() == INSITU_DUAL;
  world.reduce(std::span(&is_dual, 1), parallel::Reduction::greatest);
  LeafSearch search(mesh, own, world, *memory_, threads);
  search.find(is_dual ? layers_of_dual : layers_of_nearest);
  gaps_ = search.gaps;
  std::vector<Borrowed> before;
  swap(
      world,
      [&](std::vector<ByteWriter>& to) {
        before = std::exchange(borrowed_, {});
        lent_.clear();
        lent_leaves_.clear();
        seam_.assign(std::size_t((mesh.own_view().own_cell_count() + 63) / 64), 0);
        borrow_leaves(search.near);
        near_count_ = borrowed_.size();
        borrow_leaves(search.far);
        ask_for_leaves(to);
      },
      [&](int rank, ByteReader& from) { lend_leaves(mesh, rank, from); });
  world.agree_after([&] {
    std::ranges::sort(lent_leaves_);
    far_count_ = std::int32_t(borrowed_.size() - near_count_);
    covered_ = std::move(search.covered);
    outermost_.assign((search.far.size() + 63) / 64, 0);
    auto last = search.outermost.begin();
    for (std::size_t i = 0; i < search.far.size() && last != search.outermost.end(); ++i)
      if (search.far[i].name == last->name) {
        outermost_[i >> 6] |= std::uint64_t(1) << (i & 63);
        ++last;
      }
    views_.clear();
    leaf_views_.clear();
    for (const Borrowed& b : borrowed_) {
      mesh::AmrPieceView& leaves = leaf_views_.emplace_back(b.leaves->view());
      leaves.rank = b.rank;
      leaves.number = b.piece;
      mesh::PieceView& view = views_.emplace_back();
      view.cell_count = leaves.cell_count;
      view.is_halo = true;
    }
  });
}

} // namespace insitu::commit
