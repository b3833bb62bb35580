#include <algorithm>
#include <cmath>

#include "accuracy/sweeps.h"
#include "advect/mesh_velocity.h"
#include "core/random.h"
#include "format.h"
#include "report.h"
#include "setup.h"
#include "workload/flow.h"

namespace insitu::bench::accuracy {

namespace {

using math::Vec3d;

class Flow {
public:
  Flow(workload::Kind kind, const Extent& extent) : extent_(extent), setup_(options(kind, extent)) {
    for (std::int64_t v = 0; v < setup_.mesh.vertex_count(); ++v) {
      const Vec3d u = workload::abc_flow(setup_.mesh.point(v));
      velocity_.insert(velocity_.end(), {u.x, u.y, u.z});
    }
    mesh_ = setup_.register_mesh();
    const insitu_array array =
        insitu_array_of(velocity_.data(), INSITU_FLOAT64, setup_.mesh.vertex_count(), 3);
    mesh_->mesh().set_field(0, "velocity", INSITU_VERTEX, &array, 1);
    setup_.commit(*mesh_);
    mesh_->look_for_folds(setup_.context.threads);
    const int count = extent.quick ? 40 : 200;
    for (int i = 0; i < count; ++i)
      seeds_.push_back({0.3 + 0.4 * core::random_unit(9, std::uint64_t(i), 0),
                        0.3 + 0.4 * core::random_unit(9, std::uint64_t(i), 1),
                        0.3 + 0.4 * core::random_unit(9, std::uint64_t(i), 2)});
    // What follows the piecewise field itself to rounding, then the seeds that stay within.
    advect::IntegratorSettings s;
    s.method = advect::Method::dopri5;
    s.tolerance = 1e-13;
    s.face_aware = true;
    s.max_steps = 1'000'000;
    std::vector<bool> stayed;
    advect::Work work;
    truth_ = trace(s, work, &stayed);
    std::vector<Vec3d> seeds, ends;
    for (std::size_t i = 0; i < seeds_.size(); ++i)
      if (stayed[i]) {
        seeds.push_back(seeds_[i]);
        ends.push_back(truth_[i]);
      }
    seeds_ = seeds;
    truth_ = ends;
  }

  std::int64_t cells() const { return setup_.mesh.cell_count(); }
  std::size_t particles() const { return seeds_.size(); }

  Setting measure(const std::string& group, const std::string& name,
                  const advect::IntegratorSettings& settings) {
    Setting s;
    s.group = group;
    s.name = name;
    s.items = double(seeds_.size());
    advect::Work work;
    std::vector<Vec3d> ends;
    for (int i = 0; i < extent_.repetitions; ++i)
      s.time.time([&] {
        work = {};
        ends = trace(settings, work, nullptr);
      });
    double sum = 0.0, worst = 0.0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const Vec3d d = ends[i] - truth_[i];
      sum += dot(d, d);
      worst = std::max(worst, std::sqrt(dot(d, d)));
    }
    s.error = std::sqrt(sum / s.items);
    s.work = double(work.evaluations) / s.items;
    s.more = {worst, double(work.steps) / s.items};
    return s;
  }

private:
  static Options options(workload::Kind kind, const Extent& extent) {
    Options o;
    o.kind = kind;
    o.cells = {extent.quick ? 8000 : 250'000};
    o.jitter = 0.1;
    return o;
  }

  /// Where the seeds are after the time in which the flow crosses about a third of the box.
  std::vector<Vec3d> trace(const advect::IntegratorSettings& settings, advect::Work& work,
                           std::vector<bool>* stayed) {
    const query::Sampler sampler = mesh_->sampler();
    const mesh::FieldView field = mesh_->mesh().field("velocity");
    advect::MeshVelocity velocity(sampler, field, nullptr, 0.0, 0.0, INSITU_STANDARD);
    std::vector<Vec3d> out;
    for (const Vec3d& seed : seeds_) {
      advect::State p;
      p.x = seed;
      velocity.begin(-1);
      const insitu_ending ending = advect::integrate(velocity, settings, 0.15, HUGE_VAL, p, work,
                                                     [](const advect::State&) {});
      out.push_back(p.x);
      if (stayed)
        stayed->push_back(ending == INSITU_END_ALIVE);
    }
    return out;
  }

  Extent extent_;
  Setup setup_;
  std::vector<double> velocity_;
  std::unique_ptr<query::CommittedMesh> mesh_;
  std::vector<Vec3d> seeds_, truth_;
};

std::string advise(const Sweep& s) {
  const std::string group = s.groups().front();
  const Setting* chosen = s.default_of(group);
  const Setting* cheapest = chosen;
  for (const Setting* one : s.of(group))
    if (one->error <= 1.01 * chosen->error && one->seconds() < cheapest->seconds())
      cheapest = one;
  const Setting *plain = s.find(group, "dopri5, 1e-10"),
                *aware = s.find(group, "dopri5 by faces, 1e-10"),
                *rk4 = s.find(group, "rk4, 1/8 cell");
  std::string out = format("The default, dopri5 by faces with a tolerance of 1e-6, leaves an error "
                           "of %.1g of the box at %.0f "
                           "evaluations of the velocity a particle",
                           chosen->error, chosen->work);
  if (cheapest != chosen)
    out += format("; as accurate in the least time: ") + cheapest->name +
           format(", %.2f of it", cheapest->seconds() / chosen->seconds());
  return out + format(". Steps that end at faces take the error of a tolerance of 1e-10 from %.1g "
                      "to %.1g for %.2f times "
                      "the time; rk4 with steps of an eighth of a cell leaves %.1g.",
                      plain->error, aware->error, aware->seconds() / plain->seconds(), rk4->error);
}

} // namespace

Sweep sweep_advect(const Extent& extent) {
  Sweep s;
  s.key = "advect";
  s.title = "Particles";
  s.error_label = "position after a fixed time, root mean square, of the box";
  s.work_label = "evaluations of the velocity a particle";
  s.time_label = "seconds a particle, one core";
  s.more_labels = {"largest error", "steps a particle"};
  std::size_t particles = 0;
  std::int64_t cells = 0;
  for (const auto& [kind, name] : {std::pair(workload::Kind::hexahedra, "hexahedra"),
                                   std::pair(workload::Kind::tetrahedra, "tetrahedra")}) {
    const std::string group = name;
    progress("advect: " + group);
    Flow flow(kind, extent);
    particles = flow.particles();
    cells = flow.cells();
    const double crossing = 1.0 / std::cbrt(double(cells)) / 2.0; // a cell at a typical speed
    for (const bool aware : {false, true}) {
      const std::string by = aware ? " by faces, " : ", ";
      advect::IntegratorSettings settings;
      settings.face_aware = aware;
      settings.max_steps = 1'000'000;
      for (const auto& [method, word] :
           {std::pair(advect::Method::euler, "euler"), std::pair(advect::Method::rk4, "rk4")})
        for (const int part : {1, 2, 4, 8, 16}) {
          settings.method = method;
          settings.step = crossing / part;
          s.settings.push_back(flow.measure(
              group, word + by + (part == 1 ? "1 cell" : format("1/%d cell", part)), settings));
        }
      settings.step = 0.0;
      for (const auto& [method, word] :
           {std::pair(advect::Method::bs32, "bs32"), std::pair(advect::Method::dopri5, "dopri5")})
        for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
          if (method == advect::Method::bs32 && tolerance < 1e-8)
            continue; // a hundred thousand steps a particle
          settings.method = method;
          settings.tolerance = tolerance;
          Setting one = flow.measure(group, word + by + format("%g", tolerance), settings);
          one.is_default = aware && method == advect::Method::dopri5 && tolerance == 1e-6;
          s.settings.push_back(std::move(one));
        }
    }
  }
  s.swept = "Integrators and their steps or tolerances, with steps that end at cell faces and "
            "without, along the ABC flow "
            "interpolated from the vertices of " +
            grouped(cells) + " cells or about as many hexahedra; " + std::to_string(particles) +
            " particles.";
  s.reference = "dopri5 by faces with a tolerance of 1e-13, in the same interpolated field.";
  s.advice = advise(s);
  return s;
}

} // namespace insitu::bench::accuracy
