// Times of the CUDA backend on a million jittered hexahedra; the report's tables quote it.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cuda_runtime_api.h>

#include "core/timer.h"
#include "gpu_mesh.h"
#include "workload/mesh.h"
#include "workload/queries.h"

using namespace insitu;

namespace {

struct Timed {
  std::unique_ptr<accel::DeviceLocator> locator;
  mesh::FieldView field;

  /// Median of a few calls, all in device memory.
  void run(const char* name, const std::vector<math::Vec3d>& points, insitu_accuracy accuracy,
           bool values) const {
    const auto n = points.size();
    const std::vector<double> flat(&points[0].x, &points[0].x + 3 * n);
    const test::OnDevice<double> p(flat), out(n);
    const test::OnDevice<std::int64_t> cells(n);
    double* outs[] = {out.data()};
    accel::DeviceQuery query;
    query.points = p.data();
    query.count = std::int64_t(n);
    query.on_device = true;
    query.accuracy = accuracy;
    query.cells = cells.data();
    if (values) {
      query.fields = std::span(&field, 1);
      query.values = outs;
    }
    accel::DeviceCounts counts;
    const double seconds = median([&] {
      counts = locator->locate(query);
      cudaDeviceSynchronize();
    });
    constexpr const char* accuracies[] = {"fast", "standard", "exact"};
    std::printf("  %-9s %-8s %-7s %8.1f M/s  %8.3f ms, %lld settled on the host\n", name,
                accuracies[int(accuracy)], values ? "values" : "ids", double(n) / seconds * 1e-6,
                seconds * 1e3, static_cast<long long>(counts.settled_on_host));
    std::fflush(stdout);
  }
  void run_from_host(const char* name, const std::vector<math::Vec3d>& points) const {
    std::vector<std::int64_t> cells(points.size());
    std::vector<double> out(points.size());
    double* outs[] = {out.data()};
    accel::DeviceQuery query;
    query.points = &points[0].x;
    query.count = std::int64_t(points.size());
    query.cells = cells.data();
    query.fields = std::span(&field, 1);
    query.values = outs;
    const double seconds = median([&] { locator->locate(query); });
    std::printf("  %-9s standard values %8.1f M/s from and to host memory\n", name,
                double(points.size()) / seconds * 1e-6);
  }
  /// Steps of tracers through the field, all in device memory.
  void run_tracers(const mesh::FieldView& velocity, const std::vector<math::Vec3d>& seeds) const {
    constexpr int steps = 100;
    const std::vector<double> flat(&seeds[0].x, &seeds[0].x + 3 * seeds.size());
    const test::OnDevice<double> positions(flat);
    const test::OnDevice<std::uint32_t> cells(
        std::vector<std::uint32_t>(seeds.size(), accel::none));
    const test::OnDevice<std::uint8_t> endings(std::vector<std::uint8_t>(seeds.size(), 0));
    accel::DeviceTracers tracers;
    tracers.positions = positions.data();
    tracers.cells = cells.data();
    tracers.endings = endings.data();
    tracers.count = std::int64_t(seeds.size());
    tracers.velocity = velocity;
    tracers.step = 2e-3;
    tracers.steps = 1;
    locator->advance(tracers);
    cudaDeviceSynchronize();
    tracers.steps = steps;
    const core::Timer timer;
    locator->advance(tracers);
    cudaDeviceSynchronize();
    std::printf("  %zu tracers: %.1f M steps of RK4 a second\n", seeds.size(),
                double(seeds.size()) * steps / timer.seconds() * 1e-6);
  }
  template <class F>
  static double median(F&& f) {
    f();
    double times[5];
    for (double& t : times) {
      const core::Timer timer;
      f();
      t = timer.seconds();
    }
    std::sort(times, times + 5);
    return times[2];
  }
};

} // namespace

int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 100;
  for (const workload::Kind kind :
       {workload::Kind::hexahedra, workload::Kind::tetrahedra, workload::Kind::mixed}) {
    const int size =
        kind == workload::Kind::hexahedra ? n : workload::box_size(kind, std::int64_t(n) * n * n);
    const workload::Mesh from = workload::make_box(kind, size, 0.2);
    const std::vector<double> values = workload::vertex_field(from);
    core::Memory memory;
    core::Threads threads;
    mesh::Mesh mesh("box", memory);
    insitu_array x = insitu_array_of(from.points.data(), INSITU_FLOAT64, from.vertex_count(), 3);
    mesh.set_points(0, &x, 1);
    insitu_cells cells = insitu_cells_default();
    cells.count = from.cell_count();
    if (from.types.empty()) {
      cells.shape = insitu_shape(from.uniform_shape);
      cells.connectivity = insitu_array_of(from.connectivity.data(), INSITU_INT32, cells.count,
                                           mesh::vertex_count(from.uniform_shape));
    } else {
      cells.layout = INSITU_LAYOUT_MIXED;
      cells.connectivity = insitu_array_of(from.connectivity.data(), INSITU_INT32,
                                           std::int64_t(from.connectivity.size()), 1);
      cells.types = insitu_array_of(from.types.data(), INSITU_UINT8, cells.count, 1);
      cells.offsets =
          insitu_array_of(from.offsets.data(), INSITU_INT64, std::int64_t(from.offsets.size()), 1);
    }
    mesh.set_cells(0, &cells);
    x = insitu_array_of(values.data(), INSITU_FLOAT64, from.vertex_count(), 1);
    mesh.set_field(0, "f", INSITU_VERTEX, &x, 1);
    std::vector<double> swirl(3 * std::size_t(from.vertex_count()));
    for (std::int64_t v = 0; v < from.vertex_count(); ++v) {
      const math::Vec3d p = from.point(v);
      double* to = &swirl[3 * std::size_t(v)];
      to[0] = 0.5 - p.y;
      to[1] = p.x - 0.5;
      to[2] = 0.0;
    }
    x = insitu_array_of(swirl.data(), INSITU_FLOAT64, from.vertex_count(), 3);
    mesh.set_field(0, "v", INSITU_VERTEX, &x, 1);
    mesh.update();
    mesh.set_free_of_folds(true); // by its making
    Timed timed{accel::make_device_locator(accel::Backend::cuda, accel::Method::bvh, memory),
                mesh.field("f")};
    const auto commit = [&](std::uint32_t what) {
      timed.locator->commit(mesh, test::view_of(mesh), what, nullptr, threads);
      return timed.locator->report();
    };
    double seconds = Timed::median([&] { commit(INSITU_CHANGED_ALL); });
    accel::DeviceReport report = commit(INSITU_CHANGED_ALL);
    const double cell_count = double(from.cell_count());
    std::printf("%s: %lld cells\n  build %.2f ms, commit %.2f ms, peak %.1f bytes a cell\n",
                workload::name(kind), static_cast<long long>(from.cell_count()),
                report.tree_seconds * 1e3, seconds * 1e3, double(report.peak_bytes) / cell_count);
    for (int i = 0; i < 6; ++i)
      report = commit(INSITU_CHANGED_GEOMETRY);
    seconds = Timed::median([&] { report = commit(INSITU_CHANGED_GEOMETRY); });
    std::printf("  refit %.2f ms, commit %.2f ms, held %.1f bytes a cell, of them copies %.1f\n",
                report.tree_seconds * 1e3, seconds * 1e3, double(report.bytes) / cell_count,
                double(report.bytes_copied) / cell_count);
    timed.run_tracers(mesh.field("v"),
                      workload::make_queries(from, workload::Pattern::random, 1000000).points);
    for (const auto& [pattern, count] :
         {std::pair(workload::Pattern::random, 10000000),
          std::pair(workload::Pattern::sorted, 10000000), std::pair(workload::Pattern::uniform, 0),
          std::pair(workload::Pattern::vertices, 1000000),
          std::pair(workload::Pattern::faces, 1000000)}) {
      if (kind != workload::Kind::hexahedra && pattern != workload::Pattern::random)
        continue;
      const auto points = workload::make_queries(from, pattern, count).points;
      for (const auto accuracy : {INSITU_FAST, INSITU_STANDARD, INSITU_EXACT})
        for (const bool with_values : {false, true})
          if (!workload::is_boundary(pattern) || (accuracy == INSITU_EXACT && !with_values))
            timed.run(workload::name(pattern), points, accuracy, with_values);
      if (!workload::is_boundary(pattern) && kind == workload::Kind::hexahedra)
        timed.run_from_host(workload::name(pattern), points);
    }
  }
  return 0;
}
