// A solver that gives cells by faces: whatever its bytes say, every call ends in a status with a
// message, never in a crash, and nothing is read outside the arrays. Input is a good mesh of faces,
// chosen by the first byte, then changes of its arrays and calls, a few bytes each.
#include <cstdint>
#include <iterator>
#include <limits>
#include <vector>

#include "promises.h"

namespace {

using fuzz::Bytes;
using fuzz::check;
using fuzz::require;

/// Cells by their rings, in arrays of int32 or int64 that are as large as they claim to be.
class Solver {
public:
  explicit Solver(Bytes input) : in_(input) {}

  void run() {
    make();
    give();
    for (int calls = 0; calls < 24 && !in_.empty(); ++calls)
      call();
    ask();
  }

private:
  enum Which { vertices, offsets, owner, neighbour, cell_faces, cell_offsets, arrays };

  /// A cube with a pyramid on it, as two cells or one; or a prism over a hexagon beside a cube.
  void make() {
    const unsigned kind = in_.below(3);
    std::vector<std::vector<int>> rings;
    std::vector<std::vector<int>> cells;
    if (kind < 2) {
      points_ = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, .5, .5, 2};
      rings = {{4, 5, 6, 7}, {0, 1, 2, 3}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6},
               {3, 0, 4, 7}, {4, 5, 8},    {5, 6, 8},    {6, 7, 8},    {7, 4, 8}};
      cells = {{0, 1, 2, 3, 4, 5}, {0, 6, 7, 8, 9}};
      if (kind == 1) {
        rings.erase(rings.begin());
        cells = {{0, 1, 2, 3, 4, 5, 6, 7, 8}};
      }
    } else {
      points_ = {1, 0, 0, 2, 0, 0, 3, 1, 0, 2, 2, 0, 1, 2, 0, 0, 1, 0, 1, 0, 1, 2, 0, 1, 3, 1, 1,
                 2, 2, 1, 1, 2, 1, 0, 1, 1, 1, 0, 2, 2, 0, 2, 3, 1, 2, 2, 2, 2, 1, 2, 2, 0, 1, 2};
      rings = {{6, 7, 8, 9, 10, 11}, {0, 1, 2, 3, 4, 5}, {12, 13, 14, 15, 16, 17}};
      cells = {{0, 1}, {0, 2}};
      for (int level = 0; level < 2; ++level)
        for (int k = 0; k < 6; ++k) {
          const int a = 6 * level + k, b = 6 * level + (k + 1) % 6;
          cells[std::size_t(level)].push_back(int(rings.size()));
          rings.push_back({a, b, b + 6, a + 6});
        }
    }
    base_ = std::int32_t(in_.below(2));
    by_cell_ = in_.one_in(2);
    std::vector<std::vector<int>> of(rings.size());
    for (std::size_t c = 0; c < cells.size(); ++c)
      for (const int f : cells[c])
        of[std::size_t(f)].push_back(int(c));
    for (std::size_t f = 0; f < rings.size(); ++f) { // those between two cells come first
      put(offsets, std::int64_t(ids_[vertices].size()));
      for (const int v : rings[f])
        put(vertices, v);
      put(owner, of[f][0]);
      if (of[f].size() == 2)
        put(neighbour, of[f][1]);
    }
    put(offsets, std::int64_t(ids_[vertices].size()));
    for (const auto& cell : cells) {
      put(cell_offsets, std::int64_t(ids_[cell_faces].size()));
      for (const int f : cell)
        put(cell_faces, f);
    }
    put(cell_offsets, std::int64_t(ids_[cell_faces].size()));
    faces_ = std::int64_t(rings.size());
    cells_ = std::int64_t(cells.size());
    values_.assign(points_.size() / 3, 1.0);
    ghosts_.assign(std::size_t(cells_), 0);
  }
  void put(Which which, std::int64_t id) { ids_[which].push_back(id + base_); }

  /// The array in one of the layouts; memory of its own, so that reads outside of it are seen.
  insitu_array array(Which which) {
    const std::vector<std::int64_t>& ids = ids_[which];
    const auto n = std::int64_t(ids.size());
    if (in_.one_in(16)) {
      insitu_array a = insitu_array_of(ids.data(), INSITU_INT64, n, 1);
      fuzz::make_impossible(in_, a);
      return a;
    }
    if (in_.one_in(2)) {
      narrow_[which].assign(ids.begin(), ids.end());
      if (n == 0 || !in_.one_in(4))
        return insitu_array_of(narrow_[which].data(), INSITU_INT32, n, 1);
      narrow_[which].assign(ids.rbegin(), ids.rend());
      insitu_array a = insitu_array_of(narrow_[which].data() + n - 1, INSITU_INT32, n, 1);
      a.stride[0] = -4;
      return a;
    }
    wide_[which] = ids;
    return insitu_array_of(wide_[which].data(), INSITU_INT64, n, 1);
  }

  void give() {
    insitu_array a =
        insitu_array_of(points_.data(), INSITU_FLOAT64, std::int64_t(points_.size()) / 3, 3);
    check(insitu_mesh_points(mesh_, 0, &a, 1));
    insitu_faces f = insitu_faces_default();
    f.form = by_cell_ ? INSITU_FACES_CELLS : INSITU_FACES_OWNERS;
    f.index_base = base_;
    f.cell_count = cells_;
    f.face_count = faces_;
    f.vertices = array(vertices);
    f.offsets = array(offsets);
    if (by_cell_) {
      f.cell_faces = array(cell_faces);
      f.cell_offsets = array(cell_offsets);
    } else {
      f.owner = array(owner);
      f.neighbour = array(neighbour);
    }
    if (in_.one_in(16)) {
      constexpr std::int64_t wild[] = {-1, 0, std::numeric_limits<std::int64_t>::max(), 7};
      std::int64_t* const counts[] = {&f.cell_count, &f.face_count, &f.far_cells,
                                      &f.boundary_count};
      *counts[in_.below(4)] = wild[in_.below(4)];
    }
    check(insitu_mesh_faces(mesh_, 0, &f));
    a = insitu_array_of(values_.data(), INSITU_FLOAT64, std::int64_t(values_.size()), 1);
    check(insitu_mesh_field(mesh_, 0, "f", INSITU_VERTEX, &a, 1));
    a = insitu_array_of(ghosts_.data(), INSITU_UINT8, cells_, 1);
    check(insitu_mesh_ghosts(mesh_, 0, in_.one_in(4) ? &a : nullptr, INSITU_GHOSTS_VTK));
  }

  std::int64_t index() {
    constexpr std::int64_t special[] = {-1,        std::numeric_limits<std::int64_t>::min(),
                                        INT32_MAX, std::numeric_limits<std::int64_t>::max(),
                                        INT32_MIN, 64};
    return in_.one_in(8) ? special[in_.below(6)] : std::int64_t(in_.below(24));
  }

  void call() {
    switch (in_.below(7)) {
    case 0:
    case 1: { // another id somewhere, given anew
      std::vector<std::int64_t>& ids = ids_[in_.below(arrays)];
      if (!ids.empty())
        ids[in_.byte() % ids.size()] = index();
      give();
      break;
    }
    case 2: // a vertex moves
      points_[in_.byte() % points_.size()] = in_.real();
      check(
          insitu_mesh_changed(mesh_, in_.one_in(2) ? INSITU_CHANGED_ALL : INSITU_CHANGED_GEOMETRY));
      break;
    case 3:
      ghosts_[in_.byte() % ghosts_.size()] = std::uint8_t(in_.below(3));
      check(insitu_mesh_changed(mesh_, INSITU_CHANGED_ALL));
      break;
    case 4: {
      insitu_validation v = insitu_validation_default();
      check(insitu_mesh_validate(mesh_, &v));
      require(v.folded_cells <= v.cells && v.collapsed_cells <= v.cells, "counts of cells");
      break;
    }
    case 5:
      by_cell_ = !by_cell_;
      give();
      break;
    default:
      ask();
    }
  }

  void ask() {
    insitu_commit_report report;
    if (fuzz::commit(mesh_, report))
      fuzz::ask(in_, mesh_, report.cells, true);
  }

  Bytes in_;
  std::vector<double> points_, values_;
  std::vector<std::uint8_t> ghosts_;
  std::vector<std::int64_t> ids_[arrays], wide_[arrays];
  std::vector<std::int32_t> narrow_[arrays];
  std::int64_t faces_ = 0, cells_ = 0;
  std::int32_t base_ = 0;
  bool by_cell_ = false;
  const fuzz::Session session_{}; ///< closed before the arrays go
  const insitu_mesh mesh_ = session_.mesh;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Solver(Bytes(data, size)).run();
  return 0;
}
