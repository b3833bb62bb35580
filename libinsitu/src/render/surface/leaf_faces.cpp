#include "render/surface/leaf_faces.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <tuple>

namespace insitu::render {

namespace {

using Face = accel::MeshFaces::Face;

/// A leaf's face on the lattice of the leaf's depth: the leaf's index, but for the plane's place
/// along the axis.
struct LeafFace {
  std::int64_t at[3];
  std::size_t number; ///< of the face
  std::int8_t axis, depth;
  bool is_upper;

  friend bool operator<(const LeafFace& a, const LeafFace& b) {
    return std::tie(a.axis, a.is_upper, a.depth, a.at[2], a.at[1], a.at[0]) <
           std::tie(b.axis, b.is_upper, b.depth, b.at[2], b.at[1], b.at[0]);
  }
};

/// A vertex's number says on which side of its leaf it is along each axis (mesh::LeavesView): along
/// the face's axis the four are on one side.
LeafFace leaf_face(const mesh::MeshView& mesh, const Face& face, std::size_t number) {
  const std::int32_t piece = mesh.piece_of(face.cell);
  const mesh::LeavesView& leaves = *mesh.pieces[piece].leaves;
  const mesh::AmrCell cell =
      leaves.mesh->cell(leaves.mesh->pieces[leaves.piece], face.cell - mesh.first_cell[piece]);
  unsigned all = 7, any = 0;
  for (const std::uint32_t vertex : face.vertices) {
    const auto sides = unsigned(vertex - mesh.first_vertex[piece]) & 7;
    all &= sides;
    any |= sides;
  }
  const int axis = std::countr_zero(~(all ^ any));
  LeafFace found{{cell.index[0], cell.index[1], cell.index[2]},
                 number,
                 std::int8_t(axis),
                 std::int8_t(cell.depth),
                 all != 0};
  found.at[axis] += found.is_upper;
  return found;
}

/// Goes on to the next coarser depth; false if the face's plane is none of that depth's.
bool coarsen(const mesh::Lattice& lattice, LeafFace& face) {
  for (int a = 0; a < 3; ++a) {
    const int halvings = lattice.halvings(a, 1);
    if (a == face.axis && halvings != 0 && (face.at[a] & 1) != 0)
      return false;
    face.at[a] >>= halvings;
  }
  return --face.depth >= 0;
}

} // namespace

void remove_faces_inside(const mesh::MeshView& mesh, core::CountedVector<Face>& faces) {
  // Of a face's area: a part of it that is 30 depths finer still counts 1.
  constexpr std::uint64_t whole = std::uint64_t(1) << 2 * mesh::Lattice::most_depth;
  if (faces.empty())
    return;
  const mesh::Lattice& lattice = mesh.pieces[0].leaves->mesh->lattice;
  core::CountedVector<LeafFace> ordered(faces.size(), faces.get_allocator());
  for (std::size_t f = 0; f < faces.size(); ++f)
    ordered[f] = leaf_face(mesh, faces[f], f);
  std::sort(ordered.begin(), ordered.end());
  core::CountedVector<std::uint64_t> covered(faces.size(), 0, faces.get_allocator());
  for (const LeafFace& face : ordered) {
    LeafFace beyond = face;
    beyond.is_upper = !face.is_upper;
    int halvings = 0; // of the area
    do {
      const auto found = std::lower_bound(ordered.begin(), ordered.end(), beyond);
      if (found != ordered.end() && !(beyond < *found)) {
        covered[face.number] = whole;
        covered[found->number] += whole >> halvings;
        break;
      }
      halvings += lattice.is_flat != 0 ? 1 : 2;
    } while (coarsen(lattice, beyond));
  }
  std::size_t kept = 0;
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (covered[f] < whole)
      faces[kept++] = faces[f];
  faces.resize(kept);
}

} // namespace insitu::render
