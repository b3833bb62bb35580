#pragma once

/// The numbers by which steps of integrate() are chosen.
namespace insitu::advect::control {

/// The PI controller of Gustafsson (ACM TOMS 17, 1991) for error per unit step, which falls as h^q:
/// h_new = h * safety * e_n^(-0.7/q) * e_(n-1)^(0.4/q), e = error / tolerance.
inline constexpr double safety = 0.9;
inline constexpr double exponent = 0.7;
inline constexpr double previous_exponent = 0.4;
inline constexpr double largest_growth = 5.0;
inline constexpr double smallest_factor = 0.2;
inline constexpr double least_error = 1e-4; ///< errors below it all count as this
/// Whatever the tolerance, the error stays this fraction of the speed: slow flows, and those that
/// fade towards a stagnation point, are followed too.
inline constexpr double largest_relative_error = 0.01;
/// A bound on the trials for one step: halving from 1e308 to 1e-308 would take 2047.
inline constexpr int max_trials = 4096;

/// The cells crossed by the first step of an adaptive method. (Those of the others: Method::cells.
/// Without an error estimate, fixed methods also keep h |dv| / |dx| of the step before within 1
/// (rk4 is stable up to 2.8): near a stagnation point steps measured by cells would grow without
/// bound.)
inline constexpr double first_cells = 0.1;

/// A pair whose estimated error is this small a part of the tolerance comes to a face along its
/// continuous extension, without a step of its own. The extension's local error is of the
/// estimate's order, and about 2 times (for one step in ten, 10 times) as large.
inline constexpr double along_extension = 0.1;

/// A step that ends this deep within its cell, or less far outside, ends on its face.
inline constexpr double on_face = 1e-9;
inline constexpr int most_landings = 12; ///< trials for one face
/// So many faces in a row without a way in between: velocities push onto an edge, or from both
/// sides onto a face. Then a step is taken as if there were no faces.
inline constexpr int most_idle_faces = 6;

} // namespace insitu::advect::control
