#include "accel/faces/mesh_faces.h"
#include "accel/ray_locator.h"
#include "commit/committed_mesh.h"
#include "core/timer.h"
#include "methods/runner.h"
#include "setup.h"

namespace insitu::bench {

void MethodMesh::register_with(mesh::Mesh& to) const {
  const insitu_array points =
      insitu_array_of(mesh.points.data(), INSITU_FLOAT64, mesh.vertex_count(), 3);
  to.set_points(0, &points, 1);
  const insitu_cells cells = cells_of(mesh);
  to.set_cells(0, &cells);
  const insitu_array f =
      insitu_array_of(vertex_field.data(), INSITU_FLOAT64, mesh.vertex_count(), 1);
  to.set_field(0, "f", INSITU_VERTEX, &f, 1);
  const insitu_array c = insitu_array_of(cell_field.data(), INSITU_FLOAT64, mesh.cell_count(), 1);
  to.set_field(0, "c", INSITU_CELL, &c, 1);
}

namespace {

class CpuRunner final : public MethodRunner {
public:
  CpuRunner(accel::Method method, MethodMesh& mesh, core::Context& context)
      : method_(method), context_(context), committed_("bench", context.memory) {
    mesh.register_with(committed_.mesh());
    committed_.set_locator({method, accel::Backend::cpu});
    committed_.commit(context.threads, context.log, context.memory, true);
  }

  Sizes build(double& build_seconds) override {
    const mesh::MeshView& view = committed_.mesh().view();
    if (method_ == accel::Method::bvh) {
      core::Memory memory;
      accel::Tree tree(memory);
      tree.build(view, context_.threads, accel::Builder::morton); // touches pages
      const core::Timer timer;
      tree.build(view, context_.threads, accel::Builder::morton);
      build_seconds = timer.seconds();
      tree.refit(view, context_.threads); // touches pages
      const core::Timer refit_timer;
      tree.refit(view, context_.threads);
      refit_seconds_ = refit_timer.seconds();
      return {tree.cell_count(), tree.bytes(), memory.peak()};
    }
    core::Memory for_faces;
    accel::MeshFaces faces(for_faces);
    const core::Timer timer;
    if (uses_faces(method_))
      faces.build(view, context_.threads);
    const double face_seconds = uses_faces(method_) ? timer.seconds() : 0.0;
    Sizes sizes;
    for (const std::int64_t group : {std::int64_t(1) << 40, std::int64_t(1) << 20}) {
      core::Memory memory;
      const auto rays = accel::make_embree_locator(method_, memory, group);
      const core::Timer build_timer;
      rays->build(view, &faces, context_.threads);
      build_seconds = face_seconds + build_timer.seconds();
      const core::Timer refit_timer;
      rays->refit(view, context_.threads);
      refit_seconds_ = refit_timer.seconds();
      const accel::RayLocatorReport r = rays->report();
      // A mesh of one group has one peak: what Embree holds differs from build to build.
      const std::int64_t peak_whole = r.groups > 1 ? sizes.peak : r.peak_bytes;
      sizes = {r.primitives, r.bytes, r.peak_bytes, peak_whole, face_seconds};
    }
    return sizes;
  }

  double refit() override { return refit_seconds_; }

  void set_points(std::span<const math::Vec3d> points) override {
    points_ = points;
    cells_.resize(points.size());
    values_.resize(points.size());
  }

  void answer(Wanted wanted, insitu_accuracy accuracy) override {
    const query::Sampler sampler = committed_.sampler();
    query::LocateOptions options;
    options.accuracy = accuracy;
    options.coordinates = wanted == Wanted::vertex_value;
    const mesh::FieldView field = committed_.mesh().field(wanted == Wanted::cell_value ? "c" : "f");
    double* const values = values_.data();
    const insitu_locator_info before = committed_.locator_info();
    sampler.visit(context_.threads, points_, options, [&](const query::Answered& answered) {
      if (wanted != Wanted::ids)
        return sampler.interpolate(std::span(&field, 1), answered, 0, &values);
      for (std::size_t k = 0; k < answered.locations.size(); ++k)
        cells_[answered.item(k)] = answered.locations[k].cell;
    });
    const insitu_locator_info after = committed_.locator_info();
    ways_ = {after.kept - before.kept, after.by_neighbour - before.by_neighbour,
             after.by_tree - before.by_tree, 0};
    if (method_ == accel::Method::bvh)
      ways_.by_tree = std::int64_t(points_.size()); // which nobody counts
  }

  Ways ways() const override { return ways_; }

  void ids(std::vector<std::int64_t>& out) override { out = cells_; }

private:
  accel::Method method_;
  core::Context& context_;
  commit::CommittedMesh committed_;
  std::span<const math::Vec3d> points_;
  std::vector<std::int64_t> cells_;
  std::vector<double> values_;
  double refit_seconds_ = 0.0;
  Ways ways_;
};

} // namespace

std::unique_ptr<MethodRunner> make_cpu_runner(accel::Method method, MethodMesh& mesh,
                                              core::Context& context) {
  return std::make_unique<CpuRunner>(method, mesh, context);
}

} // namespace insitu::bench
