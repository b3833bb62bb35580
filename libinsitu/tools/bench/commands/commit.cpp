#include "accel/tree/tree.h"
#include "commands.h"

namespace insitu::bench {

Report commit(const Options& o) {
  Setup setup(o);
  Report r;
  const int threads = setup.context.threads.count();
  r.title = "insitu-bench commit: " + describe(o, setup.mesh.cell_count(), threads);
  Series first, first_again, validate, morton_cold, medium_cold, morton, medium, refit_morton,
      refit_medium;
  auto& context = setup.context;
  std::unique_ptr<commit::CommittedMesh> committed;
  for (int i = 0; i < o.repetitions; ++i) {
    progress("repetition " + std::to_string(i + 1) + " of " + std::to_string(o.repetitions));
    // A session's first commit: validation and a build, all pages new.
    committed.reset();
    context.memory.reset_peak();
    committed = setup.register_mesh();
    first.time([&] { setup.commit(*committed); });
    r.ours.bytes = committed->tree().bytes();
    r.ours.bytes_peak = context.memory.peak();
    committed->mesh().set_changed(INSITU_CHANGED_TOPOLOGY);
    first_again.time([&] { setup.commit(*committed); });
    validate.time([&] { committed->validate(context.threads); });
    setup.commit(*committed);

    const mesh::MeshView& view = committed->mesh().view();
    using accel::Builder;
    accel::Tree fast(context.memory), graded(context.memory);
    morton_cold.time([&] { fast.build(view, context.threads, Builder::morton); });
    medium_cold.time([&] { graded.build(view, context.threads, Builder::surface_area); });
    morton.time([&] { fast.build(view, context.threads, Builder::morton); });
    medium.time([&] { graded.build(view, context.threads, Builder::surface_area); });
    for (int twice = 0; twice < 2; ++twice) { // the first one touches the refit's own scratch
      setup.wobble();
      if (twice == 0) {
        fast.refit(view, context.threads);
        graded.refit(view, context.threads);
        continue;
      }
      refit_morton.time([&] { fast.refit(view, context.threads); });
      refit_medium.time([&] { graded.refit(view, context.threads); });
    }
  }

  // The tree after rebuilds and refits still has to answer.
  progress("checking");
  setup.wobble();
  committed->mesh().set_changed(INSITU_CHANGED_GEOMETRY);
  setup.update_field();
  setup.commit(*committed);
  const workload::Queries queries =
      workload::make_queries(setup.mesh, workload::Pattern::uniform, 0);
  Answers answers(queries.points.size());
  query::LocateOptions options;
  options.accuracy = o.accuracy;
  r.ours.locate.time([&] {
    committed->sampler().locate(context.threads, queries.points, answers.locations, options);
  });
  r.ours.sample.time(
      [&] { sample(context.threads, *committed, queries.points, answers, options); });
  r.ours.verdict = check(setup.mesh, queries, {}, answers.cells, answers.values);

  r.ours.name = "libinsitu";
  r.ours.cells = setup.mesh.cell_count();
  r.ours.queries = std::int64_t(queries.points.size());
  r.ours.threads = threads;
  r.ours.build = morton;
  r.ours.refit = refit_morton;
  r.timings = {{"first_commit", first},       {"recommit_topology", first_again},
               {"validate", validate},        {"rebuild_morton_cold", morton_cold},
               {"rebuild_morton", morton},    {"rebuild_medium_cold", medium_cold},
               {"rebuild_medium", medium},    {"refit", refit_morton},
               {"refit_medium", refit_medium}};
  r.numbers = {
      {"refit_over_medium_rebuild", refit_morton.median() / medium.median()},
      {"refit_medium_over_medium_rebuild", refit_medium.median() / medium.median()},
      {"morton_cold_over_warm", morton_cold.median() / morton.median()},
      {"medium_cold_over_warm", medium_cold.median() / medium.median()},
      {"bytes_per_cell", double(r.ours.bytes) / double(r.ours.cells)},
      {"bytes_peak_per_cell", double(r.ours.bytes_peak) / double(r.ours.cells)},
  };
  r.notes = {"cold: new buffers, whose pages are touched for the first time; otherwise kept ones.",
             "refit: of the Morton tree; its ratio is to a warm rebuild by surface area.",
             "The located points are the cells' centres, once, after the last refit."};
  if (o.peers)
    r.notes.push_back("Peers are measured by insitu-bench locate.");
  return r;
}

} // namespace insitu::bench
