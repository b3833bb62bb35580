// Which cells fold, found cell by cell when somebody asks.
#include <atomic>
#include <latch>
#include <thread>

#include "query/sound_cells.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using query::SoundCells;
using test::box;
using test::kind_name;

namespace {

/// A bit a cell of what the tree marks as odd.
std::vector<bool> odd_cells(const query::Sampler& sampler) {
  const accel::Tree& tree = sampler.tree();
  std::vector<bool> odd(std::size_t(sampler.mesh().cell_count()), false);
  for (std::size_t slot = 0; slot < odd.size(); ++slot)
    if (tree.odd().has(std::uint32_t(slot)))
      odd[std::size_t(tree.cells()[slot])] = true;
  return odd;
}

} // namespace

TEST(SoundCells, AreThoseThatASearchFindsToFoldNowhere) {
  for (const auto kind :
       {test::MeshKind::hexahedra, test::MeshKind::wedges, test::MeshKind::tetrahedra})
    for (const bool with_folds : {false, true}) {
      test::TestMesh mesh = box(kind, 7, 0.1);
      for (test::MeshCell& cell : mesh.cells) {
        const auto x = mesh.cell_vertices(cell);
        if (cell.shape == mesh::Shape::tetrahedron &&
            dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) < 0)
          std::swap(cell.vertices[1], cell.vertices[2]);
      }
      if (with_folds)
        mesh.vertices[3 + 8 * (3 + 8 * 3)] += Vec3d{1.4, 0.3, -0.2};
      const fixtures::Committed m(mesh);
      const mesh::MeshView& view = m.sampler().mesh();
      ASSERT_EQ(view.free_of_folds, !with_folds) << kind_name(kind);
      const std::vector<bool> odd = odd_cells(m.sampler());
      core::Memory memory;
      SoundCells sound(memory);
      sound.begin(false);
      sound.forget();
      // Many threads ask for all cells, each in another order.
      constexpr int threads = 4;
      std::latch start(threads);
      std::atomic<int> wrong{0};
      std::vector<std::thread> pool;
      const auto cells = std::int64_t(odd.size());
      for (int t = 0; t < threads; ++t)
        pool.emplace_back([&, t] {
          start.arrive_and_wait();
          for (std::int64_t i = 0; i < cells; ++i) {
            const std::int64_t cell = (i * (2 * t + 1) + t * cells / threads) % cells;
            wrong += sound.is_sound(view, cell) == odd[std::size_t(cell)];
          }
        });
      for (std::thread& t : pool)
        t.join();
      EXPECT_EQ(wrong, 0) << kind_name(kind) << (with_folds ? ", folded" : "");
      EXPECT_NE(sound.known(0), SoundCells::Known::unknown);
      // After another step nothing is known; after very many neither.
      for (int step = 0; step < 130; ++step) {
        sound.forget();
        ASSERT_EQ(sound.known(0), SoundCells::Known::unknown) << step;
        ASSERT_EQ(sound.is_sound(view, 0), !odd[0]) << step;
      }
    }
}
