#include "commands/render.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "accuracy/images.h"
#include "commands.h"
#include "commands/kept_frames.h"
#include "commands/lattice_rays.h"
#include "commands/pixel_sweep.h"
#include "commands/refreshed_frames.h"
#include "output/image/png.h"
#include "peers/openvkl_parts.h"
#include "render/structures/structures.h"
#include "report/format.h"
#include "report/json.h"

namespace insitu::bench {

namespace {

using accuracy::rms_error;
using core::Image;
using render::FrameSettings;

/// A frame as it was drawn, some times.
struct Drawn {
  std::string name;
  double factor = 0.0; ///< of the default step
  Series one, all;     ///< on one thread; on all of the machine's
  render::FrameStatistics statistics;
  /// Of the converged frame: the root of the mean square over colours; nothing where that is
  /// another frame.
  std::optional<double> error;
  Image image;
};

class Bench {
public:
  explicit Bench(const Options& o) : o_(o), setup_(o), all_(0) {
    const std::vector<double>& f = setup_.field;
    low_ = *std::min_element(f.begin(), f.end());
    high_ = *std::max_element(f.begin(), f.end());
    mesh_ = setup_.register_mesh();
    setup_.commit(*mesh_);
  }

  Output run() {
    const FrameSettings base = frame(function(0.0, 0.02));
    progress("converged frame");
    const Image truth = draw(base, converged, nullptr, nullptr).image;
    save("converged", truth);
    text_ = "insitu-bench render: " + describe(o_, setup_.mesh.cell_count(), 1) + ", frames of " +
            std::to_string(o_.size) + " x " + std::to_string(o_.size) + "\n\n";
    text_ +=
        format("%-30s %6s %9s %9s %9s %9s %9s %10s\n", "frame", "step", "1 core s", "prepare s",
               format("%d cores", all_.count()).c_str(), "Msamples", "M/s, core", "error");
    for (const double factor : {2.0, 1.0, 0.5, 0.25})
      add(measure("volume", base, factor, &truth));
    rows_.front().name = "volume"; // the one that others are held against
    const FrameSettings opaque = frame(function(0.0, 0.6)), sparse = frame(band());
    add(measure("dense: rays end early", opaque, 1.0, nullptr));
    add(measure("sparse: little shows", sparse, 1.0, nullptr));
    add(measure_kept("sparse, structures kept", sparse));
    FrameSettings surface = base;
    surface.volume.reset();
    surface.isosurfaces.push_back(
        {render::ScalarField{mesh_->mesh().field("f"), 0}, {0.5 * (low_ + high_)}, 1});
    add(measure("isosurface", surface, 1.0, nullptr));
    surface.isosurfaces[0].search = render::RootSearch::cubic;
    add(measure("isosurface, cubics ray by ray", surface, 1.0, nullptr));
    surface.isosurfaces[0].search = render::RootSearch::exact;
    surface.lighting.shadows = true;
    surface.lighting.lights.emplace_back().kind = render::Light::Kind::directional;
    surface.lighting.lights[0].vector = {1.0, 0.4, 0.8};
    add(measure("isosurface, shadows", surface, 1.0, nullptr));
    surface.lighting.occlusion_samples = 8;
    add(measure("isosurface, shadows, occlusion", surface, 1.0, nullptr));
    const double bare = rows_[1].one.for_ratio(1);
    text_ += format("\nof the volume at the default step: dense %.2f, sparse %.2f (%.2f with "
                    "structures kept) of the time; steps of 2: %.2f\n",
                    rows_[4].one.for_ratio(1) / bare, rows_[5].one.for_ratio(1) / bare,
                    rows_[6].one.for_ratio(1) / bare, rows_[0].one.for_ratio(1) / bare);
    text_ += format("million rays a second on one core (Rathke 2015, table 4): isosurface %.2f, "
                    "volume %.2f\n",
                    mrays(rows_[7]), mrays(rows_[1]));
    text_ += format("an isosurface by cubics ray by ray takes %.1f times as long as cell by cell\n",
                    rows_[8].one.for_ratio(1) / rows_[7].one.for_ratio(1));
    const PixelSweep sweep =
        sweep_pixels(*mesh_, setup_.context.memory, base, o_.size, o_.repetitions);
    text_ += sweep.text;
    json_.update(sweep.json);
    progress("fields-only commit");
    const RefreshedFrames refreshed = refresh_frames(setup_, *mesh_, with_surface(frame(band())));
    text_ += refreshed.text;
    json_.update(refreshed.json);
    if (o_.peers) {
      vtk(base, truth);
      openvkl();
    }
    groups(base);
    return {text_, json_text(json_), 0};
  }

private:
  static constexpr double converged = 1.0 / 8; ///< of the default step

  render::TransferFunction function(double least, double most) const {
    return {render::ColorMap::built_in("viridis"), low_, high_, {{low_, least}, {high_, most}}};
  }
  /// A shell that a twentieth of the range shows.
  render::TransferFunction band() const {
    const double middle = 0.5 * (low_ + high_), half = 0.025 * (high_ - low_);
    return {render::ColorMap::built_in("viridis"),
            low_,
            high_,
            {{middle - half, 0.0}, {middle, 0.3}, {middle + half, 0.0}}};
  }
  FrameSettings frame(const render::TransferFunction& function) const {
    FrameSettings s =
        standard_frame(mesh_->sampler(), mesh_->mesh().field("f"), low_, high_, o_.size);
    s.volume->function = function;
    s.volume->accuracy = o_.accuracy;
    return s;
  }
  FrameSettings with_surface(FrameSettings settings) const {
    settings.isosurfaces.push_back({render::ScalarField{mesh_->mesh().field("f"), 0},
                                    {0.5 * (low_ + high_)},
                                    0.5,
                                    render::Color{1, 1, 1},
                                    render::Normals::smooth});
    return settings;
  }
  static void set_step(FrameSettings& s, double factor) {
    if (s.volume && s.volume->step)
      *s.volume->step *= factor;
    else if (s.volume)
      s.volume->step_factor *= factor;
  }
  double mrays(const Drawn& d) const {
    return 1e-6 * double(d.statistics.rays) / d.one.for_ratio(1);
  }

  Drawn draw(FrameSettings settings, double factor, Series* one, Series* all) {
    set_step(settings, factor);
    Drawn out;
    const core::Threads single(1);
    const auto render = [&](const core::Threads& threads) {
      out.image = render::render_frame(mesh_->sampler(), settings, threads, setup_.context.memory,
                                       &out.statistics)
                      .color;
    };
    if (all)
      all->time([&] { render(all_); });
    if (one)
      one->time([&] { render(single); });
    if (!one && !all)
      render(all_);
    return out;
  }

  Drawn measure(const std::string& name, const FrameSettings& settings, double factor,
                const Image* truth) {
    progress(name + format(", step %g", factor));
    Series one, all;
    Drawn out;
    for (int i = 0; i < o_.repetitions; ++i)
      out = draw(settings, factor, &one, &all);
    out.name = name;
    out.factor = factor;
    out.one = one;
    out.all = all;
    if (truth)
      out.error = rms_error(out.image, *truth);
    save(name + format("-%g", factor), out.image);
    return out;
  }

  /// The frames of a session after its first, which made what is kept.
  Drawn measure_kept(const std::string& name, const FrameSettings& settings) {
    progress(name);
    const core::Threads single(1);
    KeptFrames on_one(*mesh_, setup_.context.memory, single),
        on_all(*mesh_, setup_.context.memory, all_);
    Drawn out;
    out.name = name;
    out.factor = 1.0;
    for (int i = -1; i < o_.repetitions; ++i) {
      Series first; // makes it
      (i < 0 ? first : out.all).time([&] { (void)on_all.draw(settings); });
      (i < 0 ? first : out.one).time([&] { (void)on_one.draw(settings, &out.statistics); });
    }
    return out;
  }

  void add(const Drawn& d) {
    const double one = d.one.for_ratio(1), all = d.all.median();
    const double rate = d.statistics.samples ? 1e-6 * double(d.statistics.samples) / one : 0.0;
    text_ += format("%-30s %6g %9.3f %9.3f %9.3f %9.2f %9.2f %10s\n", d.name.c_str(), d.factor, one,
                    d.statistics.prepare_seconds, all, 1e-6 * double(d.statistics.samples), rate,
                    d.error ? format("%.2e", *d.error).c_str() : "-");
    json_["frames"].push_back({{"name", d.name},
                               {"step", number(d.factor)},
                               {"one_core_s", number(one)},
                               {"all_cores_s", number(all)},
                               {"prepare_s", number(d.statistics.prepare_seconds)},
                               {"samples", d.statistics.samples},
                               {"rms_error", d.error ? number(*d.error) : Json()}});
    rows_.push_back(d);
  }

  /// VTK's frame against ours that is no worse.
  void vtk(const FrameSettings& settings, const Image& truth) {
    progress("vtkUnstructuredGridVolumeRayCastMapper");
    std::string why;
    const auto frame = draw_by_vtk(setup_.mesh, setup_.field, settings, o_.repetitions, why);
    if (!frame) {
      text_ += "\nno frame by VTK: " + why + "\n";
      return;
    }
    save("vtk", frame->color);
    const double error = rms_error(frame->color, truth);
    text_ += format("\n%s: %s cells after %.2f s of conversion, first frame %.2f s, then %.2f s; "
                    "error %.2e\n",
                    frame->name.c_str(), grouped(frame->cells).c_str(), frame->convert_seconds,
                    frame->first_seconds, frame->time.for_ratio(1), error);
    const Drawn* equal = nullptr;
    for (int i = 0; i < 4; ++i) // the longest step that is no worse
      if (!equal && *rows_[std::size_t(i)].error <= error)
        equal = &rows_[std::size_t(i)];
    json_["vtk"] = {{"cells", frame->cells},
                    {"convert_s", number(frame->convert_seconds)},
                    {"first_s", number(frame->first_seconds)},
                    {"frame_s", number(frame->time.for_ratio(1))},
                    {"rms_error", number(error)}};
    if (equal) {
      const double ratio = frame->time.for_ratio(1) / equal->one.for_ratio(1);
      text_ += format("ours with a step of %g and an error of %.2e is %.1f times as fast\n",
                      equal->factor, *equal->error, ratio);
      json_["vtk"]["ratio_at_equal_error"] = number(ratio);
    } else {
      text_ += "none of ours is as near to the converged frame\n";
    }
  }

  /// The standard workload's frame by Open VKL, in turns with ours, at the same samples.
  void openvkl() {
    FrameSettings settings =
        workload_frame(mesh_->mesh().field("f"), setup_.mesh.cell_count(), o_.size);
    settings.volume->accuracy = o_.accuracy;
    const auto peer = make_openvkl_frame(setup_.mesh, setup_.field, mesh_->sampler(), settings);
    if (!peer) {
      text_ += std::string("\nno frame by Open VKL: ") + no_openvkl + "\n";
      return;
    }
    progress("Open VKL");
    const Image truth = draw(settings, converged, nullptr, nullptr).image;
    struct Way {
      const char* name;
      OpenVklMarch march;
      Series time = {};
      std::int64_t samples = 0;
      Image image = {};
    } ways[] = {{"intervals", OpenVklMarch::intervals}, {"packets", OpenVklMarch::packets}};
    Series build, time;
    build.time([&] { peer->build(); });
    Drawn ours;
    for (int i = 0; i < o_.repetitions; ++i) {
      ours = draw(settings, 1.0, &time, nullptr);
      for (Way& way : ways) {
        way.time.time([&] { way.image = peer->draw(way.march); });
        way.samples = peer->samples();
      }
    }
    save("workload", ours.image);
    const double error = rms_error(ours.image, truth);
    text_ +=
        format("\nthe standard workload's frame, a sample a cell, on one core; Open VKL's volume "
               "is built in %.2f s\n%-30s %9s %9s %10s %6s\n",
               build.for_ratio(1), "", "s", "Msamples", "error", "ratio");
    text_ += format("%-30s %9.3f %9.2f %10.2e\n", "libinsitu", time.for_ratio(1),
                    1e-6 * double(ours.statistics.samples), error);
    Json& json = json_["openvkl"];
    json = {{"build_s", number(build.for_ratio(1))},
            {"ours_s", number(time.for_ratio(1))},
            {"ours_samples", ours.statistics.samples},
            {"ours_rms_error", number(error)}};
    for (const Way& way : ways) {
      const std::string name = std::string("Open VKL, ") + way.name;
      save(name, way.image);
      const double ratio = way.time.for_ratio(1) / time.for_ratio(1);
      const double theirs = rms_error(way.image, truth);
      text_ += format("%-30s %9.3f %9.2f %10.2e %6.2f\n", name.c_str(), way.time.for_ratio(1),
                      1e-6 * double(way.samples), theirs, ratio);
      const std::string key = way.name;
      json.update({{key + "_s", number(way.time.for_ratio(1))},
                   {key + "_samples", way.samples},
                   {key + "_rms_error", number(theirs)},
                   {"ratio_" + key, number(ratio)}});
    }
  }

  /// Rathke 2015, tables 1 to 3: samples located one by one, in batches, and in bundles of rays by
  /// the length of the stretch that is asked for at once.
  void groups(const FrameSettings& settings) {
    const double steps[] = {2.0, 1.0, 0.5, 0.25};
    text_ += "\nmillion samples a second located on one core (Rathke 2015, tables 1 to 3)\n";
    text_ += format("%-34s", "step");
    for (const double step : steps)
      text_ += format(" %8g", step);
    text_ += "\n";
    const int ways[] = {-1, 0, 1, 4, 8, 16, 24, 32};
    for (const int way : ways) {
      const std::string name = way < 0    ? "one by one, the last cell first"
                               : way == 0 ? "batches along rays"
                                          : "bundles, " + std::to_string(way) + " of a ray at once";
      text_ += format("%-34s", name.c_str());
      Json& rates = json_["located_mqps"][name];
      for (const double step : steps) {
        progress(name + format(", step %g", step));
        const double rate = locate_all(settings, step, way);
        text_ += format(" %8.2f", rate);
        rates.push_back(number(rate));
      }
      text_ += "\n";
    }
  }

  /// Returns millions a second.
  double locate_all(FrameSettings settings, double factor, int way) {
    set_step(settings, factor);
    const LatticeCost cost = locate_lattice(mesh_->sampler(), settings, way);
    return 1e-6 * double(cost.samples) / cost.seconds;
  }

  void save(std::string name, const Image& image) const {
    if (o_.out_folder.empty())
      return;
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == ' ' || c == ':' || c == ','; }, '_');
    output::write_png((std::filesystem::path(o_.out_folder) / (name + ".png")).string(), image);
  }

  const Options& o_;
  Setup setup_;
  core::Threads all_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
  double low_ = 0.0, high_ = 1.0;
  std::vector<Drawn> rows_;
  std::string text_;
  Json json_;
};

} // namespace

Output render(const Options& options) {
  return Bench(options).run();
}

} // namespace insitu::bench
