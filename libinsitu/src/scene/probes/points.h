#pragma once

#include "scene/parse/description.h"

namespace insitu::scene {

/// Number of points of a source; of a file, which must be read first, 0.
std::int64_t point_count(const PointSource& source);

/// Point `index` (from 0 to point_count() - 1) in the source's own coordinates. A transect is the
/// straight line between its ends here, and so is a curtain between the places it goes through: the
/// shortest path on the ellipsoid is for the caller, who has the frame. Of a curtain the levels are
/// fastest. Ends of lines and corners of boxes come out exactly as written. Ball: radii
/// follow the cube root of equal steps in volume, directions the two-dimensional low-discrepancy
/// sequence of the plastic number (M. Roberts, "The unreasonable effectiveness of quasirandom
/// sequences", 2018).
math::Vec3d point_at(const PointSource& source, std::int64_t index);

/// The length of a curtain's straight path, and where station `index` lies along it.
double path_length(const Curtain& curtain);
double distance_at(const Curtain& curtain, std::int64_t index);

} // namespace insitu::scene
