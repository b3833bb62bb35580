#pragma once

#include "math/number.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// The cell kernels for scalars: host, and device under nvcc. cells/kernels_simd.h gives the same
/// text per SIMD target.
namespace insitu::cells {

#define INSITU_LAMBDA INSITU_HD // lambdas inside kernels carry their target's attribute

using math::absolute;
using math::all_of;
using math::larger;
using math::select;
using math::smaller;
using math::Vec3;
using mesh::Shape;
using mesh::vertex_count;

#include "cells/shape_functions.inl"

#include "cells/inverse_map.inl"

#undef INSITU_LAMBDA

} // namespace insitu::cells
