#include "amr/dual/dual_cells.h"

#include <bit>
#include <memory>

#include "cells/checks/folds.h"
#include "cells/kernels/faces.h"

namespace insitu::amr {

namespace {

using math::Vec3d;
using mesh::Shape;

std::uint8_t octant_of(int a, int on_a, int b, int on_b, int c, int on_c) {
  return std::uint8_t(on_a << a | on_b << b | on_c << c);
}

/// One face is a point: the apex over the opposite one.
template <class Collapsed>
bool as_pyramid(const int* of, Collapsed& r) {
  for (int face = 0; face < 6; ++face) {
    const int a = face >> 1, side = face & 1, b = (a + 1) % 3, c = (a + 2) % 3;
    const auto at = [&](int on_a, int on_b, int on_c) {
      return octant_of(a, on_a, b, on_b, c, on_c);
    };
    const int apex = of[at(side, 0, 0)];
    if (of[at(side, 1, 0)] != apex || of[at(side, 0, 1)] != apex || of[at(side, 1, 1)] != apex)
      continue;
    // The base turns counterclockwise as the apex sees it.
    r.shape = Shape::pyramid;
    r.octants[0] = at(1 - side, 0, 0);
    r.octants[side ? 1 : 3] = at(1 - side, 1, 0);
    r.octants[2] = at(1 - side, 1, 1);
    r.octants[side ? 3 : 1] = at(1 - side, 0, 1);
    r.octants[4] = at(side, 0, 0);
    return true;
  }
  return false;
}

/// Two edges of one face, parallel to axis a, are points: triangles at both ends of the third axis.
template <class Collapsed>
bool as_wedge(const int* of, Collapsed& r) {
  for (int a = 0; a < 3; ++a)
    for (int turn = 1; turn <= 2; ++turn)
      for (int side = 0; side < 2; ++side) {
        const int b = (a + turn) % 3, c = (a + 3 - turn) % 3;
        const auto at = [&](int on_a, int on_b, int on_c) {
          return octant_of(a, on_a, b, on_b, c, on_c);
        };
        if (of[at(0, side, 0)] != of[at(1, side, 0)] || of[at(0, side, 1)] != of[at(1, side, 1)])
          continue;
        // The first triangle's normal points away from the second one.
        const bool swap = (turn == 1) == (side == 1);
        r.shape = Shape::wedge;
        for (int end = 0; end < 2; ++end) {
          r.octants[3 * end + (swap ? 1 : 0)] = at(0, 1 - side, end);
          r.octants[3 * end + (swap ? 0 : 1)] = at(1, 1 - side, end);
          r.octants[3 * end + 2] = at(0, side, end);
        }
        return true;
      }
  return false;
}

/// An octant whose three neighbours along the axes are other leaves, and the three.
template <class Collapsed>
bool as_tetrahedron(const int* of, Collapsed& r) {
  for (int o = 0; o < 8; ++o) {
    if (of[o] == of[o ^ 1] || of[o] == of[o ^ 2] || of[o] == of[o ^ 4])
      continue;
    const bool odd = std::popcount(unsigned(o)) & 1;
    r.shape = Shape::tetrahedron;
    r.octants[0] = std::uint8_t(o);
    r.octants[1] = std::uint8_t(o ^ 1);
    r.octants[odd ? 3 : 2] = std::uint8_t(o ^ 2);
    r.octants[odd ? 2 : 3] = std::uint8_t(o ^ 4);
    return true;
  }
  return false;
}

/// Six times the volume inside bilinear faces, by the divergence theorem: a quad counts as much as
/// the mean of its two pairs of triangles.
double signed_volume(Shape shape, const Vec3d* x) {
  const cells::FaceTable table = cells::face_table(shape);
  const auto triple = [&](const cells::Face& f, int i, int j, int k) {
    return math::dot(x[f.vertices[i]], math::cross(x[f.vertices[j]], x[f.vertices[k]]));
  };
  double sum = 0.0;
  for (int n = 0; n < table.face_count; ++n) {
    const cells::Face& f = table.faces[n];
    sum += f.vertex_count == 3 ? triple(f, 0, 1, 2)
                               : 0.5 * (triple(f, 0, 1, 2) + triple(f, 0, 2, 3) +
                                        triple(f, 0, 1, 3) + triple(f, 1, 2, 3));
  }
  return sum;
}

/// Every octant's vertex; false if the octants inside form no box.
bool vertex_keys(const Corner& corner, VertexKey* keys, int* source) {
  constexpr std::uint32_t weight[3] = {1, 3, 9};
  constexpr unsigned upper[3] = {0xaa, 0xcc, 0xf0}; // octants on the high side of an axis
  if (corner.inside == 0xff) {
    for (int o = 0; o < 8; ++o) {
      keys[o] = {corner.id[o], 0};
      source[o] = o;
    }
    return true;
  }
  int fixed = 0, side = 0; // axes along which all octants inside lie on one side, and which
  unsigned box = 0xff;
  for (int a = 0; a < 3; ++a) {
    if ((corner.inside & ~upper[a] & 0xff) == 0) {
      fixed |= 1 << a;
      side |= 1 << a;
      box &= upper[a];
    } else if ((corner.inside & upper[a]) == 0) {
      fixed |= 1 << a;
      box &= ~upper[a];
    }
  }
  if (corner.inside != box)
    return false;
  for (int o = 0; o < 8; ++o) {
    source[o] = (o & ~fixed) | side;
    keys[o] = {corner.id[source[o]], 0};
    for (int a = 0; a < 3; ++a) // to the face on the octant's side
      if ((o ^ source[o]) >> a & 1)
        keys[o].moves += weight[a] * (o >> a & 1 ? 2 : 1);
  }
  return true;
}

} // namespace

bool folds(Shape shape, const Vec3d* x) {
  if (shape == Shape::tetrahedron)
    return !(math::dot(math::cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) > 0.0);
  // Turned inside out as a whole: its volume by the divergence theorem is negative.
  return cells::jacobian_changes_sign(shape, x) || !(signed_volume(shape, x) > 0.0);
}

/// Which octants share a leaf, and the shape that this leaves of a hexahedron.
///
/// There are never fewer than four vertices: an octant o whose leaf is of the corner's depth is
/// alone in it, and no leaf holds two of its neighbours along the axes, since a box that holds the
/// octants o^x and o^y holds o. Nor are there other patterns of four than the tetrahedron's.
DualCells::Collapsed DualCells::collapse(const VertexKey* keys) {
  Collapsed r = {Shape::hexahedron, 0, {0, 1, 3, 2, 4, 5, 7, 6}};
  int of[8];
  for (int o = 0; o < 8; ++o) {
    of[o] = o;
    for (int p = 0; p < o && of[o] == o; ++p)
      if (keys[p] == keys[o])
        of[o] = of[p];
    r.distinct = std::uint8_t(r.distinct + (of[o] == o));
  }
  if (r.distinct == 4)
    as_tetrahedron(of, r);
  else if (r.distinct == 5)
    as_pyramid(of, r);
  else if (r.distinct == 6)
    as_wedge(of, r);
  return r;
}

DualCells& DualCells::of_thread() {
  thread_local const auto cells = std::make_unique<DualCells>();
  return *cells;
}

bool DualCells::make(const Corner& corner, DualCell& cell) {
  corner_ = &corner;
  last_ = nullptr;
  if (!vertex_keys(corner, keys_, source_))
    return false;
  // Leaves nest, so depths and the corner's place in the coarsest leaf tell all but the leaves'
  // ids.
  constexpr int most_up = 5;
  if (corner.most_up > most_up) {
    other_ = {0, collapse(keys_), Folds::unknown};
    last_ = &other_;
  } else {
    std::uint64_t pattern = corner.inside;
    for (int o = 0; o < 8; ++o)
      pattern = pattern << 4 | corner.up[o];
    for (const std::int64_t i : corner.index)
      pattern = pattern << most_up | (std::uint64_t(i) & ((1u << corner.most_up) - 1));
    last_ = &known_[pattern * 0x9e3779b97f4a7c15ull >> (64 - known_bits)];
    if (last_->pattern != pattern)
      *last_ = {pattern, collapse(keys_), Folds::unknown};
  }
  const Collapsed& c = last_->shape;
  cell.shape = c.shape;
  cell.distinct = c.distinct;
  cell.boundary = corner.inside != 0xff;
  for (int v = 0; v < mesh::vertex_count(c.shape); ++v)
    cell.set_vertex(v, keys_[c.octants[v]]);
  return true;
}

bool DualCells::folds() {
  if (last_ && last_->folds == Folds::unknown)
    last_->folds = look_for_folds() ? Folds::yes : Folds::no;
  return last_ && last_->folds == Folds::yes;
}

bool DualCells::look_for_folds() const {
  const Corner& corner = *corner_;
  const Collapsed& c = last_->shape;
  // In half cells of the corner's depth, from the corner: small integers. Whether a cell folds does
  // not depend on the spacing.
  Vec3d x[8];
  for (int v = 0; v < mesh::vertex_count(c.shape); ++v) {
    const int o = c.octants[v], s = source_[o], up = corner.up[s];
    for (int a = 0; a < 3; ++a) {
      const std::int64_t place = halves(corner.cell(s, a) >> up, keys_[o].moves, a);
      x[v][a] = double((place << up) - 2 * corner.index[a]);
    }
  }
  return amr::folds(c.shape, x);
}

} // namespace insitu::amr
