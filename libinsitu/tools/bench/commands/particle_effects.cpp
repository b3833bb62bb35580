#include "commands/particle_effects.h"

#include <array>
#include <cmath>
#include <functional>

#include "advect/pathlines.h"
#include "core/random.h"

namespace insitu::bench {

namespace {

using advect::Effects;

/// A field at the vertices of the mesh's one piece.
struct Field {
  Field(const Setup& setup, int components, const std::function<math::Vec3d(math::Vec3d)>& f)
      : values(std::size_t(setup.mesh.vertex_count()) * std::size_t(components)) {
    for (std::int64_t v = 0; v < setup.mesh.vertex_count(); ++v) {
      const math::Vec3d u = f(setup.mesh.point(v));
      for (int c = 0; c < components; ++c)
        values[std::size_t(v * components + c)] = u[c];
    }
    const auto* base = reinterpret_cast<const std::byte*>(values.data());
    for (std::size_t c = 0; c < std::size_t(components); ++c)
      component[c] = base + c * sizeof(double);
    piece.component = component.data();
    piece.layout.count = setup.mesh.vertex_count();
    piece.layout.stride[0] = std::int64_t(sizeof(double)) * components;
    view = {"velocity", INSITU_VERTEX, components, &piece};
  }
  Field(const Field&) = delete;

  std::vector<double> values;
  std::array<const std::byte*, 3> component{};
  mesh::FieldPieceView piece;
  mesh::FieldView view;
};

/// The box's walls are stream surfaces: without other effects no particle leaves.
math::Vec3d cells_of_flow(math::Vec3d x) {
  const auto s = [](double a) { return std::sin(M_PI * a); };
  const auto c = [](double a) { return std::cos(M_PI * a); };
  return {s(x.x) * c(x.y), -c(x.x) * s(x.y), 0.2 * s(x.z) * s(x.x)};
}

struct Effect {
  std::string name;
  std::function<void(Effects&)> ask;
};

} // namespace

std::vector<ParticleRow> particle_effects(const Options& options, Setup& setup,
                                          const commit::CommittedMesh& mesh) {
  const Field flow(setup, 3, cells_of_flow);
  const Field wind(setup, 3, [](math::Vec3d x) { return math::Vec3d{0.1 * x.y, 0.1, 0.0}; });
  const Field mixing(setup, 1, [](math::Vec3d x) { return math::Vec3d{1e-4 * (1.1 - x.x), 0, 0}; });
  std::vector<math::Vec3d> seeds(5000);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    for (int a = 0; a < 3; ++a)
      seeds[i][a] = 0.1 + 0.8 * core::random_unit(5, i, std::uint64_t(a));

  const std::vector<Effect> effects = {
      {"settling",
       [](Effects& e) {
         e.drifts.push_back({{0, 0, -0.01}, {}, 1.0, {}});
       }},
      {"windage",
       [&](Effects& e) {
         e.drifts.push_back({{}, advect::FieldInTime{wind.view, {}}, 0.03, {}});
       }},
      {"diffusion, constant",
       [](Effects& e) {
         e.diffusion.emplace();
         e.diffusion->horizontal.constant = e.diffusion->vertical.constant = 1e-4;
         e.diffusion->step = 0.02;
       }},
      {"diffusion by a field",
       [&](Effects& e) {
         e.diffusion.emplace();
         e.diffusion->horizontal.field = e.diffusion->vertical.field =
             advect::FieldInTime{mixing.view, {}};
         e.diffusion->step = 0.02;
       }},
      {"boundary that none meets",
       [](Effects& e) {
         e.boundary.emplace();
         e.boundary->response = advect::AtBoundary::slide;
       }},
      {"settling, sliding on the floor",
       [](Effects& e) {
         e.drifts.push_back({{0, 0, -1.0}, {}, 1.0, {}});
         e.boundary.emplace();
         e.boundary->response = advect::AtBoundary::slide;
       }},
      {"inertia",
       [](Effects& e) {
         e.inertia.emplace();
         e.inertia->response_time = 0.05;
         e.boundary.emplace();
         e.boundary->response = advect::AtBoundary::reflect;
       }},
      {"removal that none meets", [](Effects& e) {
         e.removes = [](const std::vector<double>&, const query::Location&, const math::Vec3d& x,
                        double) { return x.x < -1.0; };
       }}};

  std::vector<ParticleRow> rows;
  for (const Effect& effect : effects) {
    ParticleRow row;
    row.effect = effect.name;
    row.particles = std::int64_t(seeds.size());
    core::Memory& memory = setup.context.memory;
    const auto run = [&](const Effects& asked, advect::Advance& total, std::int64_t& bytes) {
      memory.reset_peak();
      const std::int64_t before = memory.current();
      advect::TracerSettings settings;
      settings.integrator.tolerance = 1e-4;
      settings.integrator.max_steps = 1000000;
      advect::Tracer tracer(settings, memory);
      tracer.set_effects(asked);
      tracer.seed(seeds, 0.0);
      total = {};
      for (int cycle = 0; cycle < 10; ++cycle) {
        const advect::Advance a = tracer.advance(mesh.sampler(), flow.view, &flow.view, 0.1 * cycle,
                                                 0.1 * (cycle + 1), setup.context.threads);
        total.work += a.work;
        total.effects += a.effects;
      }
      bytes = memory.peak() - before;
    };
    Effects asked;
    effect.ask(asked);
    advect::Advance bare, with;
    for (int i = 0; i < options.repetitions; ++i) {
      row.bare.time([&] { run({}, bare, row.bytes_bare); });
      row.with.time([&] { run(asked, with, row.bytes_with); });
    }
    row.evaluations_bare = bare.work.evaluations;
    row.evaluations = with.work.evaluations;
    row.steps = with.work.steps;
    row.walk_steps = with.effects.walk_steps;
    row.contacts = with.effects.contacts;
    rows.push_back(row);
  }
  return rows;
}

} // namespace insitu::bench
