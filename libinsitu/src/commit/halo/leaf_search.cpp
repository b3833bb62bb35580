#include "commit/halo/leaf_search.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string>

#include "amr/values/leaf_gradient.h"
#include "commit/halo/touching_leaves.h"
#include "core/status.h"
#include "parallel/parcels.h"

namespace insitu::commit {

using mesh::AmrCell;
using mesh::AmrPieceView;
using mesh::AmrView;
using parallel::Parcel;
using parallel::Reduction;

namespace {

std::tuple<std::int32_t, std::int32_t, std::int64_t> place_of(const ToldLeaf& leaf) {
  return {leaf.name.rank, leaf.name.piece, leaf.name.cell};
}

/// In their order, each once.
void normalize(std::vector<ToldLeaf>& leaves) {
  std::ranges::sort(leaves, {}, place_of);
  leaves.erase(std::ranges::unique(leaves, {}, place_of).begin(), leaves.end());
}

std::string name_of(const mesh::CellName& name) {
  return "cell " + std::to_string(name.cell) + " of piece " + std::to_string(name.piece) +
         " of process " + std::to_string(name.rank);
}

std::string in_full(double x) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, x).ptr};
}

/// A patch as processes tell each other.
struct ToldPatch {
  std::int64_t lower[3], size[3];
  std::int32_t depth, piece;

  AmrPieceView view(int rank) const {
    AmrPieceView v;
    v.depth = depth;
    v.cell_count = 1;
    for (int a = 0; a < 3; ++a) {
      v.lower[a] = lower[a];
      v.size[a] = size[a];
      v.cell_count *= size[a];
    }
    v.rank = rank;
    v.number = piece;
    return v;
  }
};

/// Whether patches share places, the second one on the lattice of the first or a finer one.
bool meets_coarser(const AmrPieceView& coarse, const AmrPieceView& fine) {
  const int up = fine.depth - coarse.depth;
  for (int a = 0; a < 3 && up >= 0; ++a)
    if ((fine.lower[a] >> up) >= coarse.lower[a] + coarse.size[a] ||
        ((fine.lower[a] + fine.size[a] - 1) >> up) < coarse.lower[a])
      return false;
  return up >= 0;
}

/// The pieces of a process and more behind them.
struct PiecesAndMore {
  std::vector<AmrPieceView> pieces;
  std::vector<std::int64_t> first_cell{0};
  AmrView view;

  PiecesAndMore(const AmrView& own, std::span<const AmrPieceView> more) : view(own) {
    pieces.assign(own.pieces, own.pieces + own.piece_count);
    pieces.insert(pieces.end(), more.begin(), more.end());
    for (const AmrPieceView& piece : pieces)
      first_cell.push_back(first_cell.back() + piece.cell_count);
    view.pieces = pieces.data();
    view.first_cell = first_cell.data();
    view.piece_count = std::int32_t(pieces.size());
    view.halo_piece_count = std::int32_t(more.size());
    view.is_part = false;
  }
};

} // namespace

ToldLeaves::ToldLeaves(std::span<const ToldLeaf> leaves) {
  const bool any_ghosts = std::ranges::any_of(leaves, [](const ToldLeaf& l) { return l.ghosts; });
  for (const ToldLeaf& leaf : leaves) {
    depths_.push_back(leaf.depth);
    corners_.insert(corners_.end(), leaf.index, leaf.index + 3);
    for (int face = 0; any_ghosts && face < 6; ++face)
      ghost_items_.push_back(
          leaf.ghosts >> face & 1 ? std::int32_t(std::int64_t(leaves.size()) + ghosts_++) : -1);
  }
}

AmrPieceView ToldLeaves::view() const {
  AmrPieceView v;
  v.is_patch = false;
  v.cell_count = std::int64_t(depths_.size());
  v.levels = reinterpret_cast<const std::byte*>(depths_.data());
  v.levels_stride = v.level_bytes = 1;
  for (std::size_t a = 0; a < 3; ++a)
    v.corner[a] = reinterpret_cast<const std::byte*>(corners_.data() + a);
  v.corner_stride = 3 * sizeof(std::int32_t);
  v.rank = 0;
  v.ghost_items = ghost_items_.empty() ? nullptr : ghost_items_.data();
  return v;
}

LeafSearch::LeafSearch(const mesh::Mesh& mesh, const amr::LeafMap* own, parallel::World& world,
                       core::Memory& memory, const core::Threads& threads)
    : mesh_(mesh), world_(world), memory_(memory), threads_(threads), own_(own), made_(memory),
      near_(memory) {
  if (mesh.is_adaptive())
    view_ = mesh.adaptive();
  else
    view_.first_cell = &no_cells_;
}

mesh::Box LeafSearch::box_of(const AmrCell& cell) const {
  mesh::Box box;
  for (int a = 0; a < 3; ++a) {
    box.low[a] = view_.lattice.place(a, cell.depth, 2 * cell.index[a]);
    box.high[a] = view_.lattice.place(a, cell.depth, 2 * cell.index[a] + 2);
  }
  return box;
}

ToldLeaf LeafSearch::told(std::int64_t flat) const {
  const std::int32_t p = amr::piece_of(view_, flat);
  const AmrCell cell = amr::cell_at(view_, flat);
  ToldLeaf leaf{};
  leaf.name = {mesh_.global_id(INSITU_CELL, flat), world_.rank(), p, flat - view_.first_cell[p]};
  std::copy_n(cell.index, 3, leaf.index);
  leaf.depth = std::int8_t(cell.depth);
  for (int face = 0; face < 6; ++face)
    leaf.ghosts =
        std::uint8_t(leaf.ghosts | amr::has_ghost(view_, std::uint32_t(flat), face) << face);
  return leaf;
}

void LeafSearch::find(int layers) {
  require_one_lattice();
  gather_boxes();
  find_covered();
  find_near();
  find_gaps();
  std::vector<ToldLeaf> frontier = near;
  for (int layer = 1; layer < layers; ++layer)
    add_layer(frontier);
  if (layers > 1)
    outermost = std::move(frontier);
}

/// Compared with that of the first process that has cells.
void LeafSearch::require_one_lattice() {
  const bool has_cells = view_.cell_count() > 0;
  std::int64_t first = has_cells ? world_.rank() : world_.size();
  world_.reduce(std::span(&first, 1), Reduction::least);
  if (first == world_.size())
    return;
  const auto text = [&] {
    const mesh::Lattice& l = view_.lattice;
    std::string t = "origin";
    for (const double x : l.origin)
      t += " " + in_full(x);
    t += ", spacing";
    for (const double x : l.spacing)
      t += " " + in_full(x);
    t += l.is_flat != 0 ? ", of 2 dimensions" : "";
    return t + (mesh_.reconstruction() == INSITU_NEAREST ? ", nearest" : ", dual");
  };
  const std::string of_first = world_.broadcast(world_.rank() == first ? text() : "", int(first));
  world_.agree_after([&] {
    if (has_cells && text() != of_first)
      throw core::Error(INSITU_ERROR_MESH, "mesh '" + mesh_.name() + "': levels of " + text() +
                                               ", but on process " + std::to_string(first) +
                                               " of " + of_first + "; one mesh has one lattice");
  });
}

/// Those of some runs of cells, so that processes know who may touch whom.
void LeafSearch::gather_boxes() {
  std::vector<mesh::Box> boxes;
  world_.agree_after([&] {
    const std::int64_t n = view_.cell_count();
    constexpr auto most = std::int64_t(query::Directory::most_boxes);
    run_ = std::max<std::int64_t>(1, (n + most - 1) / most);
    for (std::int64_t begin = 0; begin < n; begin += run_)
      amr::for_runs(view_, begin, std::min(begin + run_, n),
                    [&, first = true](int depth, const std::int64_t* index, std::int64_t count,
                                      std::int64_t) mutable {
                      mesh::Box box = box_of({depth, {index[0], index[1], index[2]}});
                      box.extend(box_of({depth, {index[0] + count - 1, index[1], index[2]}}));
                      if (std::exchange(first, false))
                        boxes.push_back(box);
                      else
                        boxes.back().extend(box);
                    });
  });
  directory_.gather(boxes, world_);
}

bool LeafSearch::is_patched() const {
  return std::any_of(view_.pieces, view_.pieces + view_.piece_count,
                     [](const AmrPieceView& p) { return p.is_patch; });
}

/// Cells lie under finer ones of other processes, too.
void LeafSearch::find_covered() {
  std::int64_t any = is_patched();
  world_.reduce(std::span(&any, 1), Reduction::greatest);
  std::vector<Parcel> parcels;
  world_.agree_after([&] {
    std::vector<std::vector<ToldPatch>> to(std::size_t(world_.size()));
    for (std::int32_t p = 0; any && p < view_.piece_count; ++p) {
      const AmrPieceView& piece = view_.pieces[p];
      if (!piece.is_patch)
        continue;
      mesh::Box box = box_of({piece.depth, {piece.lower[0], piece.lower[1], piece.lower[2]}});
      box.extend(box_of({piece.depth,
                         {piece.lower[0] + piece.size[0] - 1, piece.lower[1] + piece.size[1] - 1,
                          piece.lower[2] + piece.size[2] - 1}}));
      ToldPatch told{{}, {}, piece.depth, p};
      std::copy_n(piece.lower, 3, told.lower);
      std::copy_n(piece.size, 3, told.size);
      for (int r = 0; r < world_.size(); ++r)
        if (r != world_.rank() && std::ranges::any_of(directory_.boxes(r), [&](const mesh::Box& b) {
              return mesh::meet(box, b);
            }))
          to[std::size_t(r)].push_back(told);
    }
    parcels = parallel::parcels_of(to);
  });
  if (!any) {
    world_.agree_after([&] {
      if (!own_)
        made_.build(view_, threads_);
    });
    own_ = own_ ? own_ : &made_;
    return;
  }
  own_ = &made_;
  parcels = world_.exchange(parcels);
  world_.agree_after([&] {
    std::vector<AmrPieceView> others;
    for (const Parcel& parcel : parcels)
      for (const ToldPatch& told : parallel::items_of<ToldPatch>(parcel.bytes)) {
        const AmrPieceView patch = told.view(parcel.rank);
        if (std::any_of(
                view_.pieces, view_.pieces + view_.piece_count,
                [&](const AmrPieceView& own) { return own.is_patch && meets_coarser(own, patch); }))
          others.push_back(patch);
      }
    const PiecesAndMore all(view_, others);
    made_.build(all.view, threads_);
    covered.assign(std::size_t((view_.cell_count() + 63) / 64), 0);
    for (std::int64_t flat = 0; flat < view_.cell_count(); ++flat) {
      const AmrCell cell = amr::cell_at(view_, flat);
      if (made_.at(cell.depth, cell.index) != std::uint32_t(flat))
        covered[std::size_t(flat >> 6)] |= std::uint64_t(1) << (flat & 63);
    }
    view_.covered = covered.data();
    made_.build(view_, threads_);
  });
}

void LeafSearch::require_apart(const ToldLeaf& other) const {
  const std::uint32_t mine = overlapping_leaf(own_->store(), other.cell());
  if (mine != amr::BrickStore::nothing)
    throw core::Error(INSITU_ERROR_MESH,
                      "mesh '" + mesh_.name() + "': cells of two processes overlap: " +
                          name_of(told(mine).name) + " and " + name_of(other.name));
}

/// Each tells another the leaves that lie near it.
void LeafSearch::find_near() {
  std::vector<Parcel> parcels;
  world_.agree_after([&] {
    std::vector<std::vector<ToldLeaf>> to(std::size_t(world_.size()));
    for_leaves_beside(0.0, [&](std::int64_t flat, const AmrCell&, std::span<const int> ranks) {
      for (const int r : ranks)
        to[std::size_t(r)].push_back(told(flat));
    });
    parcels = parallel::parcels_of(to);
  });
  parcels = world_.exchange(parcels);
  world_.agree_after([&] {
    for (const Parcel& parcel : parcels)
      for (const ToldLeaf& leaf : parallel::items_of<ToldLeaf>(parcel.bytes)) {
        require_apart(leaf);
        bool touches = false;
        for_touching(own_->store(), leaf.cell(), [&](std::uint32_t) { touches = true; });
        if (touches)
          near.push_back(leaf);
      }
    normalize(near);
    const ToldLeaves leaves(near);
    const AmrPieceView piece = leaves.view();
    AmrView none = view_;
    none.piece_count = 0;
    none.covered = nullptr;
    near_.build(PiecesAndMore(none, std::span(&piece, 1)).view, threads_);
  });
}

/// Who has a leaf knows all that touch it.
void LeafSearch::add_layer(std::vector<ToldLeaf>& frontier) {
  std::vector<Parcel> parcels;
  world_.agree_after([&] {
    std::vector<std::vector<ToldLeaf>> to(std::size_t(world_.size()));
    for (const ToldLeaf& leaf : frontier)
      to[std::size_t(leaf.name.rank)].push_back(leaf);
    parcels = parallel::parcels_of(to);
  });
  parcels = world_.exchange(parcels);
  world_.agree_after([&] {
    for (Parcel& parcel : parcels) {
      std::vector<bool> own(std::size_t(view_.cell_count())), others(near.size()); // are told
      std::vector<ToldLeaf> answers;
      for (const ToldLeaf& leaf : parallel::items_of<ToldLeaf>(parcel.bytes)) {
        for_touching(own_->store(), leaf.cell(), [&](std::uint32_t id) {
          if (!own[id])
            answers.push_back(told(id));
          own[id] = true;
        });
        for_touching(near_.store(), leaf.cell(), [&](std::uint32_t n) {
          if (!others[n])
            answers.push_back(near[n]);
          others[n] = true;
        });
      }
      parcel.bytes = parallel::bytes_of(answers);
    }
    std::erase_if(parcels, [](const Parcel& p) { return p.bytes.empty(); });
  });
  parcels = world_.exchange(parcels);
  world_.agree_after([&] {
    std::vector<ToldLeaf> told_ones, unknown;
    for (const Parcel& parcel : parcels)
      for (const ToldLeaf& leaf : parallel::items_of<ToldLeaf>(parcel.bytes))
        if (leaf.name.rank != world_.rank())
          told_ones.push_back(leaf);
    normalize(told_ones);
    std::ranges::set_difference(told_ones, near, std::back_inserter(unknown), {}, place_of,
                                place_of);
    frontier.clear();
    std::ranges::set_difference(unknown, far, std::back_inserter(frontier), {}, place_of, place_of);
    std::vector<ToldLeaf> all;
    std::ranges::merge(far, frontier, std::back_inserter(all), {}, place_of, place_of);
    far = std::move(all);
  });
}

} // namespace insitu::commit
