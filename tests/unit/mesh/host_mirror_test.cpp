// Copies of device arrays for the host. Arrays of the host that are said to lie on a device stand
// for them: what counts is that the mirror reads its copies, and every array finds its own.
#include <cstring>
#include <gtest/gtest.h>

#include "core/device_memory.h"
#include "mesh/registered/host_mirror.h"

using namespace insitu;

namespace {

insitu_array on_device(insitu_array a) {
  a.memory = INSITU_DEVICE;
  return a;
}

void copy(std::byte* to, const std::byte* from, std::size_t bytes) {
  std::memcpy(to, from, bytes);
}

} // namespace

TEST(HostMirror, ReadsCopiesOfEveryArray) {
  if (!core::device_memory_supported())
    GTEST_SKIP() << "without CUDA arrays in device memory are refused";
  // Vertices as records, backwards, with the coordinates apart; ids counted from 1; ghosts.
  struct Vertex {
    double x;
    int unused;
    double y, z;
  };
  std::vector<Vertex> vertices(8);
  for (std::size_t v = 0; v < 8; ++v) // in VTK's order of a unit cube, from the end on
    vertices[7 - v] = {double(v == 1 || v == 2 || v == 5 || v == 6), 0,
                       double(v == 2 || v == 3 || v == 6 || v == 7), double(v > 3)};
  std::vector<std::int64_t> ids{1, 2, 3, 4, 5, 6, 7, 8};
  std::vector<std::uint8_t> ghosts{0};
  core::Memory memory;
  mesh::Mesh mesh("m", memory);
  insitu_array points[3];
  const double* first[] = {&vertices[7].x, &vertices[7].y, &vertices[7].z};
  for (int a = 0; a < 3; ++a) {
    points[a] = on_device(insitu_array_of(first[a], INSITU_FLOAT64, 8, 1));
    points[a].stride[0] = -std::int64_t(sizeof(Vertex));
  }
  mesh.set_points(0, points, 3);
  insitu_cells cells = insitu_cells_default();
  cells.count = 1;
  cells.index_base = 1;
  cells.connectivity = on_device(insitu_array_of(ids.data(), INSITU_INT64, 1, 8));
  mesh.set_cells(0, &cells);
  const insitu_array ghost = insitu_array_of(ghosts.data(), INSITU_UINT8, 1, 1); // on the host
  mesh.set_ghosts(0, &ghost, INSITU_GHOSTS_VTK);
  mesh.update();
  EXPECT_TRUE(mesh.lies_on_device());

  mesh::CellVertices before;
  mesh::gather(mesh.view(), 0, before);
  const mesh::HostMirror mirror(
      mesh, [](std::byte* to, const std::byte* from, std::size_t n) { copy(to, from, n); });
  for (Vertex& v : vertices) // the mirror does not see it
    v = {};
  ids.assign(8, 77);
  mesh::CellVertices after;
  mesh::gather(mirror.view(), 0, after);
  ASSERT_EQ(after.count, 8);
  for (int v = 0; v < 8; ++v) {
    EXPECT_EQ(after.ids[v], v);
    EXPECT_EQ(after.x[v], before.x[v]) << v;
  }
  EXPECT_EQ(mirror.view().pieces[0].ghosts, reinterpret_cast<const std::byte*>(ghosts.data()))
      << "host arrays are read where they are";
}
