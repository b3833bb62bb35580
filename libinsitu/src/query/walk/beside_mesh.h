#pragma once

#include "math/vec.h"
#include "query/sampler.h"

namespace insitu::query {

/// What rounding makes of coordinates in a cell, in its unit: a point that should lie on the cell's
/// boundary is no further beyond. 0 for a flat id that no cell has.
double rounding_in(const mesh::MeshView& mesh, std::int64_t cell, double alpha);

/// A point that no cell holds, but that lies beyond the mesh by no more than `reach` along each
/// axis, becomes the nearest one there that a cell holds, to rounding: on the face, where doubles
/// have it. Returns where that is, or none, and then nothing is changed. On a geodetic mesh points
/// are in its frame. Costs a query's traversal, and of the cells in whose boxes the point lies an
/// inverse map each. Nothing is found in adaptive meshes by `nearest`, whose faces are doubles.
Location bring_inside(const Sampler& sampler, math::Vec3d& p, double reach,
                      const LocateOptions& options = {});

/// The same for a point that is to come into this cell, of which only it is asked: whether it did.
bool bring_into_cell(const mesh::CellVertices& cell, math::Vec3d& p, double reach);

} // namespace insitu::query
