#pragma once

#include "query/sampler.h"

/// Points that go with the material of a moving mesh: they keep their cell and their coordinates in
/// it.
namespace insitu::query {

/// Where a location is in the mesh as it is now.
math::Vec3d position(const mesh::MeshView& mesh, const Location& at);

/// Takes a point to where its material has gone: to `at` in the mesh as it is now. With other cells
/// than when `at` was found (same_cells: false), or no location yet, it is where x is, and is
/// located there. Returns false if that is outside, or where it went is not finite; at.cell then is
/// -1 and x stays.
bool follow(const Sampler& sampler, bool same_cells, const LocateOptions& options, Location& at,
            math::Vec3d& x);

} // namespace insitu::query
