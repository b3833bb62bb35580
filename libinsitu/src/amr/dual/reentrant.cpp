#include "amr/dual/reentrant.h"

#include <algorithm>
#include <array>
#include <utility>

namespace insitu::amr {

namespace {

using math::Vec3d;
using mesh::Shape;

constexpr std::uint32_t weight[3] = {1, 3, 9};

/// A vertex and its place in half cells of the corner's depth, from the corner.
struct Vertex {
  VertexKey key;
  Vec3d x;
};

class Splitter {
public:
  Splitter(const Corner& corner, const mesh::Lattice& lattice, std::vector<DualCell>& cells,
           std::vector<MeanVertex>& means)
      : corner_(corner), lattice_(lattice), cells_(cells), means_(means) {}

  bool split() {
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 2; ++side)
        cover(axis, side);
    const Vertex apex = find_apex();
    for (const Polygon& p : polygons_)
      add_cone(p, apex);
    return folded_;
  }

private:
  struct Polygon {
    Vertex vertices[4];
    int count = 0;
  };

  bool inside(int octant) const { return corner_.inside >> octant & 1; }

  Vertex add(const MeanVertex& mean, const Vec3d& x) {
    means_.push_back(mean);
    return {{std::uint32_t(means_.size() - 1), mean_moves}, x};
  }

  /// The leaf of an octant inside, moved along some axes (bits) to the domain's boundary, on the
  /// side where the octant `to` lies.
  Vertex leaf(int octant, int moved = 0, int to = 0) const {
    Vertex v = {{corner_.id[octant], 0}, {}};
    const int up = corner_.up[octant];
    for (int a = 0; a < 3; ++a) {
      if (moved >> a & 1)
        v.key.moves += weight[a] * (to >> a & 1 ? 2 : 1);
      const std::int64_t place = halves(corner_.cell(octant, a) >> up, v.key.moves, a);
      v.x[a] = double((place << (is_flat_along(a) ? 0 : up)) - 2 * corner_.index[a]);
    }
    return v;
  }

  /// Notes a polygon, without vertices that follow themselves; none if that leaves an edge.
  void note(const Vertex* vertices, int count) {
    Polygon p;
    for (int i = 0; i < count; ++i)
      if (p.count == 0 || !(p.vertices[p.count - 1].key == vertices[i].key))
        p.vertices[p.count++] = vertices[i];
    if (p.count > 1 && p.vertices[p.count - 1].key == p.vertices[0].key)
      --p.count;
    if (p.count >= 3)
      polygons_.push_back(p);
  }

  /// Whether cells of all depths are as wide along an axis.
  bool is_flat_along(int axis) const { return axis == 2 && lattice_.is_flat != 0; }

  static bool at_corner(const Vertex& v) { return v.x == Vec3d{0, 0, 0}; }

  /// Whether the corner lies in the polygon's plane: large leaves reach across it.
  static bool is_flat(const Polygon& p) {
    for (int a = 0; a < 3; ++a)
      if (std::all_of(p.vertices, p.vertices + p.count,
                      [a](const Vertex& v) { return v.x[a] == 0.0; }))
        return true;
    return false;
  }

  /// If the corner lies between two leaves' vertices, the value there is as on the line.
  static void interpolate(Vertex u, Vertex w, MeanVertex& mean) {
    if (math::dot(u.x, u.x) > math::dot(w.x, w.x))
      std::swap(u, w);
    for (int nearer = 1; nearer < 8; nearer *= 2)
      if (w.x == double(-nearer) * u.x && u.key.moves != mean_moves && w.key.moves != mean_moves) {
        std::fill_n(mean.leaves, nearer, u.key.leaf);
        std::fill_n(mean.moves, nearer, std::uint8_t(u.key.moves));
        mean.leaves[nearer] = w.key.leaf;
        mean.moves[nearer] = std::uint8_t(w.key.moves);
        mean.on_line = true;
        mean.count = std::uint8_t(nearer + 1);
      }
  }

  /// The vertex at the corner: that of a large leaf whose face has its middle there, or a new one.
  Vertex find_apex() {
    for (const Polygon& p : polygons_)
      for (int i = 0; i < p.count; ++i)
        if (at_corner(p.vertices[i]))
          return p.vertices[i];
    MeanVertex mean = {};
    for (const Polygon& p : polygons_)
      for (int i = 0; i < p.count && mean.count == 0 && is_flat(p); ++i)
        interpolate(p.vertices[i], p.vertices[(i + 1) % p.count], mean);
    if (mean.count == 0)
      for (int o = 0; o < 8; ++o)
        if (inside(o))
          mean.leaves[mean.count++] = corner_.id[o];
    for (int a = 0; a < 3; ++a)
      mean.x[a] = lattice_.place(a, corner_.depth, 2 * corner_.index[a]);
    return add(mean, {0, 0, 0});
  }

  /// The pyramid or the tetrahedron over a polygon; nothing over one in a plane with the apex.
  void add_cone(const Polygon& p, const Vertex& apex) {
    if (is_flat(p))
      return;
    DualCell cell = {};
    Vec3d x[5];
    for (int i = 0; i < p.count; ++i) {
      if (at_corner(p.vertices[i])) // in a plane of the lattice, then
        return;
      cell.set_vertex(i, p.vertices[i].key);
      x[i] = p.vertices[i].x;
    }
    cell.set_vertex(p.count, apex.key);
    x[p.count] = apex.x;
    cell.shape = p.count == 4 ? Shape::pyramid : Shape::tetrahedron;
    cell.distinct = std::uint8_t(p.count + 1);
    cell.boundary = true;
    cells_.push_back(cell);
    folded_ |= folds(cell.shape, x);
  }

  void cover(int axis, int side) {
    // The face's octants, in the order in which its normal points to the corner.
    const int b = 1 << (axis + 1) % 3, c = 1 << (axis + 2) % 3, base = side << axis;
    const int ring[4] = {base, base | (side ? c : b), base | b | c, base | (side ? b : c)};
    const int in_face[4] = {inside(ring[0]), inside(ring[1]), inside(ring[2]), inside(ring[3])};
    const int count = in_face[0] + in_face[1] + in_face[2] + in_face[3];
    if (count == 3 || (count == 2 && in_face[0] == in_face[2]))
      cover_reentrant(axis, ring);
    else if (count > 0)
      cover_box(ring, b | c);
  }

  /// Over a face whose octants inside form a box, as a neighbour's cell has it.
  void cover_box(const int* ring, int axes) {
    int fixed = axes, first = -1; // axes along which all octants inside lie on one side
    for (int i = 0; i < 4; ++i) {
      if (!inside(ring[i]))
        continue;
      if (first >= 0)
        fixed &= ~(ring[i] ^ ring[first]);
      else
        first = i;
    }
    Vertex quad[4];
    for (int i = 0; i < 4; ++i) {
      const int source = (ring[i] & ~fixed) | (ring[first] & fixed);
      quad[i] = leaf(source, ring[i] ^ source, ring[i]);
    }
    note(quad, 4);
  }

  void cover_reentrant(int axis, const int* ring) {
    const Vertex middle = find_middle(axis, ring);
    for (int i = 0; i < 4; ++i) {
      const int from = ring[i], to = ring[(i + 1) & 3];
      if (!inside(from) && !inside(to))
        continue;
      const Vertex triangle[3] = {inside(from) ? leaf(from) : leaf(to, from ^ to, from),
                                  inside(to) ? leaf(to) : leaf(from, from ^ to, to), middle};
      note(triangle, 3);
    }
  }

  /// The vertex on the domain's edge. It must not depend on which of the two corners finds it: that
  /// of a large leaf whose face has its middle on the edge, or else a new one at the mean of the
  /// leaves' centres, counted in half cells of the finest of these.
  Vertex find_middle(int axis, const int* ring) {
    MeanVertex mean = {};
    int around[4], finest = mesh::Lattice::most_depth;
    for (int i = 0; i < 4; ++i) {
      if (!inside(ring[i]))
        continue;
      for (const int to : {ring[(i + 1) & 3], ring[(i + 3) & 3]}) {
        const Vertex v = leaf(ring[i], ring[i] ^ to, to);
        if (!inside(to) && v.x[(axis + 1) % 3] == 0.0 && v.x[(axis + 2) % 3] == 0.0)
          return v;
      }
      around[mean.count++] = ring[i];
      finest = std::min(finest, int(corner_.up[ring[i]]));
    }
    std::int64_t sum = 0;
    for (int i = 0; i < 4; ++i)
      if (inside(ring[i])) {
        const int up = corner_.up[ring[i]];
        sum += ((corner_.cell(ring[i], axis) >> up) * 2 + 1) << (up - finest);
      }
    // In an order of places, so that both corners, and all processes, add up alike.
    const auto leaf_place = [&](int octant) {
      const int up = corner_.up[octant];
      return std::array{std::int64_t(up), corner_.cell(octant, 2) >> up,
                        corner_.cell(octant, 1) >> up, corner_.cell(octant, 0) >> up};
    };
    for (int m = 1; m < mean.count; ++m)
      for (int n = m; n > 0 && leaf_place(around[n]) < leaf_place(around[n - 1]); --n)
        std::swap(around[n], around[n - 1]);
    for (int m = 0; m < mean.count; ++m)
      mean.leaves[m] = corner_.id[around[m]];
    for (int a = 0; a < 3; ++a)
      mean.x[a] = lattice_.place(a, corner_.depth, 2 * corner_.index[a]);
    const double place = double(sum) / mean.count;
    mean.x[axis] = lattice_.origin[axis] + lattice_.spacing[axis] *
                                               mesh::Lattice::power(corner_.depth - finest + 1) *
                                               place;
    Vec3d x = {0, 0, 0};
    x[axis] = place * double(1 << finest) - 2.0 * double(corner_.index[axis]);
    if (is_flat_along(axis)) { // all centres are in one plane
      mean.x[axis] = lattice_.centre(axis, corner_.depth, 0);
      x[axis] = 1.0;
    }
    return add(mean, x);
  }

  const Corner& corner_;
  const mesh::Lattice& lattice_;
  std::vector<DualCell>& cells_;
  std::vector<MeanVertex>& means_;
  std::vector<Polygon> polygons_;
  bool folded_ = false;
};

} // namespace

bool split_reentrant(const Corner& corner, const mesh::Lattice& lattice,
                     std::vector<DualCell>& cells, std::vector<MeanVertex>& means) {
  return Splitter(corner, lattice, cells, means).split();
}

} // namespace insitu::amr
