#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "advect/pathlines.h"
#include "fixtures/committed.h"

/// A box whose walls nothing flows through: the velocity's normal component is 0 at the vertices on
/// them, so that in linear cells no path crosses a wall.
namespace insitu::test {

inline constexpr double box_edge = 1.7; ///< no sum of powers of two

/// Turns the box, so that its walls lie on no axis and are planes to rounding only.
inline Vec3d slanted(const Vec3d& v) {
  const double c = std::cos(0.7), s = std::sin(0.7), d = std::cos(-0.4), e = std::sin(-0.4);
  const Vec3d w{c * v.x - s * v.y, s * v.x + c * v.y, v.z};
  return {w.x, d * w.y - e * w.z, e * w.y + d * w.z};
}

/// What has a velocity: a vertex, or a cell of an adaptive mesh.
struct BoxItem {
  Vec3d at; ///< in the box's axes
  bool on_wall[3];
};

class ClosedBox : public fixtures::Committed {
public:
  using Move = std::function<Vec3d(const Vec3d&, double)>;
  std::vector<BoxItem> items;
  bool slants = false;
  bool by_cells = false;
  int pieces = 1;
  Move moves; ///< where a vertex is at a time, both in the box's axes; or null

  /// Unstructured cells of a kind.
  void give_cells(MeshKind kind, int size) {
    TestMesh cells = make_mesh({.kind = kind, .size = size, .jitter = 0.2}, 5);
    for (Vec3d& p : cells.vertices) {
      for (int a = 0; a < 3; ++a)
        p[a] = p[a] == size ? box_edge : p[a] * (box_edge / size);
      add(p);
      p = place(p, 0.0);
    }
    arrays = fixtures::SolverArrays(cells);
    const insitu_array points = arrays.point_array();
    const insitu_cells c = arrays.cells();
    mesh.mesh().set_points(0, &points, 1);
    mesh.mesh().set_cells(0, &c);
  }

  /// A block of cells of these vertices along each axis.
  void give_block(insitu_block_kind kind, int n) {
    insitu_block block = insitu_block_default();
    block.kind = kind;
    axis_.clear();
    for (int i = 0; i < n; ++i) {
      const double even = box_edge * i / (n - 1);
      axis_.push_back(i == 0 || i + 1 == n || kind == INSITU_BLOCK_UNIFORM
                          ? even
                          : even + 0.1 * box_edge / n * std::sin(7.0 * i));
    }
    // The library's own last vertex, where it computes them.
    const double spacing = box_edge / (n - 1);
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = n;
      block.origin[a] = 0.0;
      block.spacing[a] = spacing;
      if (kind == INSITU_BLOCK_RECTILINEAR)
        block.coordinates[a] = insitu_array_of(axis_.data(), INSITU_FLOAT64, n, 1);
    }
    const Vec3d far{spacing * (n - 1), spacing * (n - 1), spacing * (n - 1)};
    high = kind == INSITU_BLOCK_UNIFORM ? far : high;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          Vec3d p{axis_[std::size_t(i)], axis_[std::size_t(j)], axis_[std::size_t(k)]};
          if (kind == INSITU_BLOCK_UNIFORM)
            p = {spacing * i, spacing * j, spacing * k};
          const int index[3] = {i, j, k};
          BoxItem item{p, {}};
          for (int a = 0; a < 3; ++a)
            item.on_wall[a] = index[a] == 0 || index[a] + 1 == n;
          items.push_back(item);
          const Vec3d x = place(p, 0.0);
          arrays.points.insert(arrays.points.end(), {x.x, x.y, x.z});
        }
    if (kind == INSITU_BLOCK_CURVILINEAR) {
      const insitu_array points =
          insitu_array_of(arrays.points.data(), INSITU_FLOAT64, std::int64_t(items.size()), 3);
      mesh.mesh().set_points(0, &points, 1);
    }
    mesh.mesh().set_block(0, &block);
  }

  /// A patch of 4^3 cells, and one of half the width over its middle.
  void give_patches(insitu_reconstruction reconstruction) {
    by_cells = true;
    pieces = 2;
    insitu_amr levels = insitu_amr_default();
    levels.level_count = 2;
    levels.reconstruction = reconstruction;
    for (int a = 0; a < 3; ++a)
      levels.spacing[a] = box_edge / 4;
    mesh.mesh().set_amr(&levels);
    high = {4 * (box_edge / 4), 4 * (box_edge / 4), 4 * (box_edge / 4)};
    for (int p = 0; p < 2; ++p) {
      insitu_patch patch = insitu_patch_default();
      patch.level = p;
      const int low = p ? 2 : 0, n = p ? 8 : 4;
      for (int a = 0; a < 3; ++a) {
        patch.lower[a] = low;
        patch.cells[a] = 4;
      }
      mesh.mesh().set_patch(p, &patch);
      for (int c = 0; c < 64; ++c) {
        const int index[3] = {low + c % 4, low + c / 4 % 4, low + c / 16};
        BoxItem item{};
        for (int a = 0; a < 3; ++a) {
          item.at[a] = box_edge / n * (index[a] + 0.5);
          item.on_wall[a] = index[a] == 0 || index[a] + 1 == n;
        }
        items.push_back(item);
      }
    }
  }

  /// A flow that turns round with time, at a time, and the mesh committed with it.
  void flow(double time) {
    const double a = std::cos(0.7 * time), b = std::sin(0.4 * time);
    velocity.resize(3 * items.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
      const Vec3d p = (std::numbers::pi / box_edge) * items[i].at;
      Vec3d v{std::sin(p.x) * (a * std::cos(p.y) + b * std::cos(p.z)),
              -std::sin(p.y) * a * std::cos(p.x) + 0.3 * std::sin(p.y) * std::cos(p.z),
              -std::sin(p.z) * (b * std::cos(p.x) + 0.3 * std::cos(p.y))};
      for (int c = 0; c < 3; ++c)
        if (items[i].on_wall[c])
          v[c] = 0.0;
      v = slants ? slanted(v) : v;
      for (std::size_t c = 0; c < 3; ++c)
        velocity[3 * i + c] = v[int(c)];
    }
    if (!has_flow_) {
      const auto n = std::int64_t(items.size()) / pieces;
      for (int p = 0; p < pieces; ++p) {
        const insitu_array array =
            insitu_array_of(velocity.data() + 3 * n * p, INSITU_FLOAT64, n, 3);
        mesh.mesh().set_field(p, "velocity", by_cells ? INSITU_CELL : INSITU_VERTEX, &array, 1);
      }
      has_flow_ = true;
      commit();
    } else {
      commit(moved_ ? INSITU_CHANGED_FIELDS | INSITU_CHANGED_GEOMETRY : INSITU_CHANGED_FIELDS);
      if (moved_)
        mesh.show_earlier(threads);
      moved_ = false;
    }
    if (!by_cells)
      mesh.look_for_folds(threads);
  }
  /// The vertices move to where they are at a time, and what was is kept: before flow().
  void move(double time) {
    mesh.keep_earlier({{"velocity", 1}}, false, threads);
    for (std::size_t i = 0; i < items.size(); ++i) {
      const Vec3d x = place(items[i].at, time);
      for (std::size_t a = 0; a < 3; ++a)
        arrays.points[3 * i + a] = x[int(a)];
    }
    moved_ = true;
  }
  mesh::FieldView field() const { return mesh.mesh().field("velocity"); }

  /// Points at corners, on edges and walls, and within.
  std::vector<Vec3d> seeds() const {
    std::vector<Vec3d> all;
    const double parts[] = {0.0, 0.31, 0.5, 1.0};
    for (const double r : parts)
      for (const double s : parts)
        for (const double t : parts) {
          const double part[3] = {r, s, t};
          Vec3d p;
          for (int a = 0; a < 3; ++a)
            p[a] = part[a] == 1.0 ? high[a] : part[a] * box_edge;
          all.push_back(place(p, 0.0));
        }
    return all;
  }

  Vec3d high{box_edge, box_edge, box_edge};
  std::vector<double> velocity;

private:
  void add(const Vec3d& p) {
    BoxItem item{p, {}};
    for (int a = 0; a < 3; ++a)
      item.on_wall[a] = p[a] == 0.0 || p[a] == box_edge;
    items.push_back(item);
  }
  Vec3d place(const Vec3d& p, double time) const {
    const Vec3d at = moves ? moves(p, time) : p;
    return slants ? slanted(at) : at;
  }
  std::vector<double> axis_;
  bool has_flow_ = false, moved_ = false;
};

} // namespace insitu::test
