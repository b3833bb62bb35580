#pragma once

#include "query/sampler.h"

/// Points that go with the material of a moving mesh: they keep their cell and their coordinates in
/// it.
namespace insitu::query {

/// Where a location is in the mesh as it is now; of a geodetic mesh, with its longitude within the
/// mesh's turn.
math::Vec3d position(const Sampler& sampler, const Location& at);

/// A part of the way from a to b, straight but on geodetic meshes: along a great circle of normals
/// there, at even vertical steps.
math::Vec3d on_the_way(const Sampler& sampler, const math::Vec3d& a, const math::Vec3d& b,
                       double part);
/// The straight distance of two points: of a geodetic mesh in metres.
double distance(const Sampler& sampler, const math::Vec3d& a, const math::Vec3d& b);

/// Takes a point to where its material has gone: to `at` in the mesh as it is now. With other cells
/// than when `at` was found (same_cells: false), or no location yet, it is where x is, and is
/// located there. Returns false if that is outside, or where it went is not finite; at.cell then is
/// -1 and x stays.
bool follow(const Sampler& sampler, bool same_cells, const LocateOptions& options, Location& at,
            math::Vec3d& x);

} // namespace insitu::query
