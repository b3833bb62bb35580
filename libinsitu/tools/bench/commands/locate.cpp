#include <algorithm>
#include <limits>

#include "commands.h"
#include "peers/peers.h"
#include "query/batch/candidates.h"
#include "query/batch/order.h"
#include "query/on_demand.h"

namespace insitu::bench {

void sample(const core::Threads& threads, const commit::CommittedMesh& mesh,
            std::span<const math::Vec3d> points, Answers& answers,
            const query::LocateOptions& options) {
  const query::Sampler sampler = mesh.sampler();
  const mesh::FieldView field = mesh.mesh().field("f");
  double* const values = answers.values.data();
  sampler.visit(threads, points, options, [&](const query::Answered& answered) {
    for (std::size_t k = 0; k < answered.locations.size(); ++k)
      answers.cells[answered.item(k)] =
          mesh.own(answered.locations[k], points[answered.item(k)]).cell;
    sampler.interpolate(std::span(&field, 1), answered, 0, &values);
  });
}

Work count_work(const accel::Tree& tree, std::span<const math::Vec3d> points) {
  query::TraversalScratch scratch;
  query::QueryBoxes boxes;
  const query::BoxRule rule(tree.origin());
  std::uint64_t nodes = 0, candidates = 0;
  for (std::size_t first = 0; first < points.size(); first += query::batch_size) {
    const std::size_t n = std::min<std::size_t>(query::batch_size, points.size() - first);
    query::set_boxes(rule, points.subspan(first, n), boxes);
    query::find_candidates(tree, boxes, scratch);
    nodes += scratch.visited;
    candidates += scratch.found;
  }
  const double n = std::max<double>(1.0, double(points.size()));
  return {double(nodes) / n, double(candidates) / n};
}

namespace {

struct PeerRun {
  std::unique_ptr<Peer> peer;
  Figures figures;
};

std::vector<PeerRun> build_peers(const Setup& setup, std::int64_t queries, const Options& o) {
  std::vector<PeerRun> runs;
  if (!o.peers)
    return runs;
  for (auto& peer : make_peers(setup.mesh, setup.field, o.peer_names)) {
    PeerRun& run = runs.emplace_back();
    run.peer = std::move(peer);
    run.figures.name = run.peer->name();
    run.figures.cells = setup.mesh.cell_count();
    run.figures.queries = queries;
    run.figures.tells_cells = run.peer->tells_cells();
    progress("building " + run.figures.name);
    const std::int64_t heap = heap_bytes(), resident = start_resident_peak();
    run.figures.build.time([&] { run.peer->build(); });
    run.figures.bytes = heap_bytes() - heap;
    run.figures.bytes_peak = std::max(run.figures.bytes, resident_peak() - resident);
    for (int i = 1; i < std::min(o.repetitions, 3); ++i)
      run.figures.build.time([&] { run.peer->build(); });
  }
  return runs;
}

void build_ours(const Options& o, Setup& setup, commit::CommittedMesh& committed, Figures& ours) {
  for (int i = 0; i < std::min(o.repetitions, 3); ++i) {
    accel::Tree tree(setup.context.memory);
    const mesh::MeshView& view = committed.mesh().view();
    const auto build = [&] { tree.build(view, setup.context.threads, accel::Builder::morton); };
    build();
    ours.build.time(build);
    tree.refit(view, setup.context.threads);
    ours.refit.time([&] { tree.refit(view, setup.context.threads); });
  }
}

/// One run of `insitu-bench locate`.
class Locating {
public:
  explicit Locating(const Options& o);
  void time();
  void check();
  Report report();

private:
  using Pattern = workload::Pattern;
  std::span<const math::Vec3d> points() const { return queries_.points; }
  void time_once(const query::Sampler& sampler, const query::Sampler& unsorted);
  void report_times();
  void report_fields();
  void report_work();
  void report_peers();
  void number(const std::string& name, double value) { report_.numbers.emplace_back(name, value); }
  double ratio(const Series& a, const Series& b) const {
    return a.for_ratio(threads_.count()) / b.for_ratio(threads_.count());
  }

  const Options& o_;
  const bool sorts_, on_boundary_;
  Setup setup_;
  const core::Threads& threads_;
  workload::Queries queries_, few_;      ///< few: for peers
  workload::Queries random_;             ///< where it is not the batch itself
  Answers answers_, theirs_;             ///< theirs: a peer's
  std::vector<query::Location> randoms_; ///< answers to the random queries
  query::LocateOptions options_, exact_;
  query::SpatialOrder order_;
  std::unique_ptr<commit::CommittedMesh> committed_;
  std::vector<PeerRun> peers_;
  Series locate_exact_, find_alone_, locate_random_, locate_unsorted_, sort_;
  Report report_;
};

/// The first queries, as many as peers are to answer.
workload::Queries queries_for_peers(workload::Queries few, const Options& o) {
  if (!o.peers || (o.peer_points > 0 && o.peer_points < std::int64_t(few.points.size()))) {
    const auto n = std::size_t(o.peers ? o.peer_points : 0);
    few.points.resize(n);
    few.made_in.resize(std::min(few.made_in.size(), n));
  }
  return few;
}

workload::Queries make_queries(const Setup& setup, workload::Pattern pattern, const Options& o) {
  return workload::make_queries(setup.mesh, pattern,
                                o.points > 0 ? o.points : setup.mesh.cell_count());
}

Locating::Locating(const Options& o)
    : o_(o), sorts_(o.pattern == Pattern::random || o.pattern == Pattern::sorted),
      on_boundary_(workload::is_boundary(o.pattern)), setup_(o), threads_(setup_.context.threads),
      queries_((progress("making the queries"), make_queries(setup_, o.pattern, o))),
      few_(queries_for_peers(queries_, o)), answers_(points().size()), theirs_(few_.points.size()),
      order_(setup_.context.memory) {
  options_.accuracy = o.accuracy;
  exact_.accuracy = INSITU_EXACT;
  if (o.pattern == Pattern::sorted || on_boundary_)
    random_ = make_queries(setup_, Pattern::random, o);
  randoms_.resize(on_boundary_ ? random_.points.size() : 0);
  Figures& ours = report_.ours;
  report_.title = "insitu-bench locate: " + describe(o, setup_.mesh.cell_count(), threads_.count());
  ours.name = "libinsitu";
  ours.cells = setup_.mesh.cell_count();
  ours.queries = std::int64_t(points().size());
  ours.threads = threads_.count();

  progress("committing");
  committed_ = setup_.register_mesh();
  setup_.commit(*committed_);
  build_ours(o, setup_, *committed_, ours);
  setup_.context.memory.reset_peak();
  committed_ = setup_.register_mesh();
  setup_.commit(*committed_);
  ours.bytes = committed_->tree().bytes();
  ours.bytes_peak = setup_.context.memory.peak();
  peers_ = build_peers(setup_, std::int64_t(few_.points.size()), o);
}

void Locating::time() {
  const query::Sampler sampler = committed_->sampler();
  const query::Sampler unsorted(sampler.mesh(), sampler.tree()); // takes batches as they are
  // What `exact` finds out once it is asked for much, so that all repetitions are alike.
  find_alone_.time([&] { sampler.on_demand()->lone->find(sampler.mesh(), threads_); });
  for (int i = 0; i < o_.repetitions; ++i) {
    progress("repetition " + std::to_string(i + 1) + " of " + std::to_string(o_.repetitions));
    time_once(sampler, unsorted);
  }
}

void Locating::time_once(const query::Sampler& sampler, const query::Sampler& unsorted) {
  std::vector<query::Location>& found = answers_.locations;
  sampler.locate(threads_, points(), found, options_); // peers have emptied the caches
  report_.ours.locate.time([&] { sampler.locate(threads_, points(), found, options_); });
  locate_exact_.time([&] { sampler.locate(threads_, points(), found, exact_); });
  if (on_boundary_)
    locate_random_.time([&] { sampler.locate(threads_, random_.points, randoms_, options_); });
  if (sorts_) {
    locate_unsorted_.time([&] { unsorted.locate(threads_, points(), found, options_); });
    const std::span<const math::Vec3d> to_sort =
        o_.pattern == Pattern::sorted ? std::span<const math::Vec3d>(random_.points) : points();
    sort_.time([&] { order_.sort(threads_, to_sort, committed_->tree()); });
  }
  report_.ours.sample.time([&] { sample(threads_, *committed_, points(), answers_, options_); });
  for (PeerRun& run : peers_)
    run.figures.locate.time([&] { run.peer->locate(few_.points, theirs_.cells); });
}

void Locating::check() {
  progress("checking");
  std::vector<std::int64_t> owners;
  // Rounding may put points on the boundary elsewhere, and not every mesh fills its box: exact
  // arithmetic tells who holds them.
  const bool fills_box = o_.mesh_file.empty() && o_.spacing != workload::Spacing::sparse;
  if (on_boundary_ || (o_.pattern == Pattern::march && !fills_box) || setup_.mesh.has_faces()) {
    std::vector<query::Location> truth(points().size());
    committed_->sampler().locate(threads_, points(), truth, exact_);
    for (std::size_t i = 0; i < truth.size(); ++i)
      owners.push_back(committed_->own(truth[i], points()[i]).cell);
  }
  report_.ours.verdict =
      bench::check(setup_.mesh, queries_, owners, answers_.cells, answers_.values);
  for (PeerRun& run : peers_) {
    progress("checking " + run.figures.name);
    run.figures.sample.time([&] { run.peer->sample(few_.points, theirs_.cells, theirs_.values); });
    run.figures.verdict = bench::check(setup_.mesh, few_, owners, theirs_.cells, theirs_.values,
                                       run.figures.tells_cells);
    report_.peers.push_back(std::move(run.figures));
  }
}

Report Locating::report() {
  report_times();
  report_fields();
  report_work();
  report_peers();
  return std::move(report_);
}

void Locating::report_times() {
  Figures& ours = report_.ours;
  report_.timings = {{"rebuild_morton", ours.build},  {"refit", ours.refit},
                     {"locate", ours.locate},         {"find_alone", find_alone_},
                     {"locate_exact", locate_exact_}, {"sample", ours.sample}};
  if (o_.accuracy != INSITU_EXACT)
    number("exact_over_standard", ratio(locate_exact_, ours.locate));
  if (sorts_) {
    report_.timings.emplace_back("locate_unsorted", locate_unsorted_);
    report_.timings.emplace_back("locate_sort", sort_);
    number("sort_ns", 1e9 * sort_.median() / double(points().size()));
    number("mqps_unsorted", ours.mqps(locate_unsorted_));
  }
  if (on_boundary_) {
    report_.timings.emplace_back("locate_random", locate_random_);
    number("boundary_over_random", ratio(ours.locate, locate_random_));
  }
}

void Locating::report_fields() {
  if (o_.fields <= 1)
    return;
  progress("sampling fields");
  const FieldTimes fields = time_fields(o_, setup_.mesh, setup_.field, points());
  report_.timings.emplace_back("sample_one_field", fields.one);
  report_.timings.emplace_back("sample_all_fields", fields.all);
  number("fields_over_one", ratio(fields.all, fields.one));
}

void Locating::report_work() {
  const query::Sampler sampler = committed_->sampler();
  const Latency latency = time_single_points(sampler, points());
  number("single_us", latency.single);
  number("single_exact_us", latency.single_exact);
  number("hinted_us", latency.hinted);
  const Work work = count_work(committed_->tree(), points());
  number("nodes_per_query", work.nodes);
  number("candidates_per_query", work.candidates);
  number("sorted_inside", query::is_incoherent(points(), committed_->tree()));
  constexpr const char* reasons[] = {"outside", "certified", "exact",
                                     "on_face", "on_edge",   "on_vertex"};
  std::vector<std::uint8_t> reason(points().size());
  sampler.locate(threads_, points(), answers_.locations, options_, reason);
  for (std::uint8_t k = 0; k < query::reason_count; ++k)
    number(std::string("reason_") + reasons[k],
           double(std::count(reason.begin(), reason.end(), k)));
}

void Locating::report_peers() {
  for (const Figures& peer : report_.peers) {
    report_.timings.emplace_back("locate_" + peer.name, peer.locate);
    number("ratio_" + peer.name, report_.ratio(peer, report_.ours.locate));
    if (sorts_)
      number("ratio_unsorted_" + peer.name, report_.ratio(peer, locate_unsorted_));
  }
  if (o_.peers && peers_.empty())
    report_.notes.push_back("No peers: insitu-bench was built without VTK.");
  if (!peers_.empty())
    report_.notes.push_back("Peers run on one thread; their peak is resident memory.");
}

} // namespace

Report locate(const Options& o) {
  Locating run(o);
  run.time();
  run.check();
  return run.report();
}

} // namespace insitu::bench
