#pragma once

#include "core/image.h"

namespace insitu::bench::accuracy {

/// The root of the mean square difference over linear colours.
double rms_error(const core::Image& a, const core::Image& b);
/// 1 - the mean structural similarity of luminances (see compare/similarity.h).
double dissimilarity(const core::Image& a, const core::Image& b);

} // namespace insitu::bench::accuracy
