// The kernels behind the structures of the rays, as they run on the host, against the processor's.
#include <gtest/gtest.h>

#include "accel/optix/kernels.h"
#include "accel/tree/cell_boxes.h"
#include "gpu_mesh.h"

using namespace insitu;

namespace {

struct Kernels : testing::Test {
  core::Memory memory;
};

} // namespace

TEST_F(Kernels, BoxesOfCellsAreThoseOfTheTree) {
  for (const test::Case& c : test::cases) {
    const test::TestMesh from = test::make_mesh(c.options, 21);
    const test::RayMesh mesh(from);
    const std::int64_t n = mesh.view().cell_count(), first = n / 3;
    const math::Vec3d origin = 0.5 * (from.low + from.high);
    std::vector<std::uint32_t> reversed;
    for (std::int64_t i = n; i-- > 0;)
      reversed.push_back(std::uint32_t(i));
    const accel::CellBoxes expected(mesh.view(), origin);
    for (const bool in_order : {true, false}) {
      const std::uint32_t* const cells = in_order ? nullptr : reversed.data();
      std::vector<accel::Box> got(std::size_t(n - first));
      accel::optix::fill_cell_boxes(mesh.view(), origin, cells, first, n - first, got.data(),
                                    nullptr);
      for (std::int64_t i = first; i < n; ++i) {
        const auto id = cells ? cells[i] : std::uint32_t(i);
        accel::Box box;
        expected.compute(&id, 1, 0, &box);
        for (int a = 0; a < 3; ++a) {
          ASSERT_EQ(got[std::size_t(i - first)].lower[a], box.lower[a]) << c.name;
          ASSERT_EQ(got[std::size_t(i - first)].upper[a], box.upper[a]) << c.name;
        }
      }
    }
  }
}

TEST_F(Kernels, TheLongestDistanceIsThatOfFaces) {
  device::Buffer<std::uint32_t> scratch(memory);
  for (const test::Case& c : test::cases) {
    const test::RayMesh mesh(test::make_mesh(c.options, 22));
    EXPECT_EQ(accel::optix::longest_distance(mesh.view(), nullptr, mesh.view().cell_count(),
                                             scratch, nullptr),
              accel::MeshFaces::longest_distance(mesh.view(), mesh.on_cpu.threads))
        << c.name;
  }
}

TEST_F(Kernels, QuadsThatTurnAreSeen) {
  device::Buffer<std::uint32_t> scratch(memory);
  test::TestMesh from = test::make_mesh({.kind = test::MeshKind::hexahedra, .size = 1}, 23);
  test::Random random(24);
  for (math::Vec3d& v : from.vertices) // all six faces are curved
    v += random.uniform({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  const test::RayMesh mesh(from);
  core::Buffer<accel::FaceTriangle> triangles(memory, INSITU_MEMORY_BUILD);
  mesh.faces.triangles(mesh.view(), mesh.on_cpu.threads, accel::Method::shared_bilinear_faces,
                       triangles);
  ASSERT_EQ(triangles.size(), 24u);
  const auto turned = [&](double mirror) {
    std::vector<float> x;
    for (const math::Vec3d& v : from.vertices)
      x.insert(x.end(), {float(mirror * v.x), float(v.y), float(v.z)});
    return accel::optix::quads_turned(triangles.data(), std::int64_t(triangles.size()), x.data(),
                                      scratch, nullptr);
  };
  EXPECT_FALSE(turned(1.0));
  EXPECT_TRUE(turned(-1.0)); // the mirror image turns every tetrahedron inside out
}
