#pragma once

#include <memory>
#include <string>

#include "runs/run.h"

namespace insitu_replay {

/// A netCDF file by the UGRID conventions: triangles and quads, flat or in layers, or volumes;
/// null if it has no such mesh, nor says so. Throws FileError.
///
/// Without a vertical coordinate the mesh is flat, and without variables along one. Else faces are
/// prisms between the interfaces of the layers: cell l F + f is face f of F in layer l, in the
/// file's order, heights count upwards in metres, variables without layers are the same in all.
/// Values of nodes in layers are taken to the interfaces, and values of faces on interfaces are
/// taken to layers. Pairs of variables that are a vector's components by their standard names give
/// a vector, too.
std::unique_ptr<Run> open_ugrid(const std::string& path);

} // namespace insitu_replay
