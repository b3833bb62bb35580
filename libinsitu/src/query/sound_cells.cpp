#include "query/sound_cells.h"

#include <algorithm>

#include "cells/checks/folds.h"
#include "cells/kernels/cell_block.h"

namespace insitu::query {

namespace {

using State = std::atomic_ref<std::uint8_t>;

} // namespace

void SoundCells::begin(bool are_inverted) {
  is_there_ = true;
  is_open_ = false;
  are_inverted_ = are_inverted;
  room_ = nullptr; // there may be more of them
  states_.release();
}

void SoundCells::forget() {
  is_open_ = true;
  if (++epoch_ <= most_epochs)
    return;
  epoch_ = 1;
  std::fill(states_.begin(), states_.end(), std::uint8_t(0));
}

void SoundCells::make_room(std::int64_t cell_count) const {
  const std::lock_guard lock(mutex_);
  if (room_.load(std::memory_order_relaxed))
    return;
  states_.resize_discard(std::size_t(cell_count));
  std::fill(states_.begin(), states_.end(), std::uint8_t(0));
  room_.store(states_.data(), std::memory_order_release);
}

SoundCells::Known SoundCells::known(std::int64_t cell) const {
  std::uint8_t* const states = room_.load(std::memory_order_acquire);
  if (!states || std::size_t(cell) >= states_.size())
    return Known::unknown;
  const std::uint8_t state = State(states[cell]).load(std::memory_order_relaxed);
  return unsigned(state >> 2) == epoch_ ? Known(state & 3) : Known::unknown;
}

void SoundCells::find(std::int64_t cell_count, mesh::Shape shape,
                      std::span<const Asked> asked) const {
  std::uint8_t* states = room_.load(std::memory_order_acquire);
  if (!states) {
    make_room(cell_count);
    states = room_.load(std::memory_order_acquire);
  }
  cells::CellBlock block;
  for (std::size_t first = 0; first < asked.size(); first += cells::CellBlock::size) {
    const auto part =
        asked.subspan(first, std::min<std::size_t>(cells::CellBlock::size, asked.size() - first));
    block.count = int(part.size());
    for (int k = 0; k < block.count; ++k)
      block.set(mesh::vertex_count(shape), k, part[std::size_t(k)].vertices);
    const cells::CellKinds kinds = cells::kinds_of(shape, block);
    const std::uint64_t right_way = are_inverted_ ? kinds.inverted : ~kinds.inverted;
    const std::uint64_t sound = right_way & ~(kinds.folded | kinds.flat);
    for (int k = 0; k < block.count; ++k) {
      const Asked& a = part[std::size_t(k)];
      *a.to = sound >> k & 1 ? Known::sound : Known::odd;
      if (std::size_t(a.cell) < states_.size())
        State(states[a.cell])
            .store(std::uint8_t(epoch_ << 2 | unsigned(*a.to)), std::memory_order_relaxed);
    }
  }
}

bool SoundCells::is_sound(const mesh::MeshView& mesh, std::int64_t cell) const {
  Known state = known(cell);
  if (state == Known::unknown) {
    mesh::CellVertices c;
    mesh::gather(mesh, cell, c);
    const Asked asked[] = {{cell, c.x, &state}};
    find(mesh.cell_count(), c.shape, asked);
  }
  return state == Known::sound;
}

} // namespace insitu::query
