#include <algorithm>
#include <cmath>
#include <iterator>

#include "accuracy/images.h"
#include "accuracy/sweeps.h"
#include "commands.h"
#include "report/format.h"
#include "commands/render.h"

namespace insitu::bench::accuracy {

namespace {

using render::FrameSettings;

/// A hill in the unit box, from 0 to 1.
double hill(const math::Vec3d& p) {
  const math::Vec3d d = p - math::Vec3d{0.45, 0.5, 0.55};
  return std::exp(-dot(d, d) / 0.08);
}

class Drawing {
public:
  explicit Drawing(const Extent& extent) : extent_(extent), setup_(options(extent)) {
    for (std::size_t v = 0; v < setup_.field.size(); ++v)
      setup_.field[v] = hill(setup_.mesh.point(std::int64_t(v)));
    mesh_ = setup_.register_mesh();
    setup_.commit(*mesh_);
  }

  /// Opacity that rises with the value everywhere; or a shell of a twentieth of the range.
  render::TransferFunction soft() const {
    return {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0.0, 0.0}, {1.0, 0.15}}};
  }
  render::TransferFunction shell() const {
    return {
        render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0.475, 0.0}, {0.5, 0.5}, {0.525, 0.0}}};
  }

  FrameSettings frame(const render::TransferFunction& function) const {
    FrameSettings s;
    s.width = s.height = extent_.quick ? 64 : 256;
    s.camera = render::Camera::around({0, 0, 0}, {1, 1, 1}, 30, 20);
    s.background = {0, 0, 0};
    s.volume = render::VolumeSettings{{mesh_->mesh().field("f"), 0}, function};
    s.volume->skip_empty = false;
    s.volume->unit_distance = 0.01 * std::sqrt(3.0); // what 0 means here, which peers do not know
    return s;
  }

  core::Image draw(const FrameSettings& settings, render::FrameStatistics* statistics) {
    return render::render_frame(mesh_->sampler(), settings, setup_.context.threads,
                                setup_.context.memory, statistics)
        .color;
  }

  /// A frame to be measured.
  struct Frame {
    std::string name;
    FrameSettings settings;
    bool is_default = false;
  };
  /// Draws them in turns, so that ratios of them tell. finish(setting, statistics) sets the work
  /// and what follows the images' dissimilarity in Setting::more.
  template <class Finish>
  void measure(Sweep& to, const std::string& group, const std::vector<Frame>& frames,
               const core::Image& truth, Finish&& finish) {
    std::vector<Setting> settings(frames.size());
    for (int i = 0; i < extent_.repetitions; ++i)
      for (std::size_t k = 0; k < frames.size(); ++k) {
        Setting& s = settings[k];
        render::FrameStatistics statistics;
        core::Image image;
        s.time.time([&] { image = draw(frames[k].settings, &statistics); });
        if (i > 0)
          continue;
        s.group = group;
        s.name = frames[k].name;
        s.is_default = frames[k].is_default;
        s.error = rms_error(image, truth);
        s.more = {dissimilarity(image, truth)};
        finish(s, statistics);
      }
    std::move(settings.begin(), settings.end(), std::back_inserter(to.settings));
  }

  /// VTK's ray cast mapper, if there is one and it has a display; else says why not.
  void measure_peer(Sweep& to, const std::string& group, const FrameSettings& settings,
                    const core::Image& truth) {
    std::string why;
    const auto vtk = draw_by_vtk(setup_.mesh, setup_.field, settings, extent_.repetitions, why);
    if (!vtk) {
      to.notes.push_back("No frame by VTK's ray cast mapper: " + why + ".");
      return;
    }
    Setting s;
    s.group = group;
    s.name = "vtkUnstructuredGridVolumeRayCastMapper";
    s.is_peer = true;
    s.time = vtk->time;
    s.error = rms_error(vtk->color, truth);
    s.more = {dissimilarity(vtk->color, truth), std::nan("")};
    to.settings.push_back(std::move(s));
  }

private:
  static Options options(const Extent& extent) {
    Options o;
    o.cells = {extent.quick ? 4096 : 100'000};
    return o;
  }
  Extent extent_;
  Setup setup_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
};

std::string advise(const Sweep& s) {
  const Setting *plain = s.find("soft function", "plain, step 1"),
                *half = s.find("soft function", "plain, step 0.5");
  const Setting *shell = s.find("thin shell", "plain, step 1"),
                *integrated = s.find("thin shell", "pre-integrated, step 1"),
                *skipping = s.find("thin shell", "plain, step 1, skipping");
  std::string out =
      format("Half the step takes %.2f times the time for %.1f times less error where the "
             "function is soft. On a thin "
             "shell pre-integration has %.1f times less error at the default step for %.2f "
             "times the time, and space "
             "skipping, which a scene has unless it says otherwise, takes %.2f of the time for "
             "the same image.",
             half->seconds() / plain->seconds(), plain->error / half->error,
             shell->error / integrated->error, integrated->seconds() / shell->seconds(),
             skipping->seconds() / shell->seconds());
  out +=
      format(" Samples located one of a ray at a time take %.2f times the time of the groups that "
             "are chosen, groups of 32 %.2f times.",
             s.find("soft function", "plain, step 1, groups of 1")->seconds() / plain->seconds(),
             s.find("soft function", "plain, step 1, groups of 32")->seconds() / plain->seconds());
  const Setting* chosen = s.default_of("soft function");
  if (const Setting* vtk = s.find("soft function", "vtkUnstructuredGridVolumeRayCastMapper"))
    out +=
        format(" vtkUnstructuredGridVolumeRayCastMapper takes %.1f times the time of the default "
               "there and errs by %.2g (%.2g).",
               vtk->seconds() / chosen->seconds(), vtk->error, chosen->error);
  return out;
}

} // namespace

Sweep sweep_volume(const Extent& extent) {
  Sweep s;
  s.key = "volume";
  s.title = "Volumes by ray marching";
  s.swept =
      "Ray step from 4 times to a quarter of the default (half a cell), plain and pre-integrated "
      "look-up, "
      "samples of a ray located in groups, error bounds, space skipping; a function that is soft "
      "and one that shows a thin shell.";
  s.reference = "The frame with 1/64 of the default step, pre-integrated.";
  s.error_label = "error of the image, root mean square of linear colours";
  s.work_label = "samples located";
  s.time_label = "seconds a frame, one core";
  s.more_labels = {"1 - structural similarity", "samples skipped"};
  Drawing drawing(extent);
  const std::pair<const char*, render::TransferFunction> functions[] = {
      {"soft function", drawing.soft()}, {"thin shell", drawing.shell()}};
  for (const auto& [group, function] : functions) {
    progress(std::string("volume: ") + group);
    const FrameSettings base = drawing.frame(function);
    FrameSettings converged = base;
    converged.volume->step_factor /= 64; // of order 2: 256 times better than the finest step below
    converged.volume->preintegrated = true;
    const core::Image truth = drawing.draw(converged, nullptr);
    std::vector<Drawing::Frame> frames;
    const auto add = [&](const std::string& name, double factor, bool preintegrated, bool skips) {
      FrameSettings settings = base;
      settings.volume->step_factor *= factor;
      settings.volume->preintegrated = preintegrated;
      settings.volume->skip_empty = skips;
      frames.push_back({name + format(", step %g", factor) + (skips ? ", skipping" : ""), settings,
                        skips && !preintegrated && factor == 1.0});
    };
    for (const double factor : {4.0, 2.0, 1.0, 0.5, 0.25}) {
      add("plain", factor, false, false);
      add("pre-integrated", factor, true, false);
    }
    for (const double factor : {2.0, 1.0, 0.5})
      add("plain", factor, false, true);
    add("pre-integrated", 1.0, true, true);
    for (const int at_once : {1, 4, 8, 16, 32}) {
      frames.push_back({format("plain, step 1, groups of %d", at_once), base});
      frames.back().settings.volume->sample_group = at_once;
    }
    for (const double tolerance : {0.1, 0.01, 0.001}) {
      frames.push_back({format("error bound, %g", tolerance), base});
      frames.back().settings.volume->tolerance = tolerance;
    }
    drawing.measure(s, group, frames, truth,
                    [](Setting& one, const render::FrameStatistics& statistics) {
                      one.work = double(statistics.samples);
                      one.more.push_back(double(statistics.skipped));
                    });
    if (group == functions[0].first) // 8 bits a colour cannot follow a thin shell
      drawing.measure_peer(s, group, base, truth);
  }
  s.advice = advise(s);
  return s;
}

namespace {

constexpr const char* majorants = "resolution of the majorants";
constexpr double majorant_cells[] = {4, 16, 64, 256, 1024, 4096};

std::string majorants_of(double cells) {
  return format("macrocells of %g cells", cells);
}

} // namespace

Sweep sweep_path_tracing(const Extent& extent) {
  Sweep s;
  s.key = "path_tracing";
  s.title = "Volumes by path tracing";
  s.swept =
      "Samples a pixel, with single and with multiple scattering; how many cells a macrocell of "
      "the majorants has.";
  constexpr int most_samples = 256;
  const int reference_samples = (extent.quick ? 4 : 100) * most_samples;
  s.reference = format("The frame with %s samples a pixel and other random numbers: 1/%d of the "
                       "variance of the most that is swept.",
                       grouped(reference_samples).c_str(), reference_samples / most_samples);
  s.error_label = "error of the image, root mean square of linear colours";
  s.work_label = "points located";
  s.time_label = "seconds a frame, one core";
  s.more_labels = {"1 - structural similarity", "variance of a pixel"};
  Drawing drawing(extent);
  for (const auto scattering : {render::Scattering::single, render::Scattering::multiple}) {
    const std::string group =
        scattering == render::Scattering::single ? "single scattering" : "multiple scattering";
    progress("path tracing: " + group);
    FrameSettings base = drawing.frame(drawing.soft());
    base.width = base.height = extent.quick ? 32 : 96;
    base.path_tracing = render::PathTracingSettings{};
    base.path_tracing->scattering = scattering;
    base.lighting.lights = {{render::Light::Kind::directional, {1, 1, 2}, {1, 1, 1}},
                            {render::Light::Kind::dome, {}, {0.3f, 0.3f, 0.3f}}};
    FrameSettings converged = base;
    converged.path_tracing->samples = reference_samples;
    converged.path_tracing->seed = 1;
    const core::Image truth = drawing.draw(converged, nullptr);
    std::vector<Drawing::Frame> frames;
    for (const int samples : {1, 4, 16, 64, most_samples}) {
      frames.push_back({group + ", " + std::to_string(samples), base, samples == 64});
      frames.back().settings.path_tracing->samples = samples;
    }
    const auto finish = [](Setting& one, const render::FrameStatistics& statistics) {
      one.work = double(statistics.paths.locations);
      one.more.push_back(one.error * one.error);
    };
    drawing.measure(s, group, frames, truth, finish);
    if (scattering != render::Scattering::single)
      continue;
    // Majorants change no expectation: only how many points are located, and the walk to them.
    frames.clear();
    for (const double cells : majorant_cells) {
      frames.push_back(
          {majorants_of(cells), base, cells == base.path_tracing->cells_per_macrocell});
      frames.back().settings.path_tracing->samples = 64;
      frames.back().settings.path_tracing->cells_per_macrocell = cells;
    }
    drawing.measure(s, majorants, frames, truth, finish);
  }
  const Setting *single = s.default_of("single scattering"),
                *multiple = s.default_of("multiple scattering"),
                *quarter = s.find("multiple scattering", "multiple scattering, 16");
  const Setting *chosen = s.default_of(majorants), *fastest = chosen;
  for (const Setting& one : s.settings)
    if (one.group == majorants && one.seconds() < fastest->seconds())
      fastest = &one;
  s.advice =
      format("Four times the samples halve the error: 64 a pixel leave %.2g (16: %.2g). Multiple "
             "scattering takes "
             "%.2f times the time of single at as many samples, and an error %.2f times as large.",
             multiple->error, quarter->error, multiple->seconds() / single->seconds(),
             multiple->error / single->error) +
      format(" Of the macrocells, %s are fastest: the default takes %.2f times as long; from %g to "
             "%g cells to each, the points located grow %.1f times.",
             fastest->name.c_str(), chosen->seconds() / fastest->seconds(), majorant_cells[0],
             *std::rbegin(majorant_cells),
             s.find(majorants, majorants_of(*std::rbegin(majorant_cells)).c_str())->work /
                 s.find(majorants, majorants_of(majorant_cells[0]).c_str())->work);
  return s;
}

} // namespace insitu::bench::accuracy
