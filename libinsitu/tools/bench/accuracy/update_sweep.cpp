#include <algorithm>
#include <cmath>

#include "accuracy/sweeps.h"
#include "commands.h"
#include "commit/tree_policy.h"
#include "core/random.h"
#include "core/timer.h"
#include "report/format.h"
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
  Series commits;          ///< the same of a session that keeps the mesh by its policy
  double nodes = 0.0;      ///< and candidates, a query, over all cycles
  std::int64_t rebuilds = 0;
};

/// A tree kept in one way; the policy is asked and told what a commit asks and tells it.
class KeptTree {
public:
  KeptTree(Way way, core::Memory& memory, const core::Threads& threads)
      : way_(way), threads_(threads), tree_(memory) {}

  const accel::Tree& tree() const { return tree_; }

  void build(const mesh::MeshView& mesh) {
    policy_.topology_changed();
    rebuild(mesh);
  }
  /// After the vertices moved. Returns whether it was built anew.
  bool update(const mesh::MeshView& mesh) {
    if (way_ == Way::policy || way_ == Way::refit) {
      tree_.refit(mesh, threads_);
      if (way_ == Way::refit ||
          !(policy_.rebuild_is_due(tree_.cost_ratio()) || policy_.surface_area_is_due()))
        return false;
    }
    rebuild(mesh);
    return true;
  }
  void served(std::size_t points) { policy_.served(std::int64_t(points), 0, tree_.cost_ratio()); }

private:
  void rebuild(const mesh::MeshView& mesh) {
    const accel::Builder builder = way_ == Way::policy            ? policy_.builder()
                                   : way_ == Way::rebuild_by_area ? accel::Builder::surface_area
                                                                  : accel::Builder::morton;
    const core::Timer timer;
    tree_.build(mesh, threads_, builder);
    policy_.built(builder, timer.seconds(), tree_.cell_count(), tree_.cost());
  }

  Way way_;
  const core::Threads& threads_;
  accel::Tree tree_;
  commit::TreePolicy policy_;
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
    commit::CommittedMesh mesh("blast", context_.memory);
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
    KeptTree kept(way, context_.memory, context_.threads);
    kept.build(mesh.mesh().view());

    std::vector<query::Location> found(points_.size());
    Series update, ask, commit;
    double nodes = 0.0;
    out.rebuilds = 0;
    for (int c = 0; c < cycles(); ++c) {
      solver.advance();
      mesh.mesh().set_changed(INSITU_CHANGED_GEOMETRY);
      commit.time([&] {
        mesh.commit(context_.threads, context_.log, context_.memory, true);
        mesh.look_for_folds(context_.threads); // unless the commit did
      });
      bool rebuilt = false;
      update.time([&] { rebuilt = kept.update(mesh.mesh().view()); });
      out.rebuilds += rebuilt;
      const query::Sampler whole = mesh.sampler();
      query::SpatialOrder order(context_.memory);
      const query::Sampler sampler(whole.mesh(), kept.tree(), &order);
      ask.time([&] { sampler.locate(context_.threads, points_, found); });
      kept.served(points_.size());
      if (way == Way::policy) // the session's policy is told as well
        whole.locate(context_.threads, points_, found);
      const Work work = count_work(kept.tree(), points_);
      nodes += work.nodes + work.candidates;
    }
    out.nodes = nodes / cycles();
    out.updates.add(update.cpu_sum());
    out.queries.add(ask.cpu_sum());
    out.commits.add(commit.cpu_sum());
  }

private:
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
  s.more_labels = {"seconds of updates", "seconds of queries", "rebuilds",
                   "seconds of a session's whole commits"};
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
    one.more = {r.updates.median(), r.queries.median(), double(r.rebuilds),
                way == Way::policy ? r.commits.median() : NAN};
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
  s.notes = {
      format("Compared are the tree's updates alone and the queries, in all four ways on the "
             "same views of the mesh. A session's commits, by the same policy, hold the new "
             "views and a look for folded cells as well: %.3g s against %.3g s of the tree's "
             "updates.",
             runs[int(Way::policy)].commits.median(), runs[int(Way::policy)].updates.median())};
  return s;
}

} // namespace insitu::bench::accuracy
