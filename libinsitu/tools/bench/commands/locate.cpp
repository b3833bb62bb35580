#include <algorithm>
#include <limits>

#include "commands.h"
#include "peers/peers.h"
#include "query/batch/candidates.h"
#include "query/batch/order.h"

namespace insitu::bench {

void sample(const core::Threads& threads, const commit::CommittedMesh& mesh,
            std::span<const math::Vec3d> points, Answers& answers,
            const query::LocateOptions& options) {
  const query::Sampler sampler = mesh.sampler();
  const mesh::FieldView field = mesh.mesh().field("f");
  double* const values = answers.values.data();
  sampler.visit(threads, points, options, [&](const query::Answered& answered) {
    for (std::size_t k = 0; k < answered.locations.size(); ++k)
      answers.cells[answered.item(k)] = answered.locations[k].cell;
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

} // namespace

Report locate(const Options& o) {
  using workload::Pattern;
  Setup setup(o);
  auto& context = setup.context;
  const core::Threads& threads = context.threads;
  Report r;
  r.title = "insitu-bench locate: " + describe(o, setup.mesh.cell_count(), threads.count());

  progress("making the queries");
  const std::int64_t count = o.points > 0 ? o.points : setup.mesh.cell_count();
  const workload::Queries queries = workload::make_queries(setup.mesh, o.pattern, count);
  const std::span<const math::Vec3d> points = queries.points;
  Answers answers(points.size());
  query::LocateOptions options, exact;
  options.accuracy = o.accuracy;
  exact.accuracy = INSITU_EXACT;

  progress("committing");
  auto committed = setup.register_mesh();
  setup.commit(*committed);
  build_ours(o, setup, *committed, r.ours);
  context.memory.reset_peak();
  committed = setup.register_mesh();
  setup.commit(*committed);
  r.ours.bytes = committed->tree().bytes();
  r.ours.bytes_peak = context.memory.peak();
  workload::Queries few = queries; // for peers
  if (!o.peers || (o.peer_points > 0 && o.peer_points < std::int64_t(few.points.size()))) {
    const auto n = std::size_t(o.peers ? o.peer_points : 0);
    few.points.resize(n);
    few.made_in.resize(std::min(few.made_in.size(), n));
  }
  std::vector<PeerRun> peers = build_peers(setup, std::int64_t(few.points.size()), o);

  const query::Sampler sampler = committed->sampler();
  const query::Sampler unsorted(sampler.mesh(), sampler.tree()); // takes batches as they are
  const bool sorts = o.pattern == Pattern::random || o.pattern == Pattern::sorted;
  const bool on_boundary = workload::is_boundary(o.pattern);
  workload::Queries random; // where it is not the batch itself
  if (o.pattern == Pattern::sorted || on_boundary)
    random = workload::make_queries(setup.mesh, Pattern::random, count);
  std::vector<query::Location> random_answers(on_boundary ? random.points.size() : 0);
  const std::span<const math::Vec3d> to_sort =
      o.pattern == Pattern::sorted ? std::span<const math::Vec3d>(random.points) : points;
  query::SpatialOrder order(context.memory);

  Answers theirs(few.points.size());
  Series locate_exact, locate_random, locate_unsorted, sort;
  for (int i = 0; i < o.repetitions; ++i) {
    progress("repetition " + std::to_string(i + 1) + " of " + std::to_string(o.repetitions));
    sampler.locate(threads, points, answers.locations, options); // peers have emptied the caches
    r.ours.locate.time([&] { sampler.locate(threads, points, answers.locations, options); });
    locate_exact.time([&] { sampler.locate(threads, points, answers.locations, exact); });
    if (on_boundary)
      locate_random.time([&] { sampler.locate(threads, random.points, random_answers, options); });
    if (sorts) {
      locate_unsorted.time([&] { unsorted.locate(threads, points, answers.locations, options); });
      sort.time([&] { order.sort(threads, to_sort, committed->tree()); });
    }
    r.ours.sample.time([&] { sample(threads, *committed, points, answers, options); });
    for (PeerRun& run : peers)
      run.figures.locate.time([&] { run.peer->locate(few.points, theirs.cells); });
  }

  progress("checking");
  std::vector<std::int64_t> owners;
  // Rounding may put points on the boundary elsewhere, and not every mesh fills its box: exact
  // arithmetic tells who holds them.
  const bool fills_box = o.mesh_file.empty() && o.spacing != workload::Spacing::sparse;
  if (on_boundary || (o.pattern == Pattern::march && !fills_box)) {
    std::vector<query::Location> truth(points.size());
    sampler.locate(threads, points, truth, exact);
    for (const query::Location& at : truth)
      owners.push_back(at.cell);
  }
  r.ours.verdict = check(setup.mesh, queries, owners, answers.cells, answers.values);
  for (PeerRun& run : peers) {
    progress("checking " + run.figures.name);
    run.figures.sample.time([&] { run.peer->sample(few.points, theirs.cells, theirs.values); });
    run.figures.verdict =
        check(setup.mesh, few, owners, theirs.cells, theirs.values, run.figures.tells_cells);
    r.peers.push_back(std::move(run.figures));
  }

  r.ours.name = "libinsitu";
  r.ours.cells = setup.mesh.cell_count();
  r.ours.queries = std::int64_t(points.size());
  r.ours.threads = threads.count();
  r.timings = {{"rebuild_morton", r.ours.build},
               {"refit", r.ours.refit},
               {"locate", r.ours.locate},
               {"locate_exact", locate_exact},
               {"sample", r.ours.sample}};
  const auto number = [&](const std::string& name, double value) {
    r.numbers.emplace_back(name, value);
  };
  const auto ratio = [&](const Series& a, const Series& b) {
    return a.for_ratio(threads.count()) / b.for_ratio(threads.count());
  };
  if (o.accuracy != INSITU_EXACT)
    number("exact_over_standard", ratio(locate_exact, r.ours.locate));
  if (sorts) {
    r.timings.emplace_back("locate_unsorted", locate_unsorted);
    r.timings.emplace_back("locate_sort", sort);
    number("sort_ns", 1e9 * sort.median() / double(points.size()));
    number("mqps_unsorted", r.ours.mqps(locate_unsorted));
  }
  if (on_boundary) {
    r.timings.emplace_back("locate_random", locate_random);
    number("boundary_over_random", ratio(r.ours.locate, locate_random));
  }
  if (o.fields > 1) {
    progress("sampling fields");
    const FieldTimes fields = time_fields(o, setup.mesh, setup.field, points);
    r.timings.emplace_back("sample_one_field", fields.one);
    r.timings.emplace_back("sample_all_fields", fields.all);
    number("fields_over_one", ratio(fields.all, fields.one));
  }
  const Latency latency = time_single_points(sampler, points);
  number("single_us", latency.single);
  number("single_exact_us", latency.single_exact);
  number("hinted_us", latency.hinted);
  const Work work = count_work(committed->tree(), points);
  number("nodes_per_query", work.nodes);
  number("candidates_per_query", work.candidates);
  number("sorted_inside", query::is_incoherent(points, committed->tree()));
  constexpr const char* reasons[] = {"outside", "certified", "exact",
                                     "on_face", "on_edge",   "on_vertex"};
  std::vector<std::uint8_t> reason(points.size());
  sampler.locate(threads, points, answers.locations, options, reason);
  for (std::uint8_t k = 0; k < query::reason_count; ++k)
    number(std::string("reason_") + reasons[k],
           double(std::count(reason.begin(), reason.end(), k)));
  for (const Figures& peer : r.peers) {
    r.timings.emplace_back("locate_" + peer.name, peer.locate);
    number("ratio_" + peer.name, r.ratio(peer, r.ours.locate));
    if (sorts)
      number("ratio_unsorted_" + peer.name, r.ratio(peer, locate_unsorted));
  }
  if (o.peers && peers.empty())
    r.notes.push_back("No peers: insitu-bench was built without VTK.");
  if (!peers.empty())
    r.notes.push_back("Peers run on one thread; their peak is resident memory.");
  return r;
}

} // namespace insitu::bench
