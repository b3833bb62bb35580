#include <algorithm>

#include "render/processes/shared_frame.h"

/// Images of cells where other cells are drawn in the place of the solver's (adaptive meshes'
/// duals): owners of tiles ask which of the solver's cells hold the places that are seen.
namespace insitu::render {

void SharedFrame::find_solvers_cells() {
  const SharedTiles& tiles = layers_[0].tiles; // of one mesh alone
  std::vector<TileParcel> questions, answers;
  part_.world.agree_after([&] {
    for_tiles(own_count_, [&](std::size_t i) { complete(i); });
    for (std::size_t i = 0; i < own_count_; ++i)
      if (const std::vector<std::byte> asked = ask_solvers_cells(own_[i]); !asked.empty())
        for (const int source : own_[i].sources)
          questions.push_back({source, own_[i].slot, asked});
  });
  mail_.exchange_in_turns(std::move(questions), [&](const std::vector<TileParcel>& received) {
    const std::size_t before = answers.size();
    answers.resize(before + received.size());
    for_tiles(received.size(), [&](std::size_t i) {
      const TileParcel& asked = received[i];
      answers[before + i] = {asked.rank, asked.slot,
                             answer_solvers_cells(tiles.near_of(asked.slot), asked.reader())};
    });
  });
  mail_.exchange_in_turns(std::move(answers), [&](const std::vector<TileParcel>& received) {
    for (const TileParcel& answer : received)
      take_solvers_cells(tiles.own_of(answer.slot), answer.reader());
  });
}

/// The rays that see a cell, and how far away, as the image of depths has it. Forgets which cell.
std::vector<std::byte> SharedFrame::ask_solvers_cells(OwnTile& tile) const {
  ByteWriter writer;
  const std::span<RayState> rays = rays_of(tile);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    if (rays[r].depth_cell < 0)
      continue;
    rays[r].depth_cell = -1;
    writer.value(std::uint16_t(r));
    writer.value(float(rays[r].depth));
  }
  return writer.bytes();
}

/// Of these rays those that see a place in this process's own cells, with the lowest cell's key.
std::vector<std::byte> SharedFrame::answer_solvers_cells(const NearTile& near,
                                                         ByteReader asked) const {
  ByteWriter writer;
  while (!asked.at_end()) {
    const auto r = asked.value<std::uint16_t>();
    const Ray& ray = near.rays[r].ray;
    const std::int64_t key =
        part_.solvers_cell(ray.origin + double(asked.value<float>()) * ray.direction);
    if (key < 0)
      continue;
    writer.value(r);
    writer.value(key);
  }
  return writer.bytes();
}

void SharedFrame::take_solvers_cells(OwnTile& tile, ByteReader answer) {
  while (!answer.at_end()) {
    std::int64_t& cell = tile.rays[answer.value<std::uint16_t>()].depth_cell;
    const auto key = answer.value<std::int64_t>();
    cell = cell < 0 ? key : std::min(cell, key);
  }
}

} // namespace insitu::render
