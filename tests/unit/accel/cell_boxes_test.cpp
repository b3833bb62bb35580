// Cell boxes and blocks of cells by the typed loops, beside the cells gathered one by one, for
// every layout and number type; coordinates end where memory does.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

#include "accel/tree/cell_boxes.h"
#include "cells/kernels/gather.h"
#include "core/random.h"
#include "fixtures/arrays.h"
#include "fixtures/simd_targets.h"

namespace insitu::accel {
namespace {

double unit(std::uint64_t i, std::uint64_t channel) {
  return core::random_unit(95, i, channel);
}

constexpr std::int64_t vertices = 60; // 3 x 4 x 5 of a block

template <class Real>
struct Points {
  bool interleaved;
  fixtures::GuardedBytes bytes{3 * vertices * sizeof(Real)};

  explicit Points(bool records) : interleaved(records) {
    for (std::int64_t v = 0; v < vertices; ++v)
      for (int a = 0; a < 3; ++a)
        at(v, a) = Real(100.0 * unit(std::uint64_t(v), std::uint64_t(a)) - 30.0);
  }
  Real& at(std::int64_t v, int a) {
    return reinterpret_cast<Real*>(bytes.data())[interleaved ? 3 * v + a : a * vertices + v];
  }
  mesh::PointsView view() {
    mesh::PointsView out;
    for (int a = 0; a < 3; ++a)
      out.component[a] = reinterpret_cast<const std::byte*>(&at(0, a));
    out.layout.count = vertices;
    out.layout.stride[0] = std::int64_t((interleaved ? 3 : 1) * sizeof(Real));
    out.is_float32 = sizeof(Real) == 4;
    return out;
  }
};

constexpr std::uint8_t shapes[] = {12, 10, 13, 14, 11};
constexpr int counts[] = {8, 4, 6, 5, 8};

/// Cells in arrays of one layout: of one kind of the above, or, unless they are UNIFORM, of all. A
/// cell's ids are `stride` indices apart. They end where memory does.
template <class Index>
struct Cells {
  std::optional<fixtures::GuardedBytes> ids, offsets, types;
  mesh::PieceView piece;

  Cells(mesh::CellLayout layout, Index base, std::size_t only = 2, std::size_t stride = 1) {
    constexpr std::int64_t n = 300;
    std::vector<Index> all_ids, all_offsets;
    std::vector<std::uint8_t> all_types;
    for (std::int64_t c = 0; c < n; ++c) {
      const std::size_t kind = layout == mesh::CellLayout::uniform
                                   ? only
                                   : core::random_bits(96, std::uint64_t(c), 0) %
                                         (layout == mesh::CellLayout::padded ? 4 : 5);
      all_offsets.push_back(Index(Index(all_ids.size()) + base));
      all_types.push_back(shapes[kind]);
      const auto add = [&](Index id) {
        all_ids.resize(all_ids.empty() ? 0 : all_ids.size() + stride - 1, Index(1 << 30));
        all_ids.push_back(id);
      };
      for (int v = 0; v < 8; ++v) {
        if (v < counts[kind])
          add(Index(
              Index(core::random_bits(97, std::uint64_t(8 * c + v), 0) % std::uint64_t(vertices)) +
              base));
        else if (layout == mesh::CellLayout::padded)
          add(-1);
      }
    }
    all_offsets.push_back(Index(Index(all_ids.size()) + base));
    const std::int64_t index_bytes = sizeof(Index), id_bytes = index_bytes * std::int64_t(stride);
    piece.layout = layout;
    piece.uniform_shape =
        layout == mesh::CellLayout::uniform ? mesh::Shape(shapes[only]) : mesh::Shape::hexahedron;
    piece.cell_count = n;
    piece.vertex_count = vertices;
    const std::int64_t a_cell = layout == mesh::CellLayout::uniform  ? counts[only] * id_bytes
                                : layout == mesh::CellLayout::padded ? 8 * id_bytes
                                                                     : index_bytes;
    ids.emplace(fixtures::GuardedBytes::copy_of(all_ids));
    offsets.emplace(fixtures::GuardedBytes::copy_of(all_offsets));
    types.emplace(fixtures::GuardedBytes::copy_of(all_types));
    const bool is_int32 = sizeof(Index) == 4;
    piece.connectivity = {ids->data(), std::int64_t(all_ids.size()), a_cell, is_int32};
    piece.id_stride = id_bytes;
    piece.offsets = {offsets->data(), std::int64_t(all_offsets.size()), index_bytes, is_int32};
    piece.types = types->data();
    piece.index_base = base;
  }
};

void expect_blocks(const mesh::MeshView& view) {
  const cells::CellGather gather(view, 1.0);
  for (int shape = 10; shape <= 14; ++shape) {
    std::vector<std::int64_t> ids; // not in the solver's order
    for (std::int64_t i = 0, n = view.cell_count(); i < n; ++i)
      if (gather.shape(i * 7 % n) == mesh::Shape(shape))
        ids.push_back(i * 7 % n);
    cells::CellBlock block{};
    for (std::size_t first = 0; first < ids.size(); first += cells::CellBlock::size) {
      block.count = int(std::min<std::size_t>(ids.size() - first, cells::CellBlock::size));
      gather.fill(&ids[first], block.count, int(ids.size() - first) - block.count, block);
      for (int k = 0; k < block.count; ++k) {
        mesh::CellVertices cell;
        mesh::gather(view, ids[first + std::size_t(k)], cell);
        ASSERT_EQ(int(cell.shape), shape);
        math::Vec3d x[8];
        block.get(cell.shape, k, x);
        ASSERT_EQ(std::memcmp(x, cell.x, std::size_t(cell.count) * sizeof *x), 0)
            << "cell " << ids[first + std::size_t(k)];
      }
    }
  }
}

void expect_boxes(const std::vector<mesh::PieceView>& pieces) {
  std::vector<std::int64_t> first_cell{0}, first_vertex{0};
  for (const mesh::PieceView& p : pieces) {
    first_cell.push_back(first_cell.back() + p.cell_count);
    first_vertex.push_back(first_vertex.back() + p.vertex_count);
  }
  mesh::MeshView view;
  view.pieces = pieces.data();
  view.first_cell = first_cell.data();
  view.first_vertex = first_vertex.data();
  view.piece_count = std::int32_t(pieces.size());
  expect_blocks(view);

  const auto n = std::uint32_t(view.cell_count());
  const math::Vec3d origin{1.5, -2.25, 0.125};
  for (const std::uint32_t step : {1u, 7u}) { // in the solver's order, and not
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < n; ++i)
      ids.push_back(std::uint32_t(std::uint64_t(i) * step % n));
    std::vector<Box> boxes(n);
    std::int64_t refused = -1;
    for (std::uint32_t i = 0; i < n; ++i) {
      mesh::CellVertices cell;
      mesh::gather(view, ids[i], cell);
      for (int v = 0; v < cell.count; ++v)
        for (int a = 0; a < 3; ++a)
          if (!std::isfinite(cell.x[v][a]) && (refused < 0 || ids[i] < refused))
            refused = ids[i];
    }
    ASSERT_EQ(CellBoxes(view, origin).compute(ids.data(), n, 0, boxes.data()), refused);
    for (std::uint32_t i = 0; i < n; ++i) {
      mesh::CellVertices cell;
      mesh::gather(view, ids[i], cell);
      Box expected;
      bool good = true;
      for (int a = 0; a < 3; ++a) {
        double lo = 1e300, hi = -1e300;
        for (int v = 0; v < cell.count; ++v) {
          good = good && std::isfinite(cell.x[v][a]);
          lo = std::fmin(lo, cell.x[v][a]);
          hi = std::fmax(hi, cell.x[v][a]);
        }
        expected.lower[a] = round_down(lo - origin[a]);
        expected.upper[a] = round_up(hi - origin[a]);
      }
      if (!good)
        expected = Box{};
      for (int a = 0; a < 3; ++a) {
        ASSERT_EQ(boxes[i].lower[a], expected.lower[a]) << "cell " << ids[i];
        ASSERT_EQ(boxes[i].upper[a], expected.upper[a]) << "cell " << ids[i];
      }
    }
  }
}

template <class Real, class Index>
void expect_layouts() {
  for (const bool interleaved : {true, false}) {
    Points<Real> points(interleaved);
    std::vector<mesh::PieceView> pieces;
    for (const Index base : {Index(0), Index(1)}) {
      const auto expect = [&](Cells<Index> cells) {
        cells.piece.points = points.view();
        expect_boxes({cells.piece});
        const Real good = points.at(17, 1);
        points.at(17, 1) = Real(NAN);
        expect_boxes({cells.piece});
        points.at(17, 1) = good;
      };
      expect({mesh::CellLayout::mixed, base});
      expect({mesh::CellLayout::padded, base});
      for (std::size_t kind = 0; kind < std::size(shapes); ++kind)
        for (const std::size_t stride : {1, 3})
          expect({mesh::CellLayout::uniform, base, kind, stride});
    }
    Cells<Index> mixed(mesh::CellLayout::mixed, 1), uniform(mesh::CellLayout::uniform, 0);
    mixed.piece.points = uniform.piece.points = points.view();

    // A block; once its vertices in Fortran order of the axes, and once with implicit points.
    mesh::PieceView block;
    block.layout = mesh::CellLayout::block;
    block.uniform_shape = mesh::Shape::hexahedron;
    block.block_vertices[0] = 3;
    block.block_vertices[1] = 4;
    block.block_vertices[2] = 5;
    block.cell_count = 2 * 3 * 4;
    block.vertex_count = vertices;
    block.points = points.view();
    expect_boxes({block});
    mesh::PieceView turned = block;
    mesh::ItemLayout& layout = turned.points.layout;
    const std::int64_t size = layout.stride[0];
    layout.linear = false;
    layout.extent[0] = 3;
    layout.extent[1] = 4;
    layout.stride[0] = 20 * size;
    layout.stride[1] = 5 * size;
    layout.stride[2] = size;
    expect_boxes({turned});
    mesh::PieceView implicit = block;
    implicit.implicit_points = true;
    for (int a = 0; a < 3; ++a) {
      implicit.origin[a] = a;
      implicit.spacing[a] = 0.1;
    }
    expect_boxes({mixed.piece, block, uniform.piece, implicit, turned, mixed.piece});
  }
}

TEST(CellLoops, OfEveryLayoutAndType) {
  for (const std::int64_t target : fixtures::simd_targets()) {
    fixtures::use_simd_target(target);
    SCOPED_TRACE(hwy::TargetName(target));
    expect_layouts<double, std::int32_t>();
    expect_layouts<double, std::int64_t>();
    expect_layouts<float, std::int32_t>();
    expect_layouts<float, std::int64_t>();
  }
  fixtures::use_simd_target(0);
}

} // namespace
} // namespace insitu::accel
