#pragma once

#include <cstdint>

#include "cells/exact/contain_exact.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// Containment in integer arithmetic of unlimited length, by another method than the library's.
///
/// A ray in a random direction is intersected with each bilinear patch S(u, v) itself: eliminating
/// v gives a quadratic in u whose roots, and v and the ray parameter there, are p + q sqrt(D) with
/// integers p, q, D, so all their signs are exact. No corner tetrahedron, no diagonal, no symbolic
/// perturbation: a ray that meets an edge, or touches, is thrown again.
namespace insitu::test {

/// `seed` picks the ray directions; the answer does not depend on it.
cells::Containment oracle_contain(mesh::Shape shape, const math::Vec3d* vertices,
                                  const math::Vec3d& point, std::uint64_t seed);

} // namespace insitu::test
