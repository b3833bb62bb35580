#include <algorithm>
#include <cmath>
#include <functional>

#include "commands.h"
#include "commands/effect_families.h"
#include "commands/effect_prices.h"
#include "report/format.h"
#include "report/json.h"
#include "commands/particle_effects.h"
#include "render/frame.h"
#include "render/structures/structures.h"
#include "commands/uniform_branches.h"

namespace insitu::bench {

namespace {

using render::FrameSettings;
using Family = EffectFamily;
using Effect = FrameEffect;

constexpr const char* together = "all together";

/// Two hills and a wave over the unit box, from 0 to about 1.3.
double blob(const math::Vec3d& p) {
  const auto hill = [&](const math::Vec3d& centre, double width) {
    const math::Vec3d d = p - centre;
    return std::exp(-dot(d, d) / (width * width));
  };
  return hill({0.35, 0.4, 0.5}, 0.22) + 0.8 * hill({0.68, 0.6, 0.45}, 0.16) +
         0.05 * (1 + std::sin(25 * p.x) * std::sin(25 * p.y));
}

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
    // The same at the middles of cells.
    const mesh::MeshView& view = mesh_->mesh().view();
    for (std::int64_t c = 0; c < setup_.mesh.cell_count(); ++c) {
      mesh::CellVertices cell;
      mesh::gather(view, c, cell);
      math::Vec3d middle;
      for (int v = 0; v < cell.count; ++v)
        middle += (1.0 / cell.count) * cell.x[v];
      of_cells_.push_back(blob(middle));
    }
    const insitu_array values =
        insitu_array_of(of_cells_.data(), INSITU_FLOAT64, std::int64_t(of_cells_.size()), 1);
    mesh_->mesh().set_field(0, "c", INSITU_CELL, &values, 1);
    setup_.commit(*mesh_);
  }

  std::vector<Row> run() {
    std::vector<Row> rows;
    const mesh::Mesh& fields = mesh_->mesh();
    const auto families = [&] {
      return effect_families(o_.size, {fields.field("f"), 0}, {fields.field("c"), 0},
                             setup_.context.memory);
    };
    // What an effect keeps from frame to frame is made anew for all together.
    const std::vector<Family> alone = families(), for_all = families();
    for (std::size_t f = 0; f < alone.size(); ++f) {
      const Family& family = for_all[f];
      Family all = alone[f];
      all.effects.push_back({together,
                             [&](FrameSettings& s) {
                               for (const Effect& effect : family.effects)
                                 if (effect.goes_with_all)
                                   effect.ask(s);
                             },
                             true,
                             [&](core::Image& image, const FrameSettings& s) {
                               for (const Effect& effect : family.effects)
                                 if (effect.goes_with_all && effect.draw_over)
                                   effect.draw_over(image, s);
                             }});
      if (family.effects.size() == 1)
        all.effects.pop_back();
      for (const Effect& effect : all.effects) {
        progress(family.name + ": " + effect.name);
        rows.push_back(measure(family, effect));
      }
      if (family.name == cell_volume)
        continue; // its loop is the volume's
      // The counts of one thread are those of several; its time is not.
      BareFrame bare{family.name, {}, 0, uniform_branches::measure_branch()};
      Series time;
      const core::Threads single(1);
      for (int i = 0; i < o_.repetitions; ++i) {
        time.time([&] {
          render::render_frame(mesh_->sampler(), family.bare, single, setup_.context.memory,
                               &bare.statistics);
        });
        bare.branch_seconds = std::min(bare.branch_seconds, uniform_branches::measure_branch());
      }
      bare.seconds = time.cpu_median();
      bare_.push_back(std::move(bare));
    }
    return rows;
  }

  /// One of each family, after run().
  const std::vector<BareFrame>& bare() const { return bare_; }

  std::vector<ParticleRow> particles() {
    progress("particles");
    return particle_effects(o_, setup_, *mesh_);
  }

  std::string title() const {
    return "insitu-bench effects: " +
           describe(o_, setup_.mesh.cell_count(), setup_.context.threads.count()) + ", frames of " +
           std::to_string(o_.size) + " x " + std::to_string(o_.size);
  }

private:
  /// With and without in turns, all structures made anew.
  Row measure(const Family& family, const Effect& effect) {
    Row row{family.name, effect.name, {}, {}, 0, 0, {}};
    FrameSettings with = family.bare;
    effect.ask(with);
    core::Memory& memory = setup_.context.memory;
    const auto draw = [&](FrameSettings settings, bool has_effect, std::int64_t& bytes) {
      memory.reset_peak();
      const std::int64_t before = memory.current();
      render::Structures structures(memory);
      structures.begin(mesh_->sampler(), 0, 0, setup_.context.threads);
      if (has_effect && family.name == cell_volume) // as a scene's `smooth` does
        settings.volume->field = structures.average(settings.volume->field).field();
      render::FrameImages images = render::render_frame(mesh_->sampler(), settings, structures,
                                                        setup_.context.threads, &row.statistics);
      if (has_effect && effect.draw_over)
        effect.draw_over(images.color, settings);
      // What accumulates is made in the first of them.
      bytes = std::max(bytes, memory.peak() - before);
    };
    for (int i = 0; i < o_.repetitions; ++i) {
      row.bare.time([&] { draw(family.bare, false, row.bytes_bare); });
      row.with.time([&] { draw(with, true, row.bytes_with); });
    }
    return row;
  }

  const Options& o_;
  Setup setup_;
  std::unique_ptr<commit::CommittedMesh> mesh_;
  std::vector<BareFrame> bare_;
  std::vector<double> of_cells_;
};

/// The dearest effects, one of every kind of frame and one on particles.
std::string dearest(const std::vector<Row>& rows, const std::vector<ParticleRow>& particles,
                    int threads) {
  std::vector<std::pair<std::string, std::string>> kinds; // with the dearest, as it is printed
  double most = 0.0;
  const auto look = [&](const std::string& kind, const std::string& effect, const auto& row) {
    if (kinds.empty() || kinds.back().first != kind) {
      kinds.emplace_back(kind, "");
      most = -HUGE_VAL;
    }
    const double price = row.with.for_ratio(threads) / row.bare.for_ratio(threads) - 1;
    if (price > most) {
      most = price;
      kinds.back().second = effect + format(" (%+.0f %%)", 100 * price);
    }
  };
  for (const Row& row : rows)
    if (row.effect != together)
      look(row.family, row.effect, row);
  for (const ParticleRow& row : particles)
    look("particles", row.effect, row);
  std::string out;
  for (const auto& [kind, effect] : kinds)
    out += (out.empty() ? "The dearest effects are, of " : "; of ") + kind + ", " + effect;
  return out + ".";
}

} // namespace

Output effects(const Options& o) {
  Bench bench(o);
  const std::vector<Row> rows = bench.run();
  const std::vector<ParticleRow> particles = bench.particles();
  Output out;
  out.advice = dearest(rows, particles, o.threads);
  out.text = bench.title() +
             "\nMedians; an effect's price is what it adds to the bare frame, which is "
             "drawn in turns with it.\n\n";
  out.text += format("%-12s %-28s %9s %9s %8s %10s\n", "frame", "effect", "bare s", "with s",
                     "time", "memory");
  Json json = Json::array();
  const auto price = [&](const std::string& of, const auto& row) {
    return Json{{"frame", of},
                {"effect", row.effect},
                {"bare_s", number(row.bare.for_ratio(o.threads))},
                {"with_s", number(row.with.for_ratio(o.threads))},
                {"bytes_added", row.bytes_with - row.bytes_bare}};
  };
  for (const Row& row : rows) {
    const double bare = row.bare.for_ratio(o.threads), with = row.with.for_ratio(o.threads);
    const double megabytes = 1e-6 * double(row.bytes_with - row.bytes_bare);
    out.text += format("%-12s %-28s %9.3f %9.3f %+7.1f%% %+7.2f MB\n", row.family.c_str(),
                       row.effect.c_str(), bare, with, 100 * (with / bare - 1), megabytes);
    json.push_back(price(row.family, row));
  }
  out.text += uniform_branches::text(bench.bare());
  uniform_branches::add(bench.bare(), json);
  out.text +=
      "\nParticles, ten advances; evaluations of the velocity without and with the effect.\n\n";
  out.text += format("%-32s %9s %9s %8s %12s %12s %11s %9s\n", "effect", "bare s", "with s", "time",
                     "evaluations", "with", "walk steps", "contacts");
  for (const ParticleRow& row : particles) {
    const double bare = row.bare.for_ratio(o.threads), with = row.with.for_ratio(o.threads);
    out.text += format("%-32s %9.3f %9.3f %+7.1f%% %12s %12s %11s %9s\n", row.effect.c_str(), bare,
                       with, 100 * (with / bare - 1), grouped(row.evaluations_bare).c_str(),
                       grouped(row.evaluations).c_str(), grouped(row.walk_steps).c_str(),
                       grouped(row.contacts).c_str());
    Json one = price("particles", row);
    one.update({{"evaluations_bare", row.evaluations_bare},
                {"evaluations", row.evaluations},
                {"walk_steps", row.walk_steps},
                {"contacts", row.contacts}});
    json.push_back(one);
  }
  out.json = json_text(json);
  std::vector<EffectPrice> prices;
  for (const Row& row : rows)
    prices.push_back({row.family, row.effect, row.bare, row.with, row.bytes_with - row.bytes_bare});
  for (const ParticleRow& row : particles)
    prices.push_back({"particles", row.effect, row.bare, row.with, row.bytes_with - row.bytes_bare,
                      row.evaluations_bare, row.evaluations});
  out.csv = csv(prices, o.threads);
  out.svg = plot(prices, o.threads);
  return out;
}

} // namespace insitu::bench
