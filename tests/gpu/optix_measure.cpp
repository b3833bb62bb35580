// Not a test: what the ray methods cost on this machine's device, as a table.
// optix_measure [cells] [random points]; defaults 1e6, 1e7.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "accel/optix/locator.h"
#include "core/timer.h"
#include "gpu_mesh.h"
#include "workload/mesh.h"
#include "workload/queries.h"

using namespace insitu;

namespace {

struct Bench {
  Bench(const workload::Mesh& from) : mesh(from), faces(cpu.memory) {
    const insitu_array x =
        insitu_array_of(mesh.points.data(), INSITU_FLOAT64, mesh.vertex_count(), 3);
    insitu_cells c = insitu_cells_default();
    c.count = mesh.cell_count();
    c.shape = insitu_shape(mesh.uniform_shape);
    c.connectivity = insitu_array_of(mesh.connectivity.data(), INSITU_INT32, c.count,
                                     mesh::vertex_count(mesh.uniform_shape));
    cpu.mesh.mesh().set_points(0, &x, 1);
    cpu.mesh.mesh().set_cells(0, &c);
    at_vertices = workload::vertex_field(mesh);
    at_cells.assign(std::size_t(c.count), 1.0);
    const insitu_array v =
        insitu_array_of(at_vertices.data(), INSITU_FLOAT64, mesh.vertex_count(), 1);
    const insitu_array w = insitu_array_of(at_cells.data(), INSITU_FLOAT64, c.count, 1);
    cpu.mesh.mesh().set_field(0, "v", INSITU_VERTEX, &v, 1);
    cpu.mesh.mesh().set_field(0, "c", INSITU_CELL, &w, 1);
    cpu.commit();
    cpu.mesh.mesh().set_covers_once(true); // as a search for overlaps would find
    const core::Timer timer;
    faces.build(cpu.mesh.mesh().view(), cpu.threads);
    std::printf("%lld cells, %lld faces, face table %.0f ms on %d threads\n",
                static_cast<long long>(c.count), static_cast<long long>(faces.face_count()),
                1e3 * timer.seconds(), cpu.threads.count());
  }
  workload::Mesh mesh;
  fixtures::Committed cpu;
  accel::FaceTable faces;
  std::vector<double> at_vertices, at_cells;
};

/// Points in device memory with the exact owners.
struct Points {
  Points(const Bench& bench, const char* name_, workload::Pattern pattern, std::int64_t count)
      : name(name_), host(workload::make_queries(bench.mesh, pattern, count).points), device(host),
        cells(host.size()), values(host.size()) {
    std::vector<query::Location> exact(host.size());
    const core::Timer timer;
    bench.cpu.sampler().locate(bench.cpu.threads, host, exact, {.accuracy = INSITU_EXACT});
    std::printf("%s: %zu points, CPU bvh exact %.2f M/s\n", name, host.size(),
                1e-6 * double(host.size()) / timer.seconds());
    for (const query::Location& at : exact)
      owners.push_back(at.cell);
  }
  const char* name;
  std::vector<math::Vec3d> host;
  test::OnDevice<math::Vec3d> device;
  test::OnDevice<std::int64_t> cells;
  test::OnDevice<double> values;
  std::vector<std::int64_t> owners;
};

/// Million queries a second, the best of some; field: null for owners alone.
void measure(const accel::DeviceLocator& locator, const Points& points, const char* what,
             insitu_accuracy accuracy, const mesh::FieldView* field) {
  accel::DeviceQuery query;
  query.points = &points.device.data()->x;
  query.count = std::int64_t(points.host.size());
  query.on_device = true;
  query.accuracy = accuracy;
  query.cells = points.cells.data();
  double* const values[] = {points.values.data()};
  if (field) {
    query.fields = {field, 1};
    query.values = values;
  }
  accel::DeviceCounts counts;
  double best = 1e9;
  for (int i = 0; i < 4; ++i) {
    const core::Timer timer;
    counts = locator.locate(query);
    (void)cudaDeviceSynchronize();
    best = std::min(best, timer.seconds());
  }
  const std::vector<std::int64_t> told = points.cells.read();
  std::int64_t wrong = 0;
  for (std::size_t i = 0; i < told.size(); ++i)
    wrong += told[i] != points.owners[i];
  const double n = double(points.host.size());
  std::printf("  %-8s %-22s %8.1f M/s  other cells %.5f%%", points.name, what, 1e-6 * n / best,
              100.0 * double(wrong) / n);
  if (accuracy != INSITU_FAST)
    std::printf("  kept %.3f%%, tree %.3f%%, host %lld", 100.0 * double(counts.candidates_kept) / n,
                100.0 * double(counts.by_tree) / n, static_cast<long long>(counts.settled_on_host));
  std::printf("\n");
}

void measure_method(Bench& bench, accel::Method method,
                    std::initializer_list<const Points*> all_points) {
  std::printf("%s\n", name(method));
  for (const bool split : {false, true}) {
    const auto locator = accel::make_optix_locator(
        method, bench.cpu.memory, split ? std::int64_t(1) << 20 : std::int64_t(1) << 40);
    const auto host = [&]() -> const mesh::MeshView& { return bench.cpu.mesh.mesh().view(); };
    locator->commit(bench.cpu.mesh.mesh(), host, INSITU_CHANGED_ALL, &bench.faces,
                    bench.cpu.threads);
    const accel::DeviceReport built = locator->report();
    double rays = 1e9, whole = 1e9, tree = 1e9;
    for (int i = 0; i < 3; ++i) {
      const core::Timer timer;
      locator->commit(bench.cpu.mesh.mesh(), host, INSITU_CHANGED_GEOMETRY, &bench.faces,
                      bench.cpu.threads);
      whole = std::min(whole, timer.seconds());
      rays = std::min(rays, locator->report().rays_seconds);
      tree = std::min(tree, locator->report().tree_seconds);
    }
    const double mb = 1.0 / (1 << 20);
    std::printf("  %lld group(s), %lld primitives: build %.1f ms (tree %.1f), refit %.1f ms (tree "
                "%.1f, commit %.1f); rays final %.1f MiB, peak %.1f MiB; all %.1f MiB, peak %.1f "
                "MiB\n",
                static_cast<long long>(built.ray_groups), static_cast<long long>(built.primitives),
                1e3 * built.rays_seconds, 1e3 * built.tree_seconds, 1e3 * rays, 1e3 * tree,
                1e3 * whole, mb * double(built.ray_bytes), mb * double(built.ray_peak_bytes),
                mb * double(built.bytes), mb * double(built.peak_bytes));
    const mesh::FieldView v = bench.cpu.mesh.mesh().field("v"),
                          c = bench.cpu.mesh.mesh().field("c");
    for (const Points* points : all_points) {
      measure(*locator, *points, "fast, cells", INSITU_FAST, nullptr);
      if (!split)
        continue;
      measure(*locator, *points, "fast, cell field", INSITU_FAST, &c);
      measure(*locator, *points, "fast, vertex field", INSITU_FAST, &v);
      measure(*locator, *points, "standard, cells", INSITU_STANDARD, nullptr);
      measure(*locator, *points, "exact, cells", INSITU_EXACT, nullptr);
      measure(*locator, *points, "exact, vertex field", INSITU_EXACT, &v);
    }
  }
}

} // namespace

int main(int argc, char** argv) {
  const std::int64_t cells = argc > 1 ? std::int64_t(std::atof(argv[1])) : 1000000;
  const std::int64_t count = argc > 2 ? std::int64_t(std::atof(argv[2])) : 10000000;
  if (const std::string why = accel::why_no_optix(); !why.empty()) {
    std::printf("%s\n", why.c_str());
    return 77;
  }
  cudaDeviceProp device;
  int driver = 0, runtime = 0;
  if (cudaGetDeviceProperties(&device, 0) != cudaSuccess ||
      cudaDriverGetVersion(&driver) != cudaSuccess ||
      cudaRuntimeGetVersion(&runtime) != cudaSuccess)
    return 1;
  std::printf("%s, CUDA driver %d, runtime %d\n", device.name, driver, runtime);
  Bench bench(workload::make_box(workload::Kind::hexahedra,
                                 workload::box_size(workload::Kind::hexahedra, cells), 0.2));
  const Points random(bench, "random", workload::Pattern::random, count);
  const Points uniform(bench, "uniform", workload::Pattern::uniform, 0);
  for (const accel::Method method : test::ray_methods)
    measure_method(bench, method, {&random, &uniform});
}
