#pragma once

#include <functional>
#include <list>
#include <string>
#include <vector>

#include "core/random.h"
#include "fixtures/committed.h"
#include "render/frame.h"

/// The box [0,1]^3 in jittered cells of one shape, with fields, committed; and small helpers.
namespace insitu::test {

using math::Vec3d;
using mesh::Shape;

/// n^3 blocks of [0,1]^3; inner vertices move by up to jitter / n. Neighbouring blocks are cut
/// along the same diagonals.
inline TestMesh box_cells(int n, Shape shape, double jitter) {
  TestMesh mesh;
  const int m = n + 1;
  for (int v = 0; v < m * m * m; ++v) {
    const int ijk[3] = {v % m, v / m % m, v / (m * m)};
    Vec3d p;
    for (int a = 0; a < 3; ++a) {
      p[a] = double(ijk[a]) / n;
      if (ijk[a] > 0 && ijk[a] < n)
        p[a] += jitter / n * (2 * core::random_unit(1, std::uint64_t(v), std::uint64_t(a)) - 1);
    }
    mesh.vertices.push_back(p);
  }
  const auto add = [&](std::initializer_list<std::int64_t> ids) {
    MeshCell cell;
    cell.shape = shape;
    std::size_t at = 0;
    for (const std::int64_t id : ids)
      cell.vertices[at++] = std::int32_t(id);
    mesh.cells.push_back(cell);
  };
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto id = [&](int x, int y, int z) {
          return std::int64_t(((k + z) * m + j + y) * m + i + x);
        };
        const std::int64_t c[8] = {id(0, 0, 0), id(1, 0, 0), id(1, 1, 0), id(0, 1, 0),
                                   id(0, 0, 1), id(1, 0, 1), id(1, 1, 1), id(0, 1, 1)};
        switch (shape) {
        case Shape::tetrahedron:
          for (const auto& [a, b] : {std::pair{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}})
            add({c[0], c[a], c[b], c[6]});
          break;
        case Shape::wedge:
          add({c[0], c[1], c[2], c[4], c[5], c[6]});
          add({c[0], c[2], c[3], c[4], c[6], c[7]});
          break;
        case Shape::pyramid: {
          Vec3d centre;
          for (const std::int64_t v : c)
            centre += 0.125 * mesh.vertices[std::size_t(v)];
          const auto apex = std::int64_t(mesh.vertices.size());
          mesh.vertices.push_back(centre);
          add({c[0], c[3], c[2], c[1], apex});
          add({c[4], c[5], c[6], c[7], apex});
          add({c[0], c[1], c[5], c[4], apex});
          add({c[3], c[7], c[6], c[2], apex});
          add({c[0], c[4], c[7], c[3], apex});
          add({c[1], c[2], c[6], c[5], apex});
          break;
        }
        default:
          add({c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]});
        }
      }
  return mesh;
}

class RenderMesh {
public:
  RenderMesh(int n, Shape shape = Shape::hexahedron, double jitter = 0.0)
      : cells(box_cells(n, shape, jitter)), committed(cells) {}

  explicit RenderMesh(const TestMesh& from) : cells(from), committed(cells) {}

  query::Sampler sampler() const { return committed.sampler(); }

  /// Registers f(x) at the vertices, or at the cells' vertex averages.
  render::ScalarField field(const std::string& name, insitu_association association,
                            const std::function<double(const Vec3d&)>& f) {
    std::vector<double>& values = kept_.emplace_back();
    if (association == INSITU_VERTEX) {
      for (const Vec3d& p : cells.vertices)
        values.push_back(f(p));
    } else {
      for (const MeshCell& cell : cells.cells) {
        Vec3d p;
        const int n = mesh::vertex_count(cell.shape);
        for (int v = 0; v < n; ++v)
          p += (1.0 / n) * cells.vertices[std::size_t(cell.vertices[std::size_t(v)])];
        values.push_back(f(p));
      }
    }
    const insitu_array a =
        insitu_array_of(values.data(), INSITU_FLOAT64, std::int64_t(values.size()), 1);
    committed.mesh.mesh().set_field(0, name, association, &a, 1);
    committed.commit(INSITU_CHANGED_FIELDS);
    return {committed.mesh.mesh().field(name), -1};
  }

  /// A copy, which may outlive this.
  core::Image draw(const render::FrameSettings& settings, int threads = 0,
                   render::FrameStatistics* statistics = nullptr) {
    const render::FrameImages images = render::render_frame(
        sampler(), settings, core::Threads(threads), committed.memory, statistics);
    return images.color;
  }

  TestMesh cells;
  fixtures::Committed committed;

private:
  std::list<std::vector<double>> kept_;
};

/// Grey as linear light, with this opacity over all values.
inline render::TransferFunction constant_function(double opacity, double grey = 1.0) {
  const double s = render::srgb_of_linear(grey);
  return {render::ColorMap("grey", render::ColorSpace::rgb, {{0, s, s, s}}),
          0.0,
          1.0,
          {{0.0, opacity}}};
}

/// A frame of the unit box, black behind.
inline render::FrameSettings box_frame(int size = 64) {
  render::FrameSettings s;
  s.width = s.height = size;
  s.camera.position = {1.6, 1.3, 2.2};
  s.camera.look_at = {0.5, 0.5, 0.5};
  s.camera.up = {0, 1, 0};
  s.camera.fov = 35;
  s.background = {0, 0, 0};
  return s;
}

/// The stretch of a ray within [0,1]^3; first > last if it misses.
inline std::pair<double, double> box_stretch(const render::Ray& ray) {
  double near = 0, far = HUGE_VAL;
  for (int a = 0; a < 3; ++a) {
    const double t0 = -ray.origin[a] / ray.direction[a];
    const double t1 = (1 - ray.origin[a]) / ray.direction[a];
    near = std::max(near, std::min(t0, t1));
    far = std::min(far, std::max(t0, t1));
  }
  return {near, far};
}

} // namespace insitu::test
