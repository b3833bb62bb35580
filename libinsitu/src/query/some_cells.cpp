#include "query/some_cells.h"

#include <atomic>

#include "mesh/ghosts.h"
#include "query/on_demand.h"

namespace insitu::query {

void SomeCells::update(const mesh::MeshView& mesh, const core::Threads& threads, Changed changed,
                       Takes takes) {
  std::atomic<bool> differs{changed == Changed::topology ||
                            std::size_t(mesh.piece_count) != left_out_.size()};
  std::atomic<std::int64_t> taken{0};
  std::atomic<bool> owner_out{false}, other_in{false};
  while (left_out_.size() > std::size_t(mesh.piece_count))
    left_out_.pop_back();
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    if (std::size_t(p) == left_out_.size())
      left_out_.emplace_back(*memory_, INSITU_MEMORY_BLANK);
    core::Buffer<std::uint8_t>& out = left_out_[std::size_t(p)];
    const mesh::PieceView& piece = mesh.pieces[p];
    const bool fresh = std::int64_t(out.size()) != piece.cell_count;
    if (fresh)
      differs = true;
    out.resize_discard(std::size_t(piece.cell_count));
    threads.parallel_for(piece.cell_count, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      std::int64_t in = 0;
      bool others = false, lost = false, added = false;
      for (std::int64_t c = begin; c < end; ++c) {
        const bool takes_it = takes(p, c), is_there = piece.exists(c);
        others |= fresh || (out[std::size_t(c)] == 0) != takes_it;
        lost |= is_there && !takes_it;
        added |= takes_it && !is_there;
        out[std::size_t(c)] = takes_it ? 0 : 1;
        in += takes_it;
      }
      taken += in;
      if (others)
        differs = true;
      if (lost)
        owner_out = true;
      if (added)
        other_in = true;
    });
  }
  count_ = taken;
  leaves_out_owners_ = owner_out;
  takes_others_ = other_in;
  view_ = mesh;
  (void)of(Sampler(mesh, tree_));
  if (differs || changed != Changed::nothing)
    on_demand_.facts.forget();
  if (changed == Changed::topology)
    on_demand_.steps.forget();
  if (differs) {
    fit_.set(false, 1);
    tree_.build(view_, threads, accel::Builder::automatic);
  } else if (changed == Changed::geometry && !tree_.empty()) {
    fit_.set(true, threads.count());
  }
}

Sampler SomeCells::of(const Sampler& whole) {
  if (whole.on_demand() && whole.on_demand()->displacement)
    whole.on_demand()->displacement->complete(); // of which this has a copy
  const mesh::MeshView& mesh = whole.mesh();
  pieces_.assign(mesh.pieces, mesh.pieces + mesh.piece_count);
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    mesh::set_ghosts(pieces_[p], left_out_[p].data(), 1);
  view_ = mesh;
  view_.pieces = pieces_.data();
  if (takes_others_) // nobody has validated these
    view_.free_of_folds = view_.covers_once = view_.one_mesh = false;
  on_demand_.sound = whole.on_demand() && !takes_others_ ? whole.on_demand()->sound : nullptr;
  return whole.in(view_, tree_, &on_demand_);
}

} // namespace insitu::query
