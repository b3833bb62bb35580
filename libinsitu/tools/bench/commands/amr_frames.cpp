#include "commands/amr_frames.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "report/format.h"
#include "commands/kept_frames.h"
#include "paper/zellmann_meshes.h"
#include "report/report.h"

namespace insitu::bench {

namespace {

/// Pixels along an edge; few for the small meshes of tests.
int frame_size(const Options& o) {
  return o.cells[0] < 100'000 ? 48 : 256;
}

using render::FrameSettings;
using render::Structures;

/// Frames of one mesh and function.
struct FrameRow {
  std::string mesh, function;
  std::int64_t primitives = 0, culled = 0, bytes = 0;
  // Seconds. Of new values: macrocells' and primitives' ranges; of another function.
  double refresh = 0, ranges = 0, reclassify = 0, cull = 0;
  /// Of a frame when all is there: all samples, without empty macrocells where these pay, among
  /// what is not culled, and both asked for.
  double plain = 0, skip = 0, culled_plain = 0, culled_skip = 0;
  double paths = 0, culled_paths = 0;
  bool differs = false;
};

bool same(const core::Image& a, const core::Image& b) {
  const std::size_t n = std::size_t(a.width) * std::size_t(a.height);
  for (int y = 0; y < a.height; ++y)
    if (std::memcmp(a.pixel(0, y), b.pixel(0, y), 16 * std::size_t(a.width)) != 0)
      return false;
  return n > 0;
}

class Measure {
public:
  Measure(const paper::AdaptiveCase& mesh, const Options& o)
      : o_(o), name_(mesh.name()), held_(paper::hold(mesh, o.threads)) {}

  FrameRow run(const std::string& name, std::vector<render::OpacityPoint> opacity) {
    FrameRow row;
    row.mesh = name_;
    row.function = name;
    FrameSettings s = paper::march_frame(*held_.mesh, frame_size(o_));
    s.volume->function = {render::ColorMap::built_in("viridis"), 0.0, 1.0, opacity};
    costs(s, row);
    KeptFrames frames(*held_.mesh, held_.context->memory, held_.context->threads);
    core::Image image[2];
    for (const bool skip : {false, true})
      for (const bool cull : {false, true}) {
        s.volume->skip_empty = skip;
        s.volume->culling = cull ? render::Culling::always : render::Culling::never;
        render::FrameStatistics statistics;
        double& seconds =
            skip ? (cull ? row.culled_skip : row.skip) : (cull ? row.culled_plain : row.plain);
        seconds = frames.time(s, o_.repetitions, &statistics);
        image[cull] = frames.draw(s).color;
        if (cull) {
          row.primitives = statistics.primitives;
          row.culled = statistics.culled;
          row.differs = row.differs || !same(image[0], image[1]);
        }
      }
    s.path_tracing = render::PathTracingSettings{};
    s.path_tracing->samples = 1;
    s.lighting.lights = {{render::Light::Kind::dome, {}, {1, 1, 1}}};
    for (const bool cull : {false, true}) {
      s.volume->culling = cull ? render::Culling::always : render::Culling::never;
      (cull ? row.culled_paths : row.paths) = frames.time(s, o_.repetitions);
      image[cull] = frames.draw(s).color;
    }
    row.differs = row.differs || !same(image[0], image[1]);
    return row;
  }

private:
  /// Of what frames keep: as after a commit of new values, and as after another function alone.
  void costs(const FrameSettings& s, FrameRow& row) const {
    const core::Memory& memory = held_.context->memory;
    Structures structures(held_.context->memory);
    const query::Sampler sampler = held_.mesh->sampler();
    const render::VolumeSettings& v = *s.volume;
    const render::TransferFunction other(render::ColorMap::built_in("viridis"), 0.0, 1.0,
                                         {{0.0, 0.0}, {1.0, 0.5}});
    std::uint64_t fields = 0;
    const auto ask = [&](const render::TransferFunction& function) {
      (void)structures.majorants(v.field, function);
      (void)structures.culled(v.field, function);
    };
    const auto begin = [&] { structures.begin(sampler, 0, ++fields, held_.context->threads); };
    begin();
    const std::int64_t before = memory.current();
    (void)structures.culled(v.field, v.function);
    row.bytes = memory.current() - before;
    ask(v.function); // touches pages
    std::vector<double> seconds[4];
    for (int i = 0; i < o_.repetitions; ++i) {
      structures.end();
      begin();
      const Structures::Seconds was = structures.seconds();
      ask(v.function);
      const Structures::Seconds is = structures.seconds();
      seconds[0].push_back(is.macrocells - was.macrocells);
      seconds[1].push_back(is.primitive_ranges - was.primitive_ranges);
      structures.end();
      structures.begin(sampler, 0, fields, held_.context->threads);
      ask(other);
      structures.end();
      structures.begin(sampler, 0, fields, held_.context->threads);
      const Structures::Seconds then = structures.seconds();
      ask(v.function);
      seconds[2].push_back(structures.seconds().majorants - then.majorants);
      seconds[3].push_back(structures.seconds().culled - then.culled);
    }
    double* const to[] = {&row.refresh, &row.ranges, &row.reclassify, &row.cull};
    for (int i = 0; i < 4; ++i) {
      Series series;
      for (const double x : seconds[i])
        series.add(x);
      *to[i] = series.median();
    }
  }

  const Options& o_;
  std::string name_;
  paper::Held held_;
};

} // namespace

AmrFrames measure_amr_frames(const Options& options) {
  std::vector<FrameRow> rows;
  for (const bool octree : {false, true}) {
    const paper::AdaptiveCase mesh = octree ? paper::AdaptiveCase::of_octree(options.cells[0])
                                            : paper::AdaptiveCase::of_blocks(options.cells[0]);
    Measure measure(mesh, options);
    for (const auto& [name, opacity] : {std::pair<const char*, std::vector<render::OpacityPoint>>{
                                            "shell", {{0.45, 0.0}, {0.5, 0.02}, {0.55, 0.0}}},
                                        {"inside", {{0.5, 0.0}, {0.5, 0.005}, {1.0, 0.01}}},
                                        {"all", {{0.0, 0.001}, {1.0, 0.005}}}}) {
      progress(std::string("frames, ") + mesh.name() + ", " + name);
      rows.push_back(measure.run(name, opacity));
    }
  }
  AmrFrames out;
  out.text = format("frames of %d x %d by ray marching, seconds. Ranges of macrocells and of "
                    "primitives (gridlets and stitching cells)\n"
                    "after new values; both classified after another function; ",
                    frame_size(options), frame_size(options));
  out.text += "a frame when these are there: all samples,\n"
              "among what shows (cull), without empty macrocells where these pay (skip), both so; "
              "paths: one a pixel; MB: ranges\n"
              "and tree of what shows\n\n";
  out.text += format("%-13s %-6s %6s | %7s %7s %7s %7s | %6s %6s %6s %6s | %6s %6s | %5s %s\n", "",
                     "shows", "culled", "macroc.", "primit.", "major.", "cull", "all", "cull",
                     "skip", "both", "paths", "cull", "MB", "images");
  for (const FrameRow& r : rows) {
    out.differ = out.differ || r.differs;
    const double share = double(r.culled) / double(std::max<std::int64_t>(1, r.primitives));
    out.text +=
        format("%-13s %-6s %5.0f%% | %7.4f %7.4f %7.4f %7.4f | %6.3f %6.3f %6.3f %6.3f | "
               "%6.3f %6.3f | %5.1f %s\n",
               r.mesh.c_str(), r.function.c_str(), 100.0 * share, r.refresh, r.ranges, r.reclassify,
               r.cull, r.plain, r.culled_plain, r.skip, r.culled_skip, r.paths, r.culled_paths,
               1e-6 * double(r.bytes), r.differs ? "differ" : "same");
    out.json["frames of " + r.mesh + ", " + r.function] = {
        {"primitives", r.primitives},
        {"culled", r.culled},
        {"refresh_s", number(r.refresh)},
        {"ranges_s", number(r.ranges)},
        {"reclassify_s", number(r.reclassify)},
        {"cull_s", number(r.cull)},
        {"frame_s", number(r.plain)},
        {"frame_culled_s", number(r.culled_plain)},
        {"frame_skip_s", number(r.skip)},
        {"frame_skip_culled_s", number(r.culled_skip)},
        {"paths_s", number(r.paths)},
        {"paths_culled_s", number(r.culled_paths)},
        {"bytes", r.bytes},
        {"differs", int(r.differs)}};
  }
  return out;
}

} // namespace insitu::bench
