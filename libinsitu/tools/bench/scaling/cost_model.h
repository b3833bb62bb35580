#pragma once

#include <cstdint>

#include "render/frame.h"
#include "scaling/layout.h"

/// What processes send each other, as doc/design/scale.md says it, from the shape of the parts and
/// the view alone: nothing here asks the library.
namespace insitu::bench::scaling {

/// Of one collective call.
struct Cost {
  double items = 0;               ///< of the work: cells, points, steps, samples, rays
  double exchanges = 0;           ///< of each process
  double messages = 0, bytes = 0; ///< of all processes, to other processes

  Cost& operator+=(const Cost& b);
};

/// Values of a mesh at its vertices: of each field so many components, in double.
struct VertexFields {
  int fields = 0, components = 0;
};

Cost found_halo(const Layout& layout, const VertexFields& fields);
/// After a motion, and new values.
Cost refreshed_halo(const Layout& layout, const VertexFields& fields);
/// Cells of other processes that a process has, all processes together.
double halo_cells(const Layout& layout);

/// So many points of all processes, anywhere in the box, and one field's value each.
Cost asked_everywhere(const Layout& layout, double points);

/// So many particles, anywhere in the box, for so long in workload::abc_flow.
Cost moved_particles(const Layout& layout, double particles, double seconds);

/// A frame of the box: its volume, whose samples all show and hide nothing.
Cost drawn_volume(const Layout& layout, const render::FrameSettings& settings, double step);
/// The same with `compositing: standard`.
Cost composited_volume(const Layout& layout, const render::FrameSettings& settings, double step);
/// A frame of a sphere that one sees through.
Cost drawn_sphere(const Layout& layout, const render::FrameSettings& settings,
                  const math::Vec3d& centre, double radius);

} // namespace insitu::bench::scaling
