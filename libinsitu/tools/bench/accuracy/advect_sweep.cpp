#include <algorithm>
#include <cmath>

#include "accuracy/sweeps.h"
#include "commands/advect.h"
#include "advect/field/mesh_velocity.h"
#include "core/random.h"
#include "report/format.h"
#include "commands/lines_by_length.h"
#include "report/report.h"
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
    if (advect::CellsBeyond(mesh_->sampler()).lacks_neighbours())
      mesh_->find_neighbours(setup_.context.threads);
    const int count = extent.quick ? 40 : 1000;
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
    std::vector<Whole> whole;
    advect::Work work;
    truth_ = trace(s, work, &whole);
    std::vector<Vec3d> seeds, ends;
    for (std::size_t i = 0; i < seeds_.size(); ++i)
      if (whole[i].stayed) {
        seeds.push_back(seeds_[i]);
        ends.push_back(truth_[i]);
        length_ += whole[i].length;
      }
    seeds_ = seeds;
    truth_ = ends;
    length_ /= double(seeds_.size());
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

  /// vtkStreamTracer's lines from the same seeds, as long as ours are on the mean after the time:
  /// it knows no other end. step: in cells; error: that its adaptive method tolerates. Of its own
  /// errors only the part across the lines counts.
  std::vector<Setting> measure_peers(const std::string& group, double step, double error) {
    std::vector<Setting> out;
    for (const PeerLines& lines :
         trace_by_vtk(setup_.mesh, velocity_, seeds_, length_, step, error, extent_.repetitions)) {
      Setting s;
      s.group = group;
      s.is_peer = true;
      const bool adaptive = lines.name.ends_with("45");
      s.name = lines.name + ", " + (adaptive ? format("%g", error) : format("%g cell", step));
      s.items = double(seeds_.size());
      s.time = lines.time;
      s.error = LinesByLength(*mesh_, setup_.context.threads).across(lines, seeds_, length_);
      s.more = {std::nan(""), double(lines.steps) / s.items};
      if (std::count(lines.whole.begin(), lines.whole.end(), true) > 0)
        out.push_back(std::move(s));
    }
    return out;
  }

private:
  struct Whole {
    bool stayed = false;
    double length = 0.0; ///< of the line
  };

  static Options options(workload::Kind kind, const Extent& extent) {
    Options o;
    o.kind = kind;
    o.cells = {extent.quick ? 8000 : 250'000};
    o.jitter = 0.1;
    return o;
  }

  /// Where the seeds are after the time in which the flow crosses about a third of the box.
  std::vector<Vec3d> trace(const advect::IntegratorSettings& settings, advect::Work& work,
                           std::vector<Whole>* whole) {
    const query::Sampler sampler = mesh_->sampler();
    const mesh::FieldView field = mesh_->mesh().field("velocity");
    const auto beyond = advect::CellsBeyond::worth(sampler, std::int64_t(seeds_.size()));
    advect::MeshVelocity velocity(sampler, field, nullptr, 0.0, 0.0, INSITU_STANDARD);
    velocity.walk_by(beyond.get());
    std::vector<Vec3d> out;
    for (const Vec3d& seed : seeds_) {
      advect::State p;
      p.x = seed;
      velocity.begin(-1);
      Vec3d last = seed;
      double length = 0.0;
      const insitu_ending ending = advect::integrate(velocity, settings, 0.15, HUGE_VAL, p, work,
                                                     [&](const advect::State& now) {
                                                       if (whole)
                                                         length += advect::length_of(now.x - last);
                                                       last = now.x;
                                                     });
      out.push_back(p.x);
      if (whole)
        whole->push_back({ending == INSITU_END_ALIVE, length});
    }
    return out;
  }

  Extent extent_;
  Setup setup_;
  std::vector<double> velocity_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
  std::vector<Vec3d> seeds_, truth_;
  double length_ = 0.0; ///< of the true lines, the mean
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
  out += format(". Steps that end at faces take the error of a tolerance of 1e-10 from %.1g "
                "to %.1g for %.2f times "
                "the time; rk4 with steps of an eighth of a cell leaves %.1g.",
                plain->error, aware->error, aware->seconds() / plain->seconds(), rk4->error);
  // Beside each of the peer's settings, the fastest of ours that errs no more.
  double least = HUGE_VAL, most = 0.0;
  for (const std::string& g : s.groups())
    for (const Setting* peer : s.of(g, true)) {
      const Setting* ours = nullptr;
      for (const Setting* one : s.of(g))
        if (peer->is_peer && one->error <= peer->error &&
            (!ours || one->seconds() < ours->seconds()))
          ours = one;
      if (ours) {
        least = std::min(least, peer->seconds() / ours->seconds());
        most = std::max(most, peer->seconds() / ours->seconds());
      }
    }
  if (most > 0.0)
    out += format(" At an error no larger, vtkStreamTracer takes %.1f to %.1f times the time.",
                  least, most);
  return out;
}

} // namespace

Sweep sweep_advect(const Extent& extent) {
  Sweep s;
  s.key = "advect";
  s.title = "Particles";
  s.error_label = "error of the position, root mean square, of the box";
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
    for (const auto& [step, error] :
         {std::pair(1.0, 1e-2), std::pair(0.5, 1e-4), std::pair(0.25, 1e-6), std::pair(0.125, 1e-8),
          std::pair(0.0625, 1e-10)}) {
      progress("advect: " + group + ", vtkStreamTracer");
      for (Setting& peer : flow.measure_peers(group, step, error))
        s.settings.push_back(std::move(peer));
    }
  }
  s.swept = "Integrators and their steps or tolerances, with steps that end at cell faces and "
            "without, along the ABC flow "
            "interpolated from the vertices of " +
            grouped(cells) + " cells or about as many hexahedra; " + std::to_string(particles) +
            " particles.";
  s.reference = "dopri5 by faces with a tolerance of 1e-13, in the same interpolated field.";
  s.advice = advise(s);
  if (std::any_of(s.settings.begin(), s.settings.end(), [](const Setting& p) { return p.is_peer; }))
    s.notes = {
        "vtkStreamTracer ends lines by their length: from the same seeds, as long as ours are "
        "on the mean after the fixed time. Of its errors only the part across the lines is "
        "counted, of ours all."};
  return s;
}

} // namespace insitu::bench::accuracy
