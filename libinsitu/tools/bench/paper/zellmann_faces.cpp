#include <algorithm>
#include <cmath>
#include <vector>

#include "accuracy/images.h"
#include "commands.h"
#include "report/format.h"
#include "commands/kept_frames.h"
#include "commands/lattice_rays.h"
#include "paper/face_tests.h"
#include "paper/zellmann_meshes.h"

namespace insitu::bench::paper {

namespace {

using math::Vec3d;

/// The reference's dual mesh by a method of faces, in `fast`.
class ByFaces {
public:
  ByFaces(const PlainDual& plain, accel::Method method, core::Context& context)
      : context_(context), mesh_(register_plain(plain, context.memory)) {
    mesh_->set_locator({method, accel::Backend::cpu});
    mesh_->commit(context.threads, context.log, context.memory, true);
    frames_ = std::make_unique<KeptFrames>(*mesh_, context.memory, context.threads);
  }

  /// Nanoseconds a point to find its cell alone.
  double find(std::span<const Vec3d> points, int repetitions) {
    query::LocateOptions options{INSITU_FAST, 1.0, false};
    std::vector<query::Location> at(points.size());
    mesh_->sampler().locate(context_.threads, points, at, options); // touches pages
    Series series;
    for (int i = 0; i < repetitions; ++i)
      series.time([&] { mesh_->sampler().locate(context_.threads, points, at, options); });
    return 1e9 * series.for_ratio(context_.threads.count()) / double(points.size());
  }

  std::vector<query::Location> locate(std::span<const Vec3d> points) const {
    std::vector<query::Location> at(points.size());
    mesh_->sampler().locate(context_.threads, points, at, {INSITU_FAST});
    return at;
  }
  double value(const query::Location& at) const {
    double v = std::nan("");
    if (at)
      mesh_->sampler().interpolate(mesh_->mesh().field("f"), at, &v);
    return v;
  }
  core::Image draw(const render::Camera& camera, int size) {
    render::FrameSettings settings = march_frame(*mesh_, size);
    settings.camera = camera;
    settings.volume->accuracy = INSITU_FAST;
    return frames_->draw(settings).color;
  }
  const mesh::MeshView& view() const { return mesh_->mesh().view(); }

private:
  core::Context& context_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
  std::unique_ptr<KeptFrames> frames_;
};

} // namespace

Table measure_faces(const AdaptiveCase& mesh, const Held& ours, const Held& reference, int views,
                    int size, int repetitions) {
  Table t;
  t.key = std::string("zellmann-8-") + mesh.key();
  t.title =
      std::string("Figure 8: planar against bilinear faces of stitching cells, ") + mesh.name();
  t.caption =
      "Samples of the orbit's views (one tile in four) that lie in stitching cells. The test "
      "alone: "
      "nanoseconds to tell whether such a sample lies in its cell, in double on one core, by the "
      "planes of the faces, and by Newton's method on the trilinear map, as the paper has it from "
      "Open VKL. Cells by rays: nanoseconds to find the cells of all samples and nothing else, by "
      "shared_faces and shared_bilinear_faces in `fast` on the reference's dual mesh, whose cubes "
      "are hexahedra. What planar faces then get wrong: samples in another cell or none, values "
      "(of 1; root of the mean square over all samples, and the largest), and ray-marched images "
      "(the root of the mean square over colours), beside the same by bilinear ones.";
  t.label = "view";
  t.columns = {"samples",         "in stitching",    "planar ns",   "bilinear ns",
               "bilinear/planar", "by rays: planar", "bilinear ns", "other cell",
               "value, rms",      "largest",         "image"};
  t.left_out = {"the paper's curves (a figure without numbers)."};
  core::Context& context = *reference.context;
  ByFaces planar(reference.plain, accel::Method::shared_faces, context),
      bilinear(reference.plain, accel::Method::shared_bilinear_faces, context);
  const query::Sampler sampler = ours.mesh->sampler();
  const std::int64_t first_stitching = sampler.mesh().first_cell[1];
  for (int i = 0; i < views; ++i) {
    progress(format("figure 8, %s, view %d of %d", mesh.name(), i + 1, views));
    render::FrameSettings settings = march_frame(*ours.mesh, size);
    settings.camera = orbit(i, views);
    const auto points = lattice_points(sampler, settings, 2);
    std::vector<query::Location> at(points.size());
    sampler.locate(ours.context->threads, points, at);
    for (query::Location& l : at)
      l = l.cell >= first_stitching ? l : query::Location{};
    const FaceTests tests = time_face_tests(sampler.mesh(), points, at, repetitions);
    const double ns[2] = {planar.find(points, repetitions), bilinear.find(points, repetitions)};
    const auto p = planar.locate(points), b = bilinear.locate(points);
    std::int64_t other = 0;
    double sum = 0.0, largest = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (p[k].cell == b[k].cell)
        continue;
      ++other;
      const double error = std::fabs(planar.value(p[k]) - bilinear.value(b[k]));
      if (!std::isfinite(error))
        continue;
      sum += error * error;
      largest = std::max(largest, error);
    }
    const double image = accuracy::rms_error(planar.draw(settings.camera, size),
                                             bilinear.draw(settings.camera, size));
    t.add("here", std::to_string(i),
          {std::int64_t(points.size()),
           std::int64_t(std::count_if(at.begin(), at.end(), [](const auto& l) { return bool(l); })),
           Cell(tests.planar_ns, "%.1f"), Cell(tests.bilinear_ns, "%.1f"),
           Cell(tests.bilinear_ns / tests.planar_ns, "%.2f"), Cell(ns[0], "%.0f"),
           Cell(ns[1], "%.0f"), other, Cell(std::sqrt(sum / double(points.size())), "%.1e"),
           Cell(largest, "%.1e"), Cell(image, "%.1e")});
  }
  return t;
}

} // namespace insitu::bench::paper
