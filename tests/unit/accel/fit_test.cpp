#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

#include "accel/tree/cell_boxes.h"
#include "accel/tree/fit.h"
#include "core/random.h"

namespace insitu::accel {
namespace {

double unit(std::uint64_t i, std::uint64_t channel) {
  return core::random_unit(91, i, channel);
}

/// Random children of every scale and offset, some flat, some absent.
void random_children(std::uint64_t i, Node& node, Box* children) {
  const double offset = (unit(i, 0) - 0.5) * std::pow(10.0, 12.0 * unit(i, 1) - 6.0);
  const double size = std::pow(10.0, 12.0 * unit(i, 2) - 8.0);
  std::memset(static_cast<void*>(&node), 0, sizeof node);
  for (int c = 0; c < 8; ++c) {
    const std::uint64_t at = 8 * i + std::uint64_t(c);
    node.meta[c] = c == 0 || unit(at, 3) < 0.7 ? 1 : 0;
    for (int a = 0; a < 3; ++a) {
      const double lo = offset + size * unit(at + 1000000, std::uint64_t(a));
      const double extent = unit(at, 4) < 0.2 ? 0.0 : size * unit(at, std::uint64_t(5 + a % 3));
      children[c].lower[a] = round_down(lo);
      children[c].upper[a] = round_up(lo + extent);
    }
  }
}

TEST(Fit, EncodesTheSameBytesAsTheDefinition) {
  for (std::uint64_t i = 0; i < 20000; ++i) {
    Node expected, node;
    Box children[8];
    random_children(i, expected, children);
    std::memcpy(static_cast<void*>(&node), &expected, sizeof node);
    encode_boxes(expected, children);
    const float area = encode_node(node, children);
    ASSERT_EQ(std::memcmp(&expected, &node, sizeof node), 0) << i;
    float sum = 0.0f;
    for (int c = 0; c < 8; ++c)
      if (node.meta[c]) {
        sum += children[c].half_area();
        const Box decoded = node.child_box(c);
        for (int a = 0; a < 3; ++a) { // outwards
          ASSERT_LE(decoded.lower[a], children[c].lower[a]);
          ASSERT_GE(decoded.upper[a], children[c].upper[a]);
        }
      }
    ASSERT_NEAR(area, sum, 1e-5f * sum);
  }
}

/// Points in memory that ends right before a page nobody may read, interleaved or as three arrays.
template <class Real>
class GuardedPoints {
public:
  GuardedPoints(std::int64_t n, bool interleaved) : n_(n), interleaved_(interleaved) {
    page_ = std::size_t(sysconf(_SC_PAGESIZE));
    const std::size_t bytes = std::size_t(3 * n) * sizeof(Real);
    room_ = (bytes + page_ - 1) / page_ * page_;
    memory_ = static_cast<std::byte*>(
        mmap(nullptr, room_ + page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    mprotect(memory_ + room_, page_, PROT_NONE);
    values_ = reinterpret_cast<Real*>(memory_ + room_ - bytes);
  }
  ~GuardedPoints() { munmap(memory_, room_ + page_); }
  GuardedPoints(const GuardedPoints&) = delete;

  Real& at(std::int64_t id, int a) {
    return interleaved_ ? values_[3 * id + a] : values_[a * n_ + id];
  }
  void view(mesh::PointsView& out) {
    for (int a = 0; a < 3; ++a)
      out.component[a] = reinterpret_cast<const std::byte*>(&at(0, a));
    out.layout.count = n_;
    out.layout.stride[0] = std::int64_t(interleaved_ ? 3 : 1) * std::int64_t(sizeof(Real));
    out.is_float32 = sizeof(Real) == 4;
  }

private:
  std::int64_t n_;
  bool interleaved_;
  std::size_t page_, room_;
  std::byte* memory_;
  Real* values_;
};

template <class Real>
void expect_boxes_of_vertices(bool interleaved, mesh::Shape shape) {
  const int count = mesh::vertex_count(shape);
  constexpr std::int64_t vertices = 40, cells = 60;
  GuardedPoints<Real> points(vertices, interleaved);
  for (std::int64_t v = 0; v < vertices; ++v)
    for (int a = 0; a < 3; ++a)
      points.at(v, a) = Real(100.0 * unit(std::uint64_t(v), std::uint64_t(a)) - 30.0);
  std::vector<std::int32_t> connectivity;
  for (std::int64_t i = 0; i < cells * count; ++i)
    connectivity.push_back(
        std::int32_t(core::random_bits(92, std::uint64_t(i), 0) % std::uint64_t(vertices)));
  connectivity[0] = vertices - 1; // the last vertex is read, and nothing behind it

  mesh::PieceView piece;
  piece.uniform_shape = shape;
  piece.cell_count = cells;
  piece.vertex_count = vertices;
  piece.connectivity = {reinterpret_cast<const std::byte*>(connectivity.data()), cells, 4 * count,
                        true};
  piece.id_stride = 4;
  points.view(piece.points);
  const std::int64_t first_cell[2] = {0, cells}, first_vertex[2] = {0, vertices};
  mesh::MeshView view;
  view.pieces = &piece;
  view.first_cell = first_cell;
  view.first_vertex = first_vertex;
  view.piece_count = 1;

  const math::Vec3d origin{1.5, -2.25, 0.125};
  std::vector<std::uint32_t> ids;
  for (std::uint32_t c = 0; c < cells; ++c)
    ids.push_back((c * 7) % cells);
  std::vector<Box> boxes(cells);
  EXPECT_EQ(CellBoxes(view, origin).compute(ids.data(), cells, 0, boxes.data()), -1);
  for (std::size_t i = 0; i < cells; ++i)
    for (int a = 0; a < 3; ++a) {
      double lo = 1e300, hi = -1e300;
      for (int v = 0; v < count; ++v) {
        const double x = points.at(connectivity[ids[i] * std::size_t(count) + std::size_t(v)], a);
        lo = std::fmin(lo, x);
        hi = std::fmax(hi, x);
      }
      EXPECT_EQ(boxes[i].lower[a], round_down(lo - origin[a]));
      EXPECT_EQ(boxes[i].upper[a], round_up(hi - origin[a]));
    }

  // A bad coordinate of any kind, at any vertex and axis, refuses the lowest cell that uses it.
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity(), 2e37, -2e37})
    for (int a = 0; a < 3; ++a) {
      const std::int64_t vertex = core::random_bits(93, std::uint64_t(a), 0) % 2 ? vertices - 1 : 3;
      const Real good = points.at(vertex, a);
      points.at(vertex, a) = Real(bad);
      std::int64_t lowest = -1;
      for (std::size_t i = connectivity.size(); i-- > 0;)
        if (connectivity[i] == vertex)
          lowest = std::int64_t(i) / count;
      EXPECT_EQ(CellBoxes(view, origin).compute(ids.data(), cells, 0, boxes.data()), lowest) << bad;
      points.at(vertex, a) = good;
    }
}

TEST(Fit, CellBoxesAreThoseOfTheVerticesAndReadNothingBeyond) {
  for (const mesh::Shape shape : {mesh::Shape::tetrahedron, mesh::Shape::pyramid,
                                  mesh::Shape::wedge, mesh::Shape::hexahedron})
    for (const bool interleaved : {true, false}) {
      expect_boxes_of_vertices<double>(interleaved, shape);
      expect_boxes_of_vertices<float>(interleaved, shape);
    }
}

} // namespace
} // namespace insitu::accel
