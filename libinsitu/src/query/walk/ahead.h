#pragma once

#include "query/sampler.h"

namespace insitu::query {

/// Whether a straight line from a point without owner meets one of the sampler's cells: crosses one
/// of its faces, or the box of a gridlet. direction: of unit length. Points are among the cells, so
/// the images of a geodetic mesh. Costs a traversal of the tree along the line.
bool meets_cells_ahead(const Sampler& sampler, const math::Vec3d& from,
                       const math::Vec3d& direction, double alpha = 1.0);

} // namespace insitu::query
