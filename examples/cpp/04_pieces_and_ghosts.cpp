// 04: several pieces form one mesh, here two blocks that overlap by a layer of ghost cells. A ghost
// cell owns no point, so each point has one owner.
#include <insitu/insitu.hpp>
#include <iostream>

int main() try {
  // Each piece: 4 x 1 x 1 cells of size 1. Piece 0 from x = 0 to 4, piece 1 from x = 2 to 6. Where
  // they overlap, cell 3 of piece 0 and cell 0 of piece 1 are ghosts (VTK's DUPLICATECELL).
  const std::vector<std::uint8_t> ghosts[2] = {{0, 0, 0, 1}, {1, 0, 0, 0}};
  const std::vector<double> owner[2] = {{0, 1, 2, 3}, {10, 11, 12, 13}};

  insitu::Session session;
  insitu::Mesh mesh = session.mesh("two blocks");
  for (int p = 0; p < 2; ++p) {
    insitu::Piece piece = mesh.piece(p);
    piece.uniform_block({5, 2, 2}, {2.0 * p, 0.0, 0.0}, {1.0, 1.0, 1.0});
    piece.ghosts(ghosts[p]);
    piece.cell_field("owner", owner[p]);
  }
  mesh.commit();

  std::vector<double> points;
  for (int i = 0; i < 6; ++i)
    points.insert(points.end(), {i + 0.5, 0.5, 0.5});
  const insitu::Samples samples = mesh.sample("owner", points);
  for (std::size_t p = 0; p < samples.size(); ++p)
    std::cout << "x = " << points[3 * p] << ": piece " << samples.pieces[p] << ", cell "
              << samples.cells[p] << '\n';
  return samples.values == std::vector<double>{0, 1, 2, 11, 12, 13} ? 0 : 1;
} catch (const insitu::Error& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
