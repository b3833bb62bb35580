#pragma once

#include "mesh/view.h"

/// A mesh and its fields among a kernel's arguments. Data pointers are the device's.
namespace insitu::device {

struct KernelMesh {
  mesh::MeshView view;
  mesh::PieceView piece;                 ///< the mesh's only piece, where shape is not none
  mesh::Shape shape = mesh::Shape::none; ///< of all cells, where kernels are made for it
};

/// A field whose pieces and components are device pointers.
struct KernelField {
  insitu_association association = INSITU_VERTEX;
  int components = 0;
  const mesh::FieldPieceView* pieces = nullptr; ///< [pieces of the mesh]
};

} // namespace insitu::device
