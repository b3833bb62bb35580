#pragma once

#include <functional>
#include <gtest/gtest.h>

#include "advect/pathlines.h"
#include "analytic.h"
#include "box_mesh.h"

namespace insitu::test {

using advect::AtBoundary;
using advect::BoundaryEffect;
using advect::Effects;
using advect::Tracer;
using advect::TracerSettings;

/// Tracers with effects in a cube.
class EffectsTest : public ::testing::Test {
protected:
  core::Memory memory;
  core::Threads threads;
  TracerSettings settings;
  Effects effects;

  using Flow = std::function<Vec3d(const Vec3d&)>;
  /// The particles after `cycles` advances from 0 to `end` in a steady flow.
  Tracer run(const BoxMesh& mesh, const Flow& flow, std::span<const Vec3d> seeds, double end,
             int cycles = 1, const core::Threads* with = nullptr) {
    TestField velocity = mesh.vertex_field();
    mesh.fill(velocity, flow);
    Tracer tracer(settings, memory);
    tracer.set_effects(effects);
    tracer.seed(seeds, 0.0);
    work = {};
    for (int c = 0; c < cycles; ++c)
      work += tracer
                  .advance(mesh.sampler(), velocity.view, &velocity.view, end * c / cycles,
                           end * (c + 1) / cycles, with ? *with : threads)
                  .effects;
    return tracer;
  }
  advect::EffectWork work;
};

inline Vec3d still(const Vec3d&) {
  return {};
}

/// A field of one component, f(x) at every vertex, or at every cell's first vertex's place.
inline void fill_scalar(const BoxMesh& mesh, TestField& field,
                        const std::function<double(const Vec3d&)>& f) {
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    field.values[v] = f(mesh.points[v]);
}

} // namespace insitu::test
