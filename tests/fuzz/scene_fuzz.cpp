// Whatever the text, reading it as a scene, as a file of points and as a condition ends in a
// description that keeps the promises of description.h, or in core::Error(INSITU_ERROR_SCENE) with
// a message; never otherwise.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/status.h"
#include "scene/parse/parse.h"
#include "scene/probes/points.h"
#include "scene/probes/points_file.h"

using namespace insitu;

namespace {

void require(bool holds, const char* what) {
  if (!holds) {
    std::fprintf(stderr, "broken promise: %s\n", what);
    std::abort();
  }
}

bool finite(const math::Vec3d& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check_points(const scene::PointSource& source) {
  const std::int64_t count = scene::point_count(source);
  const bool is_file = std::holds_alternative<scene::PointFile>(source);
  require(is_file ? count == 0 : count >= 1 && count <= 1'000'000'000, "count of points");
  if (const auto* list = std::get_if<scene::PointList>(&source)) {
    for (const math::Vec3d& point : list->points) {
      require(finite(point), "finite points");
    }
  }
  for (const std::int64_t index : {std::int64_t{0}, count / 2, count - 1}) {
    if (count > 0) {
      (void)scene::point_at(source, index);
    }
  }
}

void check_trigger(const scene::Trigger& trigger) {
  require(trigger.every >= 1, "every >= 1");
  (void)trigger.due(0, 0.5, [](scene::Reduction, const std::string& field) {
    require(!field.empty(), "a reduction has a field");
    return 1.0;
  });
}

void check_name(const std::string& name) {
  require(!name.empty() && name[0] != '.' && name.find('/') == std::string::npos, "names of files");
}

void check_layer(const scene::Frame& frame, const scene::FrameLayer& layer) {
  require(layer.volume || !layer.isosurfaces.empty() || layer.boundary ||
              (frame.layers.size() == 1 && (!frame.bodies.empty() || frame.outline)),
          "something to draw");
  if (layer.volume) {
    require(!layer.volume->field.empty(), "a volume's field");
    const auto& range = layer.volume->colors.range;
    require(!range || range->low < range->high, "range");
    require(!range || layer.volume->colors.scale != render::Scale::log || range->low > 0,
            "a logarithmic range above 0");
  }
  for (const scene::Isosurface& surface : layer.isosurfaces) {
    require(!surface.field.empty() && !surface.values.empty(), "an isosurface's field and values");
  }
}

void check(const scene::SceneDescription& described) {
  require(!described.output.empty(), "an output folder");
  check_trigger(described.trigger);
  for (const scene::Probe& probe : described.probes) {
    check_name(probe.name);
    check_points(probe.points);
    check_trigger(probe.trigger);
    require(!probe.output.empty(), "an output format");
  }
  for (const scene::Tracer& tracer : described.tracers) {
    check_name(tracer.name);
    check_points(tracer.seeds);
    check_trigger(tracer.trigger);
    require(!tracer.velocity.empty() && !tracer.output.empty(), "velocity and output");
    require(tracer.integrator.tolerance > 0 && tracer.integrator.max_steps >= 1, "integrator");
  }
  for (const scene::Frame& frame : described.frames) {
    check_name(frame.name);
    check_trigger(frame.trigger);
    for (const int side : frame.size) {
      require(side >= 1 && side <= 16384, "size of frames");
    }
    require(!frame.layers.empty(), "a mesh");
    for (const scene::FrameLayer& layer : frame.layers) {
      check_layer(frame, layer);
    }
    require(frame.camera.fov > 0 && frame.camera.fov < 180 && frame.camera.zoom > 0, "camera");
    require(!frame.images.empty() && !frame.formats.empty(), "images and their formats");
    require(frame.background_alpha >= 0 && frame.background_alpha <= 1, "background");
    for (const scene::NamedCamera& camera : frame.cameras) {
      check_name(camera.name);
      for (std::size_t i = 1; i < camera.camera.path.size(); ++i) {
        require(camera.camera.path[i].at > camera.camera.path[i - 1].at, "a path that ascends");
      }
    }
  }
}

/// Runs `read`, which may throw core::Error of a bad scene and nothing else.
template <class Read>
void attempt(const Read& read) {
  try {
    read();
  } catch (const core::Error& error) {
    const std::string_view message = error.what();
    require(error.status() == INSITU_ERROR_SCENE, "the status of a bad scene");
    require(message.substr(0, 6) == "input:", "messages begin with the file");
    require(message.size() < 100'000, "messages of moderate length");
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  attempt([&] { check(scene::parse_scene_text(text, "input")); });
  attempt([&] {
    const scene::PointTable table = scene::parse_points_text(text, "input");
    require(!table.points.empty(), "points of a file");
    require(table.names.empty() || table.names.size() == table.points.size(),
            "a name for each point");
    for (const math::Vec3d& point : table.points) {
      require(finite(point), "finite points of a file");
    }
  });
  attempt([&] {
    const scene::Expression condition = scene::Expression::parse(text, "input", 1);
    (void)condition.evaluate(1, 2, [](scene::Reduction, const std::string&) { return 3.0; });
  });
  return 0;
}
