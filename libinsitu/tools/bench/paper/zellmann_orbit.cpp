#include <algorithm>
#include <cmath>

#include "report/chart.h"
#include "commands.h"
#include "report/format.h"
#include "commands/kept_frames.h"
#include "commands/lattice_rays.h"
#include "paper/zellmann_meshes.h"

namespace insitu::bench::paper {

namespace {

using math::Vec3d;

struct View {
  std::int64_t gridlets = 0, stitching = 0, outside = 0, samples = 0, locations = 0;
  double march = 0.0, march_reference = 0.0, paths = 0.0; ///< seconds
  double gridlet_ns = NAN, stitching_ns = NAN;            ///< to locate such a sample
};

View look(const Held& ours, KeptFrames& frames, const Held& reference, KeptFrames& reference_frames,
          const render::Camera& camera, int size, int repetitions) {
  View out;
  render::FrameSettings settings = march_frame(*ours.mesh, size);
  settings.camera = camera;
  render::FrameStatistics statistics;
  out.march = frames.time(settings, repetitions, &statistics);
  out.samples = statistics.samples;
  const query::Sampler sampler = ours.mesh->sampler();
  const std::vector<Vec3d> points = lattice_points(sampler, settings, 1);
  std::vector<query::Location> at(points.size());
  sampler.locate(ours.context->threads, points, at);
  const std::int64_t first = sampler.mesh().first_cell[1];
  std::vector<Vec3d> of[2];
  for (std::size_t i = 0; i < at.size(); ++i)
    if (at[i])
      of[at[i].cell < first].push_back(points[i]);
  out.gridlets = std::int64_t(of[1].size());
  out.stitching = std::int64_t(of[0].size());
  out.outside = std::int64_t(points.size()) - out.gridlets - out.stitching;
  for (const bool gridlets : {false, true}) {
    const std::vector<Vec3d>& some = of[gridlets];
    if (some.empty())
      continue;
    Series series;
    for (int i = 0; i < repetitions; ++i)
      series.time(
          [&] { sampler.locate(ours.context->threads, some, std::span(at).first(some.size())); });
    (gridlets ? out.gridlet_ns : out.stitching_ns) =
        1e9 * series.for_ratio(ours.context->threads.count()) / double(some.size());
  }
  settings = march_frame(*reference.mesh, size);
  settings.camera = camera;
  out.march_reference = reference_frames.time(settings, repetitions);
  settings = path_frame(*ours.mesh, size);
  settings.camera = camera;
  out.paths = frames.time(settings, repetitions, &statistics);
  out.locations = statistics.paths.locations;
  return out;
}

} // namespace

Orbit measure_orbit(const AdaptiveCase& mesh, const Held& ours, const Held& reference, int views,
                    int size, int repetitions) {
  Orbit out;
  std::vector<View> all;
  KeptFrames frames(*ours.mesh, ours.context->memory, ours.context->threads),
      reference_frames(*reference.mesh, reference.context->memory, reference.context->threads);
  for (int i = 0; i < views; ++i) {
    progress(format("figure 7, %s, view %d of %d", mesh.name(), i + 1, views));
    all.push_back(
        look(ours, frames, reference, reference_frames, orbit(i, views), size, repetitions));
    const View& v = all.back();
    out.failed = out.failed || v.gridlets + v.stitching + v.outside != v.samples;
  }
  Table& t = out.figure_7;
  t.key = std::string("zellmann-7-") + mesh.key();
  t.title = std::string("Figure 7: rendering time against cells sampled, ") + mesh.name();
  t.caption = format("Frames of %d x %d from %d places around the mesh, at five distances in turn. "
                     "Ray marching, whose samples "
                     "are the frame's own, told apart by the cells that they lie in; path tracing "
                     "from the same places, one path a pixel, with the points that it locates. "
                     "Nanoseconds: to locate the samples of one kind alone.",
                     size, size, views);
  t.label = "view";
  t.columns = {"gridlets",    "stitching", "outside",     "all samples", "march s",
               "reference s", "paths s",   "path points", "gridlet ns",  "stitching ns"};
  t.left_out = {"the paper's curves (a figure without numbers); path tracing's points by kind."};
  Chart chart{std::string("Figure 7: ") + mesh.name(), "samples of a frame",
              "seconds, ray marching"};
  for (const bool gridlets : {true, false}) {
    Chart::Line line;
    line.label = gridlets ? "gridlet samples" : "stitching samples";
    for (const View& v : all)
      if (const double n = double(gridlets ? v.gridlets : v.stitching); n > 0 && v.march > 0)
        line.points.push_back({n, v.march, "", ""});
    std::sort(line.points.begin(), line.points.end(),
              [](const Chart::Point& a, const Chart::Point& b) { return a.x < b.x; });
    chart.lines.push_back(line);
  }
  out.plot = svg({chart});
  for (std::size_t i = 0; i < all.size(); ++i) {
    const View& v = all[i];
    t.add("here", std::to_string(i),
          {v.gridlets, v.stitching, v.outside, v.samples, v.march, v.march_reference, v.paths,
           v.locations, Cell(v.gridlet_ns, "%.0f"), Cell(v.stitching_ns, "%.0f")});
  }
  out.figure_8 = measure_faces(mesh, ours, reference, std::min(views, 8), size, repetitions);
  return out;
}

} // namespace insitu::bench::paper
