// The three connectivity layouts, both index types and bases, and the three kinds of blocks, in
// either order of memory, all gather the same cells.
#include <gtest/gtest.h>
#include <numeric>

#include "core/status.h"
#include "fixtures/committed.h"

using namespace insitu;
using math::Vec3d;

namespace {

test::TestMesh mixed_mesh() {
  return test::make_mesh({.kind = test::MeshKind::mixed, .size = 3}, 11);
}

std::vector<mesh::CellVertices> gather_all(const mesh::MeshView& view) {
  std::vector<mesh::CellVertices> cells(std::size_t(view.cell_count()));
  for (std::size_t c = 0; c < cells.size(); ++c)
    mesh::gather(view, std::int64_t(c), cells[c]);
  return cells;
}

void expect_same(const std::vector<mesh::CellVertices>& a,
                 const std::vector<mesh::CellVertices>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t c = 0; c < a.size(); ++c) {
    ASSERT_EQ(a[c].shape, b[c].shape) << "cell " << c;
    ASSERT_EQ(a[c].count, b[c].count);
    for (int v = 0; v < a[c].count; ++v) {
      ASSERT_EQ(a[c].ids[v], b[c].ids[v]) << "cell " << c;
      ASSERT_EQ(a[c].x[v], b[c].x[v]) << "cell " << c;
    }
  }
}

template <class Index>
std::vector<Index> based(const std::vector<std::int64_t>& values, int base) {
  std::vector<Index> out;
  for (const std::int64_t v : values)
    out.push_back(Index(v + base));
  return out;
}

/// Registers the mixed mesh with ids of this type and base, mixed or padded; its gathered cells.
template <class Index>
std::vector<mesh::CellVertices> gather_with(const fixtures::SolverArrays& arrays, bool padded,
                                            int base, std::size_t offsets) {
  const insitu_type type = sizeof(Index) == 4 ? INSITU_INT32 : INSITU_INT64;
  std::vector<Index> ids, starts;
  if (padded)
    for (std::size_t c = 0; c < arrays.types.size(); ++c)
      for (std::int64_t v = 0; v < 8; ++v) {
        const std::int64_t at = arrays.offsets[c] + v;
        ids.push_back(at < arrays.offsets[c + 1] ? Index(arrays.ids[std::size_t(at)] + base)
                                                 : Index(-1));
      }
  else
    ids = based<Index>({arrays.ids.begin(), arrays.ids.end()}, base);
  starts = based<Index>(arrays.offsets, base);
  insitu_cells cells = insitu_cells_default();
  cells.layout = padded ? INSITU_LAYOUT_PADDED : INSITU_LAYOUT_MIXED;
  cells.count = arrays.cell_count();
  cells.index_base = base;
  cells.connectivity = padded ? insitu_array_of(ids.data(), type, cells.count, 8)
                              : insitu_array_of(ids.data(), type, std::int64_t(ids.size()), 1);
  cells.types = insitu_array_of(arrays.types.data(), INSITU_UINT8, cells.count, 1);
  cells.offsets = insitu_array_of(starts.data(), type, std::int64_t(offsets), 1);
  fixtures::Committed m;
  const insitu_array points = arrays.point_array();
  m.mesh.mesh().set_points(0, &points, 1);
  m.mesh.mesh().set_cells(0, &cells);
  m.commit();
  return gather_all(m.mesh.mesh().view());
}

} // namespace

TEST(Layouts, GatherTheSameCells) {
  const fixtures::SolverArrays arrays{mixed_mesh()};
  const std::size_t n = arrays.types.size();
  const auto expected = gather_with<std::int32_t>(arrays, false, 0, n + 1);
  std::size_t at = 0;
  for (std::size_t c = 0; c < n; ++c) {
    ASSERT_EQ(int(expected[c].shape), int(arrays.types[c]));
    for (int v = 0; v < expected[c].count; ++v)
      ASSERT_EQ(expected[c].ids[v], arrays.ids[at++]);
  }
  for (const int base : {0, 1})
    for (const bool padded : {false, true})
      for (const std::size_t offsets : {n, n + 1}) {
        expect_same(gather_with<std::int32_t>(arrays, padded, base, offsets), expected);
        expect_same(gather_with<std::int64_t>(arrays, padded, base, offsets), expected);
      }
}

TEST(Layouts, UniformCellsMayBeColumnsOrRecords) {
  test::Random random(12);
  test::MeshOptions options;
  options.kind = test::MeshKind::tetrahedra;
  options.size = 3;
  const fixtures::Committed whole(test::make_mesh(options, random));
  const fixtures::SolverArrays& arrays = whole.arrays;
  const auto expected = gather_all(whole.mesh.mesh().view());
  const auto n = std::size_t(arrays.cell_count());
  fixtures::Committed other;
  const insitu_array points = arrays.point_array();
  insitu_cells cells = arrays.cells();
  other.mesh.mesh().set_points(0, &points, 1);

  std::vector<std::int32_t> columns(4 * n); // all first ids, all second ids, ...
  for (std::size_t c = 0; c < n; ++c)
    for (std::size_t v = 0; v < 4; ++v)
      columns[v * n + c] = arrays.ids[4 * c + v];
  cells.connectivity.data = columns.data();
  cells.connectivity.component_stride = std::int64_t(4 * n);
  other.mesh.mesh().set_cells(0, &cells);
  other.commit();
  expect_same(gather_all(other.mesh.mesh().view()), expected);

  constexpr std::size_t record = 4 * 4 + 3; // packed records of an odd size
  std::vector<std::byte> records(record * n);
  for (std::size_t c = 0; c < n; ++c)
    std::memcpy(&records[record * c], &arrays.ids[4 * c], 16);
  cells.connectivity.data = records.data();
  cells.connectivity.component_stride = 0;
  cells.connectivity.stride[0] = std::int64_t(record);
  other.mesh.mesh().set_cells(0, &cells);
  other.commit();
  expect_same(gather_all(other.mesh.mesh().view()), expected);

  // Backwards: cell c is the solver's last but c.
  cells.connectivity = insitu_array_of(&arrays.ids[4 * (n - 1)], INSITU_INT32, std::int64_t(n), 4);
  cells.connectivity.stride[0] = -16;
  other.mesh.mesh().set_cells(0, &cells);
  other.commit();
  auto reversed = gather_all(other.mesh.mesh().view());
  std::reverse(reversed.begin(), reversed.end());
  expect_same(reversed, expected);
}

namespace {

constexpr std::int64_t block_n[3] = {4, 3, 5};

double axis_value(int a, std::int64_t i) {
  return 0.5 * double(a) + 0.25 * double(i);
}

void expect_block_cells(const fixtures::Committed& m, auto&& point_at) {
  const mesh::MeshView& view = m.mesh.mesh().view();
  const std::int64_t ci = block_n[0] - 1, cj = block_n[1] - 1, ck = block_n[2] - 1;
  ASSERT_EQ(view.cell_count(), ci * cj * ck);
  ASSERT_EQ(view.vertex_count(), block_n[0] * block_n[1] * block_n[2]);
  constexpr int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const auto cells = gather_all(view);
  for (std::int64_t k = 0; k < ck; ++k)
    for (std::int64_t j = 0; j < cj; ++j)
      for (std::int64_t i = 0; i < ci; ++i) {
        const mesh::CellVertices& cell = cells[std::size_t(i + ci * (j + cj * k))];
        ASSERT_EQ(cell.shape, mesh::Shape::hexahedron);
        for (int v = 0; v < 8; ++v)
          ASSERT_EQ(cell.x[v], point_at(i + corner[v][0], j + corner[v][1], k + corner[v][2]))
              << "cell " << i << " " << j << " " << k << ", vertex " << v;
      }
}

} // namespace

TEST(Blocks, UniformOnesComeFromOriginAndSpacing) {
  fixtures::Committed m;
  insitu_block block = insitu_block_default();
  block.kind = INSITU_BLOCK_UNIFORM;
  for (int a = 0; a < 3; ++a) {
    block.vertices[a] = block_n[a];
    block.origin[a] = axis_value(a, 0);
    block.spacing[a] = a == 1 ? -0.25 : 0.25;
  }
  m.mesh.mesh().set_block(0, &block);
  m.commit();
  expect_block_cells(m, [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return Vec3d{axis_value(0, i), 0.5 - 0.25 * double(j), axis_value(2, k)};
  });
}

TEST(Blocks, RectilinearOnesReadTheirAxes) {
  fixtures::Committed m;
  insitu_block block = insitu_block_default();
  block.kind = INSITU_BLOCK_RECTILINEAR;
  std::vector<float> axes[3];
  for (int a = 0; a < 3; ++a) {
    block.vertices[a] = block_n[a];
    for (std::int64_t i = 0; i < 2 * block_n[a]; ++i) // every second value of a longer array
      axes[a].push_back(i % 2 ? NAN : float(axis_value(a, i / 2)));
    block.coordinates[a] = insitu_array_of(axes[a].data(), INSITU_FLOAT32, block_n[a], 1);
    block.coordinates[a].stride[0] = 8;
  }
  m.mesh.mesh().set_block(0, &block);
  m.commit();
  expect_block_cells(m, [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return Vec3d{axis_value(0, i), axis_value(1, j), axis_value(2, k)};
  });
}

// The block lies inside a larger array with ghost layers of NaN, in Fortran or C order.
TEST(Blocks, CurvilinearOnesLieInLargerArraysOfEitherOrder) {
  constexpr std::int64_t ghosts[3] = {1, 2, 1};
  for (const bool c_order : {false, true}) {
    std::int64_t whole[3], step[3];
    for (int a = 0; a < 3; ++a)
      whole[a] = block_n[a] + 2 * ghosts[a];
    step[c_order ? 2 : 0] = 1;
    step[1] = whole[c_order ? 2 : 0];
    step[c_order ? 0 : 2] = step[1] * whole[1];
    const auto total = std::size_t(whole[0] * whole[1] * whole[2]);
    std::vector<double> x[3], density(total, NAN);
    for (auto& component : x)
      component.assign(total, NAN);
    const auto point_at = [](std::int64_t i, std::int64_t j, std::int64_t k) {
      return Vec3d{double(i) + 0.1 * double(j), double(j) - 0.05 * double(k), double(k)};
    };
    const std::int64_t first = ghosts[0] * step[0] + ghosts[1] * step[1] + ghosts[2] * step[2];
    for (std::int64_t k = 0; k < block_n[2]; ++k)
      for (std::int64_t j = 0; j < block_n[1]; ++j)
        for (std::int64_t i = 0; i < block_n[0]; ++i) {
          const auto at = std::size_t(first + i * step[0] + j * step[1] + k * step[2]);
          for (int a = 0; a < 3; ++a)
            x[a][at] = point_at(i, j, k)[a];
          density[at] = double(i + 10 * j + 100 * k);
        }
    insitu_block block = insitu_block_default();
    insitu_array arrays[3];
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = block_n[a];
      arrays[a] = insitu_array_of(x[a].data() + first, INSITU_FLOAT64, 0, 1);
      for (int d = 0; d < 3; ++d) {
        arrays[a].extent[d] = block_n[d];
        arrays[a].stride[d] = 8 * step[d];
      }
    }
    fixtures::Committed m;
    m.mesh.mesh().set_block(0, &block);
    m.mesh.mesh().set_points(0, arrays, 3);
    insitu_array cell_values = arrays[0]; // cell (i, j, k) has the value of its first vertex
    cell_values.data = density.data() + first;
    for (int d = 0; d < 3; ++d)
      cell_values.extent[d] = block_n[d] - 1;
    m.mesh.mesh().set_field(0, "density", INSITU_CELL, &cell_values, 1);
    m.commit();
    expect_block_cells(m, point_at);
    const mesh::FieldView field = m.mesh.mesh().field("density");
    for (std::int64_t c = 0; c < m.mesh.mesh().view().cell_count(); ++c) {
      const std::int64_t i = c % 3, j = c / 3 % 2, k = c / 6;
      ASSERT_EQ(field.pieces[0].load(c, 0), double(i + 10 * j + 100 * k)) << c_order;
    }
  }
}

TEST(Blocks, WrongOnesAreRefusedByName) {
  fixtures::Committed m;
  const auto refused = [&](auto&& change, const char* text) {
    insitu_block block = insitu_block_default();
    block.kind = INSITU_BLOCK_UNIFORM;
    for (std::int64_t& n : block.vertices)
      n = 3;
    change(block);
    try {
      m.mesh.mesh().set_block(0, &block);
      ADD_FAILURE() << text;
    } catch (const core::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_ARGUMENT);
      EXPECT_NE(std::string(e.what()).find(text), std::string::npos) << e.what();
    }
  };
  refused([](auto& b) { b.size = 0; }, "insitu_block_default");
  refused([](auto& b) { b.kind = insitu_block_kind(5); }, "unknown kind 5");
  refused([](auto& b) { b.vertices[2] = -4; }, "-4 vertices along axis 2");
  refused([](auto& b) { b.spacing[0] = 0; }, "spacing along axis 0");
  refused([](auto& b) { b.spacing[0] = NAN; }, "spacing along axis 0");
  refused([](auto& b) { b.kind = INSITU_BLOCK_RECTILINEAR; }, "axis 0");
  const double x[9] = {};
  refused(
      [&](auto& b) {
        b.kind = INSITU_BLOCK_RECTILINEAR;
        for (auto& c : b.coordinates)
          c = insitu_array_of(x, INSITU_FLOAT64, 3, 1);
        b.coordinates[2].count = 2;
      },
      "coordinates of axis 2: 2 values for 3");
  refused(
      [&](auto& b) {
        b.kind = INSITU_BLOCK_RECTILINEAR;
        for (auto& c : b.coordinates)
          c = insitu_array_of(x, INSITU_FLOAT64, 3, 3);
      },
      "3 components");
}

// Points, cells, fields and ghosts may come in any order, and cells may be given again.
TEST(Registration, ComesInAnyOrder) {
  const fixtures::SolverArrays arrays{mixed_mesh()};
  const auto n = std::size_t(arrays.cell_count());
  std::vector<std::uint8_t> ghosts(n, 0);
  ghosts[3] = 1;
  const insitu_array points = arrays.point_array(),
                     bits = insitu_array_of(ghosts.data(), INSITU_UINT8, std::int64_t(n), 1),
                     values = insitu_array_of(arrays.points.data(), INSITU_FLOAT64,
                                              arrays.vertex_count(), 3);
  const insitu_cells cells = arrays.cells();
  int order[4] = {0, 1, 2, 3};
  do {
    fixtures::Committed m;
    mesh::Mesh& mesh = m.mesh.mesh();
    for (const int step : order) {
      if (step == 0)
        mesh.set_points(0, &points, 1);
      else if (step == 1)
        mesh.set_cells(0, &cells);
      else if (step == 2)
        mesh.set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
      else
        mesh.set_field(0, "f", INSITU_VERTEX, &values, 1);
    }
    m.commit();
    EXPECT_EQ(m.mesh.tree().cell_count(), std::int64_t(n) - 1)
        << order[0] << order[1] << order[2] << order[3];
    EXPECT_FALSE(mesh.view().pieces[0].owns(3));
    EXPECT_EQ(mesh.audit().size(), 6u);
    mesh.set_cells(0, &cells); // again: the ghosts stay
    m.commit();
    EXPECT_EQ(m.mesh.tree().cell_count(), std::int64_t(n) - 1);
    mesh.set_ghosts(0, nullptr, INSITU_GHOSTS_VTK);
    m.commit();
    EXPECT_EQ(m.mesh.tree().cell_count(), std::int64_t(n));
  } while (std::next_permutation(order, order + 4));
}
