#include "methods/rates.h"

#include <utility>

#include "core/timer.h"
#include "measure.h"

namespace insitu::bench {

namespace {

MethodMesh with_fields(workload::Mesh&& mesh) {
  MethodMesh out;
  out.mesh = std::move(mesh);
  out.vertex_field = workload::vertex_field(out.mesh);
  out.cell_field.resize(std::size_t(out.mesh.cell_count()));
  for (std::size_t c = 0; c < out.cell_field.size(); ++c)
    out.cell_field[c] = double(c);
  return out;
}

} // namespace

MethodMesh make_method_mesh(workload::Kind kind, workload::Spacing spacing, std::int64_t cells,
                            double jitter) {
  return with_fields(
      workload::make_box(kind, workload::box_size(kind, cells, spacing), jitter, spacing));
}

MethodMesh make_twisted_method_mesh(std::int64_t cells, double amplitude) {
  return with_fields(
      workload::make_twisted_box(workload::box_size(workload::Kind::hexahedra, cells), amplitude));
}

std::size_t most_points(accel::Backend backend, accel::Method method) {
  if (backend != accel::Backend::cpu)
    return std::size_t(-1);
  return method == accel::Method::bvh ? 1'000'000 : 100'000;
}

double time_rate(MethodRunner& runner, Wanted wanted, insitu_accuracy accuracy, std::size_t points,
                 int repetitions, bool in_processor_time) {
  Series series;
  const core::Timer timer;
  runner.answer(wanted, accuracy); // touches buffers
  const int times = timer.seconds() > 0.25 ? 1 : repetitions;
  for (int i = 0; i < times; ++i)
    series.time([&] { runner.answer(wanted, accuracy); });
  return 1e-6 * double(points) / series.for_ratio(in_processor_time ? 1 : 2);
}

Drawn draw_power(MethodRunner& runner, EnergyMeter& meter, Wanted wanted, std::size_t points) {
  Drawn out;
  const core::Timer timer;
  const double before = meter.joules();
  while (timer.seconds() < 1.5) {
    runner.answer(wanted, INSITU_FAST);
    out.millions += 1e-6 * double(points);
  }
  out.joules = meter.joules() - before;
  out.seconds = timer.seconds();
  return out;
}

} // namespace insitu::bench
