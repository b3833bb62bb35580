#pragma once

#include <cstdint>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::accel {

/// The vertices of a face by flat ids, cyclic, outward from its cell; [3] is `none` for triangles.
struct FaceVertices {
  std::uint32_t vertices[4];
};

/// Whether the mesh's vertices can be told by 32 bits, and are shared by the cells that meet there.
bool can_pair_faces(const mesh::MeshView& mesh);

/// Finds the faces of the owning cells that are left when two faces of the same vertices, in
/// opposite order round the face, cancel: as a chain they are the boundary of all cells together.
/// Of three cells with one face two cancel at most; faces of cells that turn it the same way, and
/// quads that meet triangles, stay. Faces without area count as none. Of a mesh that
/// can_pair_faces(). Where neighbours are far apart by number the call holds up to 20 bytes a face
/// of each cell meanwhile, else little.
void find_unpaired_faces(const mesh::MeshView& mesh, const core::Threads& threads,
                         core::Memory& memory, core::Buffer<FaceVertices>& out);

} // namespace insitu::accel
