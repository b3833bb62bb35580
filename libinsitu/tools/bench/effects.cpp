#include <cmath>
#include <functional>

#include "commands.h"
#include "format.h"
#include "render/frame.h"

namespace insitu::bench {

namespace {

using render::FrameSettings;

/// Two hills and a wave over the unit box, from 0 to about 1.3.
double blob(const math::Vec3d& p) {
  const auto hill = [&](const math::Vec3d& centre, double width) {
    const math::Vec3d d = p - centre;
    return std::exp(-dot(d, d) / (width * width));
  };
  return hill({0.35, 0.4, 0.5}, 0.22) + 0.8 * hill({0.68, 0.6, 0.45}, 0.16) +
         0.05 * (1 + std::sin(25 * p.x) * std::sin(25 * p.y));
}

/// An effect of a frame: the bare frame, and with it.
struct Effect {
  std::string name;
  std::function<void(FrameSettings&)> ask;
};

struct Family {
  std::string name; ///< of the bare frame
  FrameSettings bare;
  std::vector<Effect> effects;
};

struct Row {
  std::string family, effect;
  Series bare, with;
  std::int64_t bytes_bare = 0, bytes_with = 0; ///< at most, while it is drawn
  render::FrameStatistics statistics;
};

class Bench {
public:
  explicit Bench(const Options& o) : o_(o), setup_(o) {
    for (std::size_t v = 0; v < setup_.field.size(); ++v)
      setup_.field[v] = blob(setup_.mesh.point(std::int64_t(v)));
    mesh_ = setup_.register_mesh();
    setup_.commit(*mesh_);
  }

  std::vector<Row> run() {
    std::vector<Row> rows;
    for (const Family& family : {volumes(), surfaces()}) {
      Family all = family;
      all.effects.push_back({"all together", [&](FrameSettings& s) {
                               for (const Effect& effect : family.effects)
                                 effect.ask(s);
                             }});
      for (const Effect& effect : all.effects) {
        progress(family.name + ": " + effect.name);
        rows.push_back(measure(family, effect));
      }
    }
    return rows;
  }

  std::string title() const {
    return "insitu-bench effects: " +
           describe(o_, setup_.mesh.cell_count(), setup_.context.threads.count()) + ", frames of " +
           std::to_string(side) + " x " + std::to_string(side);
  }

private:
  static constexpr int side = 512;

  render::ScalarField field() const { return {mesh_->mesh().field("f"), 0}; }
  FrameSettings frame() const {
    FrameSettings s;
    s.width = s.height = side;
    s.camera = render::Camera::around({0, 0, 0}, {1, 1, 1}, 30, 20);
    s.lighting.enabled = false;
    return s;
  }
  render::TransferFunction function() const {
    return {render::ColorMap::built_in("viridis"), 0.0, 1.2, {{0.35, 0.0}, {1.2, 0.2}}};
  }

  Family volumes() const {
    Family f{"volume", frame(), {}};
    f.bare.volume = render::VolumeSettings{field(), function()};
    f.effects.push_back({"half the step", [](FrameSettings& s) { s.volume->step_factor *= 0.5; }});
    f.effects.push_back({"isosurface inside", [this](FrameSettings& s) {
                           s.isosurfaces.push_back({field(), {0.8}, 0.5});
                         }});
    return f;
  }

  Family surfaces() const {
    Family f{"isosurface", frame(), {}};
    f.bare.isosurfaces.push_back({field(), {0.5}, 1});
    f.effects.push_back({"lighting", [](FrameSettings& s) { s.lighting.enabled = true; }});
    f.effects.push_back({"colours by field", [this](FrameSettings& s) {
                           for (render::IsosurfaceSettings& i : s.isosurfaces)
                             i.color = render::ColorByField{field(), function()};
                         }});
    f.effects.push_back({"transparent", [](FrameSettings& s) {
                           for (render::IsosurfaceSettings& i : s.isosurfaces)
                             i.opacity = 0.5;
                         }});
    f.effects.push_back(
        {"second isovalue", [](FrameSettings& s) { s.isosurfaces[0].values.push_back(0.7); }});
    return f;
  }

  /// With and without in turns, all structures made anew.
  Row measure(const Family& family, const Effect& effect) {
    Row row{family.name, effect.name, {}, {}, 0, 0, {}};
    FrameSettings with = family.bare;
    effect.ask(with);
    core::Memory& memory = setup_.context.memory;
    const auto draw = [&](const FrameSettings& settings, std::int64_t& bytes) {
      memory.reset_peak();
      const std::int64_t before = memory.current();
      render::render_frame(mesh_->sampler(), settings, setup_.context.threads, memory,
                           &row.statistics);
      bytes = memory.peak() - before;
    };
    for (int i = 0; i < o_.repetitions; ++i) {
      row.bare.time([&] { draw(family.bare, row.bytes_bare); });
      row.with.time([&] { draw(with, row.bytes_with); });
    }
    return row;
  }

  const Options& o_;
  Setup setup_;
  std::unique_ptr<query::CommittedMesh> mesh_;
};

} // namespace

Output effects(const Options& o) {
  Bench bench(o);
  const std::vector<Row> rows = bench.run();
  Output out;
  out.text = bench.title() +
             "\nMedians; an effect's price is what it adds to the bare frame, which is "
             "drawn in turns with it.\n\n";
  out.text += format("%-11s %-28s %9s %9s %8s %10s\n", "frame", "effect", "bare s", "with s",
                     "time", "memory");
  out.json = "[";
  for (const Row& row : rows) {
    const double bare = row.bare.for_ratio(o.threads), with = row.with.for_ratio(o.threads);
    const double megabytes = 1e-6 * double(row.bytes_with - row.bytes_bare);
    out.text += format("%-11s %-28s %9.3f %9.3f %+7.1f%% %+7.2f MB\n", row.family.c_str(),
                       row.effect.c_str(), bare, with, 100 * (with / bare - 1), megabytes);
    out.json += std::string(out.json.size() > 1 ? "," : "") +
                "\n  {\"frame\": " + quoted(row.family) + ", \"effect\": " + quoted(row.effect) +
                ", \"bare_s\": " + number(bare) + ", \"with_s\": " + number(with) +
                ", \"bytes_added\": " + std::to_string(row.bytes_with - row.bytes_bare) + "}";
  }
  out.json += "\n]\n";
  return out;
}

} // namespace insitu::bench
