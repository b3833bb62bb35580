#pragma once

namespace insitu::render {

/// What a surface's normals are taken from: the gradient in the cell that is hit; gradients
/// averaged at the vertices and interpolated (VertexGradients); or central differences half a cell
/// apart, with six points located for each hit (Rathke et al. 2015).
enum class Normals { cell, smooth, central };

} // namespace insitu::render
