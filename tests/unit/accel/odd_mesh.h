#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "fixtures/committed.h"

namespace insitu::test {

/// A mesh with some of its cells collapsed, along edges, diagonals or to a point, and some there
/// twice or three times. Registered, but not committed: validation may refuse it.
class OddMesh {
public:
  OddMesh(TestMesh from, Random& random)
      : from_(make_odd(std::move(from), random)), arrays_(from_), mesh("odd", memory_) {
    add_piece(0);
  }

  void add_piece(int number) {
    const insitu_array points = arrays_.point_array();
    const insitu_cells cells = arrays_.cells();
    mesh.set_points(number, &points, 1);
    mesh.set_cells(number, &cells);
  }
  /// One cell in five of the first piece.
  void set_ghosts() {
    ghosts_.resize(from_.cells.size());
    for (std::size_t i = 0; i < ghosts_.size(); ++i)
      ghosts_[i] = i % 5 == 2;
    const insitu_array ghosts =
        insitu_array_of(ghosts_.data(), INSITU_UINT8, std::int64_t(ghosts_.size()), 1);
    mesh.set_ghosts(0, &ghosts, INSITU_GHOSTS_ASCENT);
  }

private:
  static TestMesh make_odd(TestMesh m, Random& random) {
    const auto cells = m.cells.size();
    for (std::size_t c = 0; c < cells; c += 3) {
      MeshCell& cell = m.cells[c];
      const int n = mesh::vertex_count(cell.shape);
      if (random.below(2) == 0)
        cell.vertices[std::size_t(random.below(n))] = cell.vertices[std::size_t(random.below(n))];
      else
        for (int k = random.below(3); k >= 0; --k)
          m.cells.push_back(m.cells[std::size_t(random.below(int(cells)))]);
    }
    m.vertices.insert(m.vertices.begin() + 4, {9, 9, 9}); // isolated; and ids move by one
    return m;
  }

  core::Memory memory_;
  TestMesh from_;
  fixtures::SolverArrays arrays_;
  std::vector<std::uint8_t> ghosts_;

public:
  mesh::Mesh mesh;
};

} // namespace insitu::test
