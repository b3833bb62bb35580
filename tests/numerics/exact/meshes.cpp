#include "cases.h"

namespace insitu::test {
namespace {

/// Corners of block (i, j, k) in the hexahedron's order.
constexpr int corner_offsets[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                      {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

void add_wedges(TestMesh& mesh, const std::array<int, 8>& c) {
  mesh.cells.push_back({Shape::wedge, {c[0], c[2], c[1], c[4], c[6], c[5]}});
  mesh.cells.push_back({Shape::wedge, {c[0], c[3], c[2], c[4], c[7], c[6]}});
}

void add_pyramids(TestMesh& mesh, const std::array<int, 8>& c) {
  Vec3d centre{};
  for (int v : c)
    centre += mesh.vertices[v] / 8.0;
  const int apex = static_cast<int>(mesh.vertices.size());
  mesh.vertices.push_back(centre);
  for (const cells::Face& face : cells::face_table(Shape::hexahedron).faces) {
    const auto& f = face.vertices; // the base turns inwards, towards the apex
    mesh.cells.push_back({Shape::pyramid, {c[f[0]], c[f[3]], c[f[2]], c[f[1]], apex}});
  }
}

/// Six tetrahedra around the diagonal 0-6, one per order of the three axes; translation keeps them
/// conforming.
void add_tetrahedra(TestMesh& mesh, const std::array<int, 8>& c) {
  constexpr int paths[6][2] = {{1, 2}, {1, 5}, {3, 2}, {3, 7}, {4, 5}, {4, 7}};
  for (const auto& path : paths) {
    mesh.cells.push_back({Shape::tetrahedron, {c[0], c[path[0]], c[path[1]], c[6]}});
  }
}

} // namespace

TestMesh make_mesh(const MeshOptions& options, Random& random) {
  TestMesh mesh;
  const int n = options.size, nodes = n + 1;
  const auto node = [nodes](int i, int j, int k) { return (k * nodes + j) * nodes + i; };
  const auto place = [&](double t, int axis) {
    const double x = options.offset + t * options.scale[axis];
    return options.snap > 0 ? std::round(x / options.snap) * options.snap : x;
  };
  for (int k = 0; k < nodes; ++k) {
    for (int j = 0; j < nodes; ++j) {
      for (int i = 0; i < nodes; ++i) {
        Vec3d p;
        const int index[3] = {i, j, k};
        for (int axis = 0; axis < 3; ++axis) {
          const bool interior = index[axis] > 0 && index[axis] < n;
          const double jitter = options.kind == MeshKind::voxels ? 0.0 : options.jitter;
          const double t = index[axis] + (interior ? random.uniform(-jitter, jitter) : 0.0);
          p[axis] = place(t, axis);
        }
        mesh.vertices.push_back(p);
      }
    }
  }
  mesh.low = {place(0, 0), place(0, 1), place(0, 2)};
  mesh.high = {place(n, 0), place(n, 1), place(n, 2)};
  for (int k = 1; k < n; ++k) {
    for (int j = 1; j < n; ++j) {
      for (int i = 1; i < n; ++i) {
        if (random.uniform(0, 1) >= options.collapse)
          continue;
        const int axis = random.below(3);
        mesh.vertices[node(i, j, k)] =
            mesh.vertices[node(i + (axis == 0), j + (axis == 1), k + (axis == 2))];
      }
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const bool column_of_wedges = random.below(3) == 0;
      for (int k = 0; k < n; ++k) {
        std::array<int, 8> c;
        for (int v = 0; v < 8; ++v) {
          const auto& o = corner_offsets[v];
          c[v] = node(i + o[0], j + o[1], k + o[2]);
        }
        switch (options.kind) {
        case MeshKind::hexahedra:
          mesh.cells.push_back({Shape::hexahedron, c});
          break;
        case MeshKind::voxels:
          mesh.cells.push_back({Shape::voxel, {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]}});
          break;
        case MeshKind::wedges:
          add_wedges(mesh, c);
          break;
        case MeshKind::pyramids:
          add_pyramids(mesh, c);
          break;
        case MeshKind::tetrahedra:
          add_tetrahedra(mesh, c);
          break;
        case MeshKind::mixed:
          if (column_of_wedges) {
            add_wedges(mesh, c);
          } else if (random.below(2) == 0) {
            add_pyramids(mesh, c);
          } else {
            mesh.cells.push_back({Shape::hexahedron, c});
          }
          break;
        }
      }
    }
  }
  return mesh;
}

} // namespace insitu::test
