#include <algorithm>
#include <cmath>

#include "accuracy/sweeps.h"
#include "commands.h"
#include "core/random.h"
#include "format.h"
#include "sedov/solver.h"
#include "setup.h"

namespace insitu::bench::accuracy {

namespace {

using math::Vec3d;

enum class Way { rebuild, rebuild_by_area, refit, policy };

const char* name(Way way) {
  switch (way) {
  case Way::rebuild:
    return "never refit, Morton order";
  case Way::rebuild_by_area:
    return "never refit, surface area";
  case Way::refit:
    return "always refit";
  case Way::policy:
    break;
  }
  return "policy";
}

struct Run {
  Series updates, queries; ///< of all cycles together, a repetition each
  double nodes = 0.0;      ///< and candidates, a query, over all cycles
  std::int64_t rebuilds = 0;
};

/// The blast's mesh, cycle by cycle, with the tree kept in one way and points asked for in every
/// cycle.
class Blast {
public:
  explicit Blast(const Extent& extent) : extent_(extent), context_(1, core::Log()) {
    config_.cells.fill(extent.quick ? 12 : 45);
    const std::int64_t count = extent.quick ? 2000 : 50'000;
    for (std::int64_t i = 0; i < count; ++i)
      points_.push_back({1.19 * core::random_unit(11, std::uint64_t(i), 0),
                         1.19 * core::random_unit(11, std::uint64_t(i), 1),
                         1.19 * core::random_unit(11, std::uint64_t(i), 2)});
  }

  int cycles() const { return extent_.quick ? 60 : 200; }
  std::int64_t cell_count() const {
    return std::int64_t(config_.cells[0]) * config_.cells[1] * config_.cells[2];
  }
  std::size_t point_count() const { return points_.size(); }

  void run(Way way, Run& out) {
    sedov::Solver solver(config_);
    query::CommittedMesh mesh("blast", context_.memory);
    const auto n = std::int64_t(solver.vertex_count());
    const insitu_array points[3] = {insitu_array_of(solver.x.data(), INSITU_FLOAT64, n, 1),
                                    insitu_array_of(solver.y.data(), INSITU_FLOAT64, n, 1),
                                    insitu_array_of(solver.z.data(), INSITU_FLOAT64, n, 1)};
    mesh.mesh().set_points(0, points, 3);
    insitu_cells cells = insitu_cells_default();
    cells.shape = INSITU_HEXAHEDRON;
    cells.count = std::int64_t(solver.cell_count());
    cells.connectivity = insitu_array_of(solver.connectivity.data(), INSITU_INT32, cells.count, 8);
    mesh.mesh().set_cells(0, &cells);
    mesh.commit(context_.threads, context_.log, context_.memory, true);
    accel::Tree own(context_.memory);
    if (way != Way::policy)
      own.build(mesh.mesh().view(), context_.threads, builder(way));

    std::vector<query::Location> found(points_.size());
    double updates = 0.0, queries = 0.0, nodes = 0.0;
    out.rebuilds = 0;
    for (int c = 0; c < cycles(); ++c) {
      solver.advance();
      Series update, ask;
      if (way == Way::policy) {
        mesh.mesh().set_changed(INSITU_CHANGED_GEOMETRY);
        insitu_commit_report report;
        update.time(
            [&] { report = mesh.commit(context_.threads, context_.log, context_.memory, true); });
        out.rebuilds += report.action == INSITU_REBUILD;
      } else {
        mesh.mesh().set_changed(INSITU_CHANGED_GEOMETRY);
        mesh.commit(context_.threads, context_.log, context_.memory, true); // for the views
        update.time([&] {
          if (way == Way::refit)
            own.refit(mesh.mesh().view(), context_.threads);
          else
            own.build(mesh.mesh().view(), context_.threads, builder(way));
        });
        out.rebuilds += way != Way::refit;
      }
      const query::Sampler whole = mesh.sampler();
      const accel::Tree& tree = way == Way::policy ? mesh.tree() : own;
      query::SpatialOrder order(context_.memory);
      const query::Sampler sampler(whole.mesh(), tree, &order);
      ask.time([&] {
        if (way == Way::policy)
          whole.locate(context_.threads, points_, found);
        else
          sampler.locate(context_.threads, points_, found);
      });
      const Work work = count_work(tree, points_);
      nodes += work.nodes + work.candidates;
      updates += update.cpu_median();
      queries += ask.cpu_median();
    }
    out.nodes = nodes / cycles();
    out.updates.add(updates);
    out.queries.add(queries);
  }

private:
  static accel::Builder builder(Way way) {
    return way == Way::rebuild_by_area ? accel::Builder::surface_area : accel::Builder::morton;
  }

  Extent extent_;
  core::Context context_;
  sedov::Config config_;
  std::vector<Vec3d> points_;
};

} // namespace

Sweep sweep_update(const Extent& extent) {
  Sweep s;
  s.key = "update";
  s.title = "A mesh that moves";
  Blast blast(extent);
  s.swept =
      format("The tree of the Sedov blast's mesh over %d cycles: built anew at every cycle, "
             "refitted at every "
             "cycle, or as the policy finds; %s cells, %s random points located at every cycle.",
             blast.cycles(), grouped(blast.cell_count()).c_str(),
             grouped(std::int64_t(blast.point_count())).c_str());
  s.reference = "The least work a query of the four ways.";
  s.error_label = "work of a query above the least, of the least";
  s.work_label = "tree nodes and candidate cells a query, mean over the cycles";
  s.time_label = "seconds, updates and queries of all cycles, one core";
  s.more_labels = {"seconds of updates", "seconds of queries", "rebuilds"};
  const Way ways[] = {Way::rebuild, Way::rebuild_by_area, Way::refit, Way::policy};
  Run runs[4];
  for (int i = 0; i < extent.repetitions; ++i)
    for (const Way way : ways) {
      progress(std::string("update: ") + name(way));
      blast.run(way, runs[int(way)]);
    }
  double least = HUGE_VAL;
  for (const Run& r : runs)
    least = std::min(least, r.nodes);
  for (const Way way : ways) {
    const Run& r = runs[int(way)];
    Setting one;
    one.group = "Sedov blast";
    one.name = name(way);
    one.error = r.nodes / least - 1.0;
    one.work = r.nodes;
    one.time = r.updates.plus(r.queries);
    one.is_default = way == Way::policy;
    one.more = {r.updates.median(), r.queries.median(), double(r.rebuilds)};
    s.settings.push_back(std::move(one));
  }
  const auto total = [&](Way way) { return s.find("Sedov blast", name(way))->seconds(); };
  s.advice =
      format("The policy's run takes %.2f times the time of refitting always and %.2f times that "
             "of building anew at every "
             "cycle; it built anew %lld times, and its queries do %.1f %% more work than with the "
             "best tree.",
             total(Way::policy) / total(Way::refit), total(Way::policy) / total(Way::rebuild),
             static_cast<long long>(runs[int(Way::policy)].rebuilds),
             100 * s.find("Sedov blast", "policy")->error);
  s.notes = {"The policy's updates are whole commits, with validation of moved vertices; the "
             "others' are the tree's "
             "work alone."};
  return s;
}

} // namespace insitu::bench::accuracy
