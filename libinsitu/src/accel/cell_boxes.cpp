#include "accel/cell_boxes.h"

namespace insitu::accel {

namespace {

constexpr double largest = 1e37; // coordinates beyond do not fit a float box with its margins

Box outward_box(const math::Vec3d& lo, const math::Vec3d& hi, const math::Vec3d& origin) {
  Box b;
  for (int a = 0; a < 3; ++a) {
    const double l = lo[a] - origin[a], u = hi[a] - origin[a];
    if (!(l > -largest && u < largest))
      return Box{};
    b.lower[a] = round_down(l);
    b.upper[a] = round_up(u);
  }
  return b;
}

// NaN survives neither comparison below, so it is looked for by name: x - x is 0 for finite x only.
struct Extent {
  math::Vec3d lo, hi;
  double finite;
  explicit Extent(const math::Vec3d& p)
      : lo(p), hi(p), finite((p.x - p.x) + (p.y - p.y) + (p.z - p.z)) {}
  void add(const math::Vec3d& p) {
    for (int a = 0; a < 3; ++a) {
      lo[a] = p[a] < lo[a] ? p[a] : lo[a];
      hi[a] = p[a] > hi[a] ? p[a] : hi[a];
    }
    finite += (p.x - p.x) + (p.y - p.y) + (p.z - p.z);
  }
  Box box(const math::Vec3d& origin) const {
    return finite == 0.0 ? outward_box(lo, hi, origin) : Box{};
  }
};

template <class Real>
math::Vec3d load_point(const mesh::PointsView& points, std::int64_t id) {
  const std::int64_t o = id * points.layout.stride[0];
  return {double(mesh::load_as<Real>(points.component[0] + o)),
          double(mesh::load_as<Real>(points.component[1] + o)),
          double(mesh::load_as<Real>(points.component[2] + o))};
}

template <class Index, class Real, int count>
Box uniform_box(const mesh::PieceView& piece, std::int64_t cell, const math::Vec3d& origin) {
  const std::byte* ids = piece.connectivity.data + cell * piece.connectivity.stride;
  const auto point = [&](int v) {
    const auto id = std::int64_t(mesh::load_as<Index>(ids + v * piece.id_stride));
    return load_point<Real>(piece.points, id - piece.index_base);
  };
  Extent extent(point(0));
  for (int v = 1; v < count; ++v)
    extent.add(point(v));
  return extent.box(origin);
}

template <class Index, class Real>
auto choose_count(int count) {
  switch (count) {
  case 4: return &uniform_box<Index, Real, 4>;
  case 5: return &uniform_box<Index, Real, 5>;
  case 6: return &uniform_box<Index, Real, 6>;
  default: return &uniform_box<Index, Real, 8>;
  }
}

} // namespace

CellBoxes::CellBoxes(const mesh::MeshView& mesh, const math::Vec3d& origin)
    : mesh_(&mesh), origin_(origin) {
  if (mesh.piece_count != 1)
    return;
  const mesh::PieceView& p = mesh.pieces[0];
  if (p.layout != mesh::CellLayout::uniform || p.implicit_points || !p.points.layout.linear)
    return;
  const int n = mesh::vertex_count(p.uniform_shape);
  fast_ = p.connectivity.is_int32
              ? (p.points.is_float32 ? choose_count<std::int32_t, float>(n)
                                     : choose_count<std::int32_t, double>(n))
              : (p.points.is_float32 ? choose_count<std::int64_t, float>(n)
                                     : choose_count<std::int64_t, double>(n));
}

Box CellBoxes::general(std::int64_t flat_cell) const {
  mesh::CellVertices cell;
  mesh::gather(*mesh_, flat_cell, cell);
  Extent extent(cell.x[0]);
  for (int v = 1; v < cell.count; ++v)
    extent.add(cell.x[v]);
  return extent.box(origin_);
}

} // namespace insitu::accel
