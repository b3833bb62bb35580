#include "paper/morrical_cases.h"

#include <algorithm>

#include "commands/kept_frames.h"
#include "commands/lattice_rays.h"
#include "commands/render.h"
#include "commit/committed_mesh.h"
#include "measure.h"
#include "workload/queries.h"

namespace insitu::bench::paper {

bool is_here(int backend, int method) {
  return has(Backend(backend), Method(method)) && query::why_unavailable(Backend(backend)).empty();
}

namespace {

/// At most `most` of the points, in evenly spaced stretches that keep neighbours together.
std::vector<math::Vec3d> spread(std::span<const math::Vec3d> points, std::size_t most) {
  constexpr std::size_t stretch = 1024;
  if (points.size() <= most)
    return {points.begin(), points.end()};
  std::vector<math::Vec3d> out;
  const std::size_t count = std::max<std::size_t>(1, most / stretch);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t first = k * (points.size() - stretch) / count;
    const auto some = points.subspan(first, std::min(stretch, most));
    out.insert(out.end(), some.begin(), some.end());
  }
  return out;
}

} // namespace

MorricalCase MorricalBench::measure(const MorricalSet& d) {
  MorricalCase out;
  progress(std::string("making the mesh for ") + d.name);
  MethodMesh mesh = make_method_mesh(d.kind, d.spacing, cells_of(d), o_.jitter);
  out.cells = mesh.mesh.cell_count();
  const double values =
      double(d.wanted == Wanted::cell_value ? out.cells : mesh.mesh.vertex_count());
  out.mesh_bytes = 8.0 * double(mesh.mesh.points.size()) + 8.0 * values +
                   4.0 * double(mesh.mesh.connectivity.size()) + double(mesh.mesh.types.size()) +
                   8.0 * double(mesh.mesh.offsets.size());
  const auto uniform = workload::make_queries(mesh.mesh, workload::Pattern::uniform, 0).points;
  const auto random =
      workload::make_queries(mesh.mesh, workload::Pattern::random, o_.quick ? 3'000 : 300'000)
          .points;
  const std::vector<math::Vec3d> view = draw(d, mesh, out);
  std::vector<std::int64_t> owners;
  {
    const auto truth = make_cpu_runner(Method::bvh, mesh, context_);
    truth->set_points(random);
    truth->answer(Wanted::ids, INSITU_EXACT);
    truth->ids(owners);
  }
  for (int b = 0; b < accel::backend_count; ++b)
    for (int m = 0; m < accel::method_count; ++m)
      if (is_here(b, m)) {
        progress(std::string(d.name) + ", " + name(Backend(b)) + " " + name(Method(m)));
        out.of[b][m] = measure(Backend(b), Method(m), d, mesh, uniform, random, view, owners);
      }
  return out;
}

/// The frame by the renderer, and by VTK; returns points of it, of one tile in 256.
std::vector<math::Vec3d> MorricalBench::draw(const MorricalSet& d, const MethodMesh& mesh,
                                             MorricalCase& out) {
  commit::CommittedMesh committed("bench", context_.memory);
  mesh.register_with(committed.mesh());
  committed.commit(context_.threads, context_.log, context_.memory, true);
  const query::Sampler sampler = committed.sampler();
  const char* const field = d.wanted == Wanted::cell_value ? "c" : "f";
  const std::vector<double>& values =
      d.wanted == Wanted::cell_value ? mesh.cell_field : mesh.vertex_field;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const int size = frame_size();
  render::FrameSettings frame =
      standard_frame(sampler, committed.mesh().field(field), *low, *high, size);
  frame.volume->step_factor = 1.0; // about a sample a cell
  const double more_pixels = 1024.0 * 1024.0 / (double(size) * size);
  KeptFrames frames(committed, context_.memory, context_.threads);
  out.frame_seconds = more_pixels * frames.time(frame, o_.repetitions);
  if (d.wanted == Wanted::vertex_value) {
    const auto vtk = draw_by_vtk(mesh.mesh, mesh.vertex_field, frame, 1, out.vtk_why);
    if (vtk)
      out.vtk_seconds = more_pixels * vtk->time.for_ratio(1);
  }
  frame.width = frame.height = 1024;
  std::int64_t rays = 0;
  const auto points = lattice_points(sampler, frame, 16, &rays);
  out.view_samples = double(points.size()) * 1024.0 * 1024.0 / double(rays);
  return points;
}

MethodCase MorricalBench::measure(Backend backend, Method method, const MorricalSet& d,
                                  MethodMesh& mesh, std::span<const math::Vec3d> uniform,
                                  std::span<const math::Vec3d> random,
                                  std::span<const math::Vec3d> view,
                                  const std::vector<std::int64_t>& owners) {
  MethodCase out;
  const auto runner = backend == Backend::cpu ? make_cpu_runner(method, mesh, context_)
                                              : make_device_runner(backend, method, mesh, context_);
  double seconds = 0.0;
  out.sizes = runner->build(seconds);
  const bool alone = backend == Backend::cpu && context_.threads.count() == 1;
  // The same for all methods of the backend, so as many as the slowest of them answers.
  const std::size_t most = o_.quick ? 3000 : most_points(backend, Method::shared_faces);
  std::vector<math::Vec3d> asked;
  const auto ask = [&](std::vector<math::Vec3d> points) {
    asked = std::move(points);
    runner->set_points(asked);
    return asked.size();
  };
  const std::size_t in_order = ask(spread(uniform, most));
  out.uniform = time_rate(*runner, d.wanted, INSITU_FAST, in_order, o_.repetitions, alone);
  const auto first = random.first(std::min(random.size(), most));
  const std::size_t n = ask({first.begin(), first.end()});
  out.random = time_rate(*runner, d.wanted, INSITU_FAST, n, o_.repetitions, alone);
  out.random_standard = time_rate(*runner, d.wanted, INSITU_STANDARD, n, o_.repetitions, alone);
  out.random_exact = time_rate(*runner, d.wanted, INSITU_EXACT, n, o_.repetitions, alone);
  std::vector<std::int64_t> ids;
  for (const insitu_accuracy accuracy : {INSITU_STANDARD, INSITU_EXACT}) {
    runner->answer(Wanted::ids, accuracy);
    runner->ids(ids);
    for (std::size_t i = 0; i < n; ++i)
      if (accuracy == INSITU_STANDARD)
        out.lost += ids[i] < 0 && owners[i] >= 0;
      else
        out.other += ids[i] != owners[i];
  }
  const std::size_t along = ask(spread(view, most));
  out.view = time_rate(*runner, d.wanted, INSITU_FAST, along, o_.repetitions, alone);
  EnergyMeter& meter = backend == Backend::cpu ? processor_ : card_;
  if (meter.works() && !o_.quick) {
    const Drawn drawn = draw_power(*runner, meter, d.wanted, along);
    out.watts = drawn.joules / drawn.seconds;
    out.joules = drawn.joules / drawn.millions;
  }
  return out;
}

} // namespace insitu::bench::paper
