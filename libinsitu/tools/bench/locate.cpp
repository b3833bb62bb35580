#include <algorithm>
#include <limits>

#include "commands.h"
#include "query/candidates.h"
#include "vtk_parts.h"

namespace insitu::bench {

void sample(const core::Threads& threads, const query::CommittedMesh& mesh,
            std::span<const math::Vec3d> points, Answers& answers,
            const query::LocateOptions& options) {
  const query::Sampler sampler = mesh.sampler();
  const mesh::FieldView field = mesh.mesh().field("f");
  sampler.locate(threads, points, answers.locations, options);
  threads.parallel_for(std::int64_t(points.size()), 4096,
                       [&](std::int64_t begin, std::int64_t end) {
                         for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
                           answers.cells[i] = answers.locations[i].cell;
                           if (answers.locations[i])
                             sampler.interpolate(field, answers.locations[i], &answers.values[i]);
                           else
                             answers.values[i] = std::numeric_limits<double>::quiet_NaN();
                         }
                       });
}

namespace {

struct Work {
  double nodes = 0.0, candidates = 0.0; ///< a query, on average
};

/// What the queries make the tree do, apart from the timed runs.
Work count_work(const accel::Tree& tree, std::span<const math::Vec3d> points) {
  query::TraversalScratch scratch;
  query::QueryBoxes boxes;
  std::uint64_t nodes = 0, candidates = 0;
  for (std::size_t first = 0; first < points.size(); first += query::batch_size) {
    boxes.count = int(std::min<std::size_t>(query::batch_size, points.size() - first));
    for (int q = 0; q < boxes.count; ++q) {
      float lower[3], upper[3];
      for (int a = 0; a < 3; ++a) {
        const double d = points[first + std::size_t(q)][a] - tree.origin()[a];
        lower[a] = accel::round_down(d);
        upper[a] = accel::round_up(d);
      }
      boxes.set(q, lower, upper);
    }
    query::find_candidates(tree, boxes, scratch);
    nodes += scratch.visited;
    candidates += scratch.found;
  }
  const double n = std::max<double>(1.0, double(points.size()));
  return {double(nodes) / n, double(candidates) / n};
}

struct PeerRun {
  std::unique_ptr<Peer> peer;
  Figures figures;
};

std::vector<PeerRun> build_peers(const Setup& setup, std::int64_t queries, int repetitions) {
  std::vector<PeerRun> runs;
  for (auto& peer : make_peers(setup.mesh, setup.field)) {
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
    for (int i = 1; i < std::min(repetitions, 3); ++i)
      run.figures.build.time([&] { run.peer->build(); });
  }
  return runs;
}

} // namespace

Report locate(const Options& o) {
  Setup setup(o);
  auto& context = setup.context;
  Report r;
  const int threads = context.threads.count();
  r.title = "insitu-bench locate: " + describe(o, setup.mesh.cell_count(), threads);

  progress("making the queries");
  const workload::Queries queries = workload::make_queries(
      setup.mesh, o.pattern, o.points > 0 ? o.points : setup.mesh.cell_count());
  Answers answers(queries.points.size());
  query::LocateOptions options;
  options.accuracy = o.accuracy;

  progress("committing");
  auto committed = setup.register_mesh();
  setup.commit(*committed);
  for (int i = 0; i < std::min(o.repetitions, 3); ++i) {
    accel::Tree tree(context.memory);
    const mesh::MeshView& view = committed->mesh().view();
    tree.build(view, context.threads, accel::Builder::morton);
    r.ours.build.time([&] { tree.build(view, context.threads, accel::Builder::morton); });
    tree.refit(view, context.threads);
    r.ours.refit.time([&] { tree.refit(view, context.threads); });
  }
  context.memory.reset_peak();
  committed = setup.register_mesh();
  setup.commit(*committed);
  r.ours.bytes = committed->tree().bytes();
  r.ours.bytes_peak = context.memory.peak();

  std::vector<PeerRun> peers;
  if (o.peers)
    peers = build_peers(setup, std::int64_t(queries.points.size()), o.repetitions);

  const query::Sampler sampler = committed->sampler();
  sampler.locate(context.threads, queries.points, answers.locations, options); // touches pages
  Answers theirs(peers.empty() ? 0 : queries.points.size());
  for (int i = 0; i < o.repetitions; ++i) {
    progress("repetition " + std::to_string(i + 1) + " of " + std::to_string(o.repetitions));
    r.ours.locate.time(
        [&] { sampler.locate(context.threads, queries.points, answers.locations, options); });
    r.ours.sample.time(
        [&] { sample(context.threads, *committed, queries.points, answers, options); });
    for (PeerRun& run : peers) {
      run.figures.locate.time([&] { run.peer->locate(queries.points, theirs.cells); });
      run.figures.sample.time(
          [&] { run.peer->sample(queries.points, theirs.cells, theirs.values); });
    }
  }

  progress("checking");
  std::vector<std::uint8_t> outside;
  if (!o.mesh_file.empty() && o.pattern == workload::Pattern::march) {
    // The mesh need not fill its box; exact arithmetic says which points no cell holds.
    query::LocateOptions exact;
    exact.accuracy = INSITU_EXACT;
    std::vector<query::Location> truth(queries.points.size());
    sampler.locate(context.threads, queries.points, truth, exact);
    for (const query::Location& at : truth)
      outside.push_back(!at);
  }
  r.ours.verdict = check(setup.mesh, queries, answers.cells, answers.values, outside);
  for (PeerRun& run : peers) {
    run.peer->sample(queries.points, theirs.cells, theirs.values);
    run.figures.verdict =
        check(setup.mesh, queries, theirs.cells, theirs.values, outside, run.figures.tells_cells);
    r.peers.push_back(std::move(run.figures));
  }

  r.ours.name = "libinsitu";
  r.ours.cells = setup.mesh.cell_count();
  r.ours.queries = std::int64_t(queries.points.size());
  r.ours.threads = threads;
  r.timings = {{"rebuild_morton", r.ours.build},
               {"refit", r.ours.refit},
               {"locate", r.ours.locate},
               {"sample", r.ours.sample}};
  for (const Figures& peer : r.peers)
    r.timings.push_back({"locate_" + peer.name, peer.locate});
  const Work work = count_work(committed->tree(), queries.points);
  r.numbers = {{"nodes_per_query", work.nodes}, {"candidates_per_query", work.candidates}};
  if (o.peers && peers.empty())
    r.notes.push_back("No peers: insitu-bench was built without VTK.");
  if (!peers.empty())
    r.notes.push_back("Peers run on one thread; their peak is resident memory.");
  return r;
}

} // namespace insitu::bench
