#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "accel/faces/mesh_faces.h"
#include "accel/tree/node.h"
#include "cells/kernels/faces.h"
#include "math/predicates_exact.h"

namespace insitu::accel {

namespace {

using math::Vec3d;

constexpr std::int64_t grain = 4096;

/// Calls visit(flat, cell) with the vertices of every owning cell.
template <class Visit>
void for_each_cell(const mesh::MeshView& mesh, std::int64_t begin, std::int64_t end,
                   Visit&& visit) {
  mesh::CellVertices cell;
  for (std::int64_t flat = begin; flat < end; ++flat) {
    const std::int32_t piece = mesh.piece_of(flat);
    if (!mesh.pieces[piece].exists(flat - mesh.first_cell[piece]))
      continue;
    mesh::gather(mesh, flat, cell);
    visit(flat, cell);
  }
}

/// Whether the cell's faces, as its table turns them, face inwards: an inverted cell, or a wedge in
/// the order of its shape functions. By the flux of the position through the faces, three volumes,
/// about: the sign is right for every cell whose volume is not nearly nothing.
template <mesh::Shape S>
bool turns_inwards(const Vec3d* x) {
  constexpr cells::FaceTable table = cells::face_table(S);
  double flux = 0.0;
  for (int f = 0; f < table.face_count; ++f) {
    const auto& v = table.faces[f].vertices;
    const Vec3d a = x[v[0]] - x[0], b = x[v[1]] - x[0], c = x[v[2]] - x[0];
    if (table.faces[f].vertex_count == 3) {
      flux += 4.0 * dot(a, cross(b, c));
    } else {
      const Vec3d d = x[v[3]] - x[0];
      flux += dot(a + b + c + d, cross(c - a, d - b));
    }
  }
  return flux < 0.0;
}
bool turns_inwards(const mesh::CellVertices& cell) {
  switch (cell.shape) {
  case mesh::Shape::tetrahedron:
    return turns_inwards<mesh::Shape::tetrahedron>(cell.x);
  case mesh::Shape::voxel:
    return turns_inwards<mesh::Shape::voxel>(cell.x);
  case mesh::Shape::wedge:
    return turns_inwards<mesh::Shape::wedge>(cell.x);
  case mesh::Shape::pyramid:
    return turns_inwards<mesh::Shape::pyramid>(cell.x);
  default:
    return turns_inwards<mesh::Shape::hexahedron>(cell.x);
  }
}

/// How a face is cut, in one byte.
struct Cut {
  /// opposite: curved, and the corner tetrahedron has the other sign.
  enum Kind : std::uint8_t { triangle, planar, curved, opposite };
  std::uint8_t first : 2;   ///< the canonical corner, among the face's
  std::uint8_t kind : 2;    ///< of Kind
  std::uint8_t inwards : 1; ///< the face turns inwards from its cell
};
static_assert(sizeof(Cut) == 1);

class Cutter {
public:
  Cutter(const mesh::MeshView& mesh, Method method, const std::vector<std::uint8_t>& inwards)
      : mesh_(mesh), method_(method), inwards_(inwards) {}

  Cut cut(const MeshFaces::Face& face) const {
    Cut result{0, Cut::triangle, std::uint8_t(inwards_[face.cell] & 1)};
    if (face.vertices[3] == none)
      return result;
    const std::int32_t piece = mesh_.piece_of(face.cell);
    Vec3d x[4];
    for (int k = 0; k < 4; ++k)
      x[k] = mesh_.pieces[piece].point(face.vertices[k] - mesh_.first_vertex[piece]);
    result.first = cells::canonical_order({4, {0, 1, 2, 3}}, x).vertices[0] & 3;
    result.kind = Cut::planar;
    if (method_ == Method::shared_bilinear_faces) {
      const int side = math::Predicates{}.orient3d(x[0], x[1], x[2], x[3]);
      // An odd rotation of the corners turns the sign.
      const int sign = (result.first & 1) != 0 ? -side : side;
      result.kind = sign == 0 ? Cut::planar : sign > 0 ? Cut::curved : Cut::opposite;
    }
    return result;
  }

  std::int64_t count(const MeshFaces::Face& face, Cut cut) const {
    if (cut.kind >= Cut::curved)
      return 4;
    const int sides = method_ == Method::replicated_faces && face.other != none ? 2 : 1;
    return sides * (cut.kind == Cut::triangle ? 1 : 2);
  }

  /// Writes the face's triangles; returns behind the last.
  FaceTriangle* write(const MeshFaces::Face& face, Cut cut, FaceTriangle* out) const {
    // Outward from face.cell, the canonical corner first.
    std::uint32_t v[4];
    const int n = cut.kind == Cut::triangle ? 3 : 4;
    for (int k = 0; k < n; ++k)
      v[k] = face.vertices[(n + cut.first + (cut.inwards ? -k : k)) % n];
    if (method_ == Method::replicated_faces) {
      for (int half = 0; half < n - 2; ++half) {
        *out++ = {{v[0], v[2 + half], v[1 + half]}, none, face.cell, none};
        if (face.other != none)
          *out++ = {{v[0], v[1 + half], v[2 + half]}, none, face.other, none};
      }
      return out;
    }
    if (cut.kind < Cut::curved) {
      for (int half = 0; half < n - 2; ++half)
        *out++ = {{v[0], v[1 + half], v[2 + half]}, none, face.other, face.cell};
      return out;
    }
    // Triangle k of the corner tetrahedron lacks the corner before v[k]. Two of them, beside one of
    // the diagonals, face outwards from face.cell as they are; the others from the far cell.
    const bool even_are_out = (cut.kind == Cut::curved) != (cut.inwards != 0);
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t a = v[k], b = v[(k + 1) % 4], c = v[(k + 2) % 4], d = v[(k + 3) % 4];
      if ((k % 2 == 0) == even_are_out)
        *out++ = {{a, b, c}, d, face.other, face.cell};
      else
        *out++ = {{c, b, a}, d, face.cell, face.other};
    }
    return out;
  }

private:
  const mesh::MeshView& mesh_;
  Method method_;
  const std::vector<std::uint8_t>& inwards_;
};

} // namespace

void MeshFaces::triangles(const mesh::MeshView& mesh, const core::Threads& threads, Method method,
                          core::Buffer<FaceTriangle>& out) const {
  std::vector<std::uint8_t> inwards(std::size_t(mesh.cell_count()), 0);
  threads.parallel_for(mesh.cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    for_each_cell(mesh, begin, end, [&](std::int64_t flat, const mesh::CellVertices& cell) {
      inwards[std::size_t(flat)] = turns_inwards(cell);
    });
  });
  const Cutter cutter(mesh, method, inwards);
  std::vector<Cut> cuts(faces_.size());
  std::vector<std::int64_t> start(faces_.size() / grain + 2, 0);
  threads.parallel_for(face_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t n = 0;
    for (auto f = std::size_t(begin); f < std::size_t(end); ++f) {
      cuts[f] = cutter.cut(faces_[f]);
      n += cutter.count(faces_[f], cuts[f]);
    }
    start[std::size_t(begin / grain) + 1] = n;
  });
  for (std::size_t c = 1; c < start.size(); ++c)
    start[c] += start[c - 1];
  out.resize_discard(std::size_t(start.back()));
  threads.parallel_for(face_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    FaceTriangle* to = out.data() + start[std::size_t(begin / grain)];
    for (auto f = std::size_t(begin); f < std::size_t(end); ++f)
      to = cutter.write(faces_[f], cuts[f], to);
  });
}

float MeshFaces::longest_distance(const mesh::MeshView& mesh, const core::Threads& threads) {
  std::vector<double> longest(std::size_t(mesh.cell_count() / grain) + 1, 0.0);
  threads.parallel_for(mesh.cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
    double square = 0.0;
    for_each_cell(mesh, begin, end, [&](std::int64_t, const mesh::CellVertices& cell) {
      for (int v = 1; v < cell.count; ++v)
        for (int w = 0; w < v; ++w) {
          const Vec3d d = cell.x[v] - cell.x[w];
          square = std::max(square, dot(d, d));
        }
    });
    longest[std::size_t(begin / grain)] = std::sqrt(square);
  });
  return round_up(*std::max_element(longest.begin(), longest.end()));
}

} // namespace insitu::accel
