#include <algorithm>

#include "report/chart.h"
#include "commands.h"
#include "report/format.h"
#include "report/json.h"

namespace insitu::bench {

namespace {

/// One size of mesh; times in nanoseconds a cell or query.
struct BySize {
  std::int64_t cells;
  double build, refit, uniform, random;
  Work uniform_work, random_work;
  double bytes;
};

/// One size of batch on one mesh; nanoseconds a query.
struct ByBatch {
  std::int64_t queries;
  double random, sorted;
};

/// Nanoseconds of work on n items. Little work is repeated until it takes long enough to be timed.
template <class F>
double nanoseconds(std::int64_t n, int threads, int repetitions, F&& work) {
  const std::int64_t times = std::max<std::int64_t>(1, 500'000 / n);
  Series series;
  for (int i = 0; i < repetitions; ++i)
    series.time([&] {
      for (std::int64_t k = 0; k < times; ++k)
        work();
    });
  return 1e9 * series.for_ratio(threads) / double(n * times);
}

/// Nanoseconds a query.
double time_queries(const query::Sampler& sampler, const core::Threads& threads,
                    std::span<const math::Vec3d> points, const Options& o) {
  query::LocateOptions options;
  options.accuracy = o.accuracy;
  std::vector<query::Location> found(points.size());
  sampler.locate(threads, points, found, options); // touches pages
  return nanoseconds(std::int64_t(points.size()), threads.count(), o.repetitions,
                     [&] { sampler.locate(threads, points, found, options); });
}

BySize measure(Setup& setup, commit::CommittedMesh& committed, const Options& o) {
  using workload::Pattern;
  BySize out{};
  out.cells = setup.mesh.cell_count();
  {
    accel::Tree tree(setup.context.memory);
    const mesh::MeshView& view = committed.mesh().view();
    const core::Threads& threads = setup.context.threads;
    const auto build = [&] { tree.build(view, threads, accel::Builder::morton); };
    const auto refit = [&] { tree.refit(view, threads); };
    build(); // touches pages
    out.build = nanoseconds(out.cells, threads.count(), o.repetitions, build);
    refit();
    out.refit = nanoseconds(out.cells, threads.count(), o.repetitions, refit);
  }
  out.bytes = double(committed.tree().bytes()) / double(out.cells);
  const auto run = [&](Pattern pattern, double& time, Work& work) {
    const auto queries = workload::make_queries(setup.mesh, pattern, 1'000'000);
    time = time_queries(committed.sampler(), setup.context.threads, queries.points, o);
    work = count_work(committed.tree(), queries.points);
  };
  run(Pattern::uniform, out.uniform, out.uniform_work);
  run(Pattern::random, out.random, out.random_work);
  return out;
}

std::vector<ByBatch> measure_batches(Setup& setup, commit::CommittedMesh& committed,
                                     const Options& o) {
  std::vector<ByBatch> out;
  for (std::int64_t n = 100; n <= 10 * std::min<std::int64_t>(setup.mesh.cell_count(), 1'000'000);
       n *= 10) {
    progress(std::to_string(n) + " queries");
    const auto run = [&](workload::Pattern pattern) {
      const auto queries = workload::make_queries(setup.mesh, pattern, n);
      return time_queries(committed.sampler(), setup.context.threads, queries.points, o);
    };
    out.push_back({n, run(workload::Pattern::random), run(workload::Pattern::sorted)});
  }
  return out;
}

std::string csv(const std::vector<BySize>& sizes, const std::vector<ByBatch>& batches,
                std::int64_t batch_cells) {
  std::string out = "sweep,cells,queries,build_ns_per_cell,refit_ns_per_cell,bytes_per_cell,"
                    "uniform_ns,random_ns,sorted_ns,uniform_nodes,random_nodes,"
                    "uniform_candidates,random_candidates\n";
  for (const BySize& s : sizes)
    out += format("cells,%lld,,%.4g,%.4g,%.4g,%.4g,%.4g,,%.4g,%.4g,%.4g,%.4g\n",
                  static_cast<long long>(s.cells), s.build, s.refit, s.bytes, s.uniform, s.random,
                  s.uniform_work.nodes, s.random_work.nodes, s.uniform_work.candidates,
                  s.random_work.candidates);
  for (const ByBatch& b : batches)
    out += format("queries,%lld,%lld,,,,,%.4g,%.4g,,,,\n", static_cast<long long>(batch_cells),
                  static_cast<long long>(b.queries), b.random, b.sorted);
  return out;
}

std::string plot(const std::string& shape, const std::vector<BySize>& sizes,
                 const std::vector<ByBatch>& batches, std::int64_t batch_cells) {
  Chart time{shape + ": time", "cells", "ns a query; ns a cell built or refitted"};
  Chart work{shape + ": work", "cells", "tree nodes, candidate cells a query"};
  Chart batch{"batches on " + grouped(batch_cells) + " cells", "queries in the batch",
              "milliseconds a batch"};
  const auto line = [](Chart& chart, const char* label, const auto& items, auto&& point) {
    Chart::Line& l = chart.lines.emplace_back(Chart::Line{label, Chart::Style::joined, {}});
    for (const auto& item : items)
      l.points.push_back(point(item));
  };
  const auto by_cells = [](auto&& value) {
    return [value](const BySize& s) { return Chart::Point{double(s.cells), value(s), "", ""}; };
  };
  line(time, "random", sizes, by_cells([](const BySize& s) { return s.random; }));
  line(time, "uniform", sizes, by_cells([](const BySize& s) { return s.uniform; }));
  line(time, "build", sizes, by_cells([](const BySize& s) { return s.build; }));
  line(time, "refit", sizes, by_cells([](const BySize& s) { return s.refit; }));
  line(work, "nodes, random", sizes, by_cells([](const BySize& s) { return s.random_work.nodes; }));
  line(work, "candidates, random", sizes,
       by_cells([](const BySize& s) { return s.random_work.candidates; }));
  const auto by_queries = [](auto&& value) {
    return [value](const ByBatch& b) {
      return Chart::Point{double(b.queries), 1e-6 * double(b.queries) * value(b), "", ""};
    };
  };
  line(batch, "random", batches, by_queries([](const ByBatch& b) { return b.random; }));
  line(batch, "sorted", batches, by_queries([](const ByBatch& b) { return b.sorted; }));
  const double slope = batches.empty() ? 0.0 : 0.5 * batches.back().sorted;
  line(batch, "linear", batches, by_queries([slope](const ByBatch&) { return slope; }));
  batch.lines.back().style = Chart::Style::dashed;
  return svg({time, work, batch});
}

} // namespace

Output scale(const Options& o) {
  std::vector<std::int64_t> wanted = o.cells;
  std::sort(wanted.begin(), wanted.end());
  // Batches are swept on the largest mesh of at most a million cells.
  const auto above = std::upper_bound(wanted.begin(), wanted.end(), 1'000'000);
  const std::int64_t for_batches = above == wanted.begin() ? wanted.front() : *(above - 1);

  std::vector<BySize> sizes;
  std::vector<ByBatch> batches;
  std::int64_t batch_cells = 0;
  int threads = 0;
  for (const std::int64_t cells : wanted) {
    Options one = o;
    one.cells = {cells};
    Setup setup(one);
    threads = setup.context.threads.count();
    progress(std::to_string(cells) + " cells");
    const auto committed = setup.register_mesh();
    setup.commit(*committed);
    sizes.push_back(measure(setup, *committed, o));
    if (cells == for_batches && batches.empty()) {
      batch_cells = setup.mesh.cell_count();
      batches = measure_batches(setup, *committed, o);
    }
  }

  Output out;
  out.text =
      format("insitu-bench scale: %s, %s, jitter %g%s, %s, %d thread%s; nanoseconds%s\n\n",
             workload::name(o.kind), workload::name(o.spacing), o.jitter,
             o.shuffled ? ", shuffled" : "", o.accuracy == INSITU_EXACT ? "exact" : "standard",
             threads, threads == 1 ? "" : "s", threads == 1 ? " of processor time" : "");
  out.text += format("  %12s %9s %9s %8s %9s %9s %14s %18s\n", "cells", "build", "refit", "B/cell",
                     "uniform", "random", "nodes, random", "candidates, random");
  Json json = {{"command", "scale"}, {"by_cells", Json::array()}, {"by_queries", Json::array()}};
  for (const BySize& s : sizes) {
    out.text += format("  %12s %9.1f %9.1f %8.1f %9.1f %9.1f %14.2f %18.2f\n",
                       grouped(s.cells).c_str(), s.build, s.refit, s.bytes, s.uniform, s.random,
                       s.random_work.nodes, s.random_work.candidates);
    json["by_cells"].push_back({{"cells", s.cells},
                                {"build_ns", number(s.build, 4)},
                                {"refit_ns", number(s.refit, 4)},
                                {"bytes", number(s.bytes, 4)},
                                {"uniform_ns", number(s.uniform, 4)},
                                {"random_ns", number(s.random, 4)},
                                {"random_nodes", number(s.random_work.nodes, 4)},
                                {"random_candidates", number(s.random_work.candidates, 4)}});
  }
  out.text += "\n  " + grouped(batch_cells) + " cells:\n" +
              format("  %12s %9s %9s\n", "queries", "random", "sorted");
  for (const ByBatch& b : batches) {
    out.text += format("  %12s %9.1f %9.1f\n", grouped(b.queries).c_str(), b.random, b.sorted);
    json["by_queries"].push_back({{"cells", batch_cells},
                                  {"queries", b.queries},
                                  {"random_ns", number(b.random, 4)},
                                  {"sorted_ns", number(b.sorted, 4)}});
  }
  out.json = json_text(json);
  if (!o.csv_file.empty())
    write_file("--csv", o.csv_file, csv(sizes, batches, batch_cells));
  if (!o.svg_file.empty())
    write_file("--svg", o.svg_file, plot(workload::name(o.kind), sizes, batches, batch_cells));
  return out;
}

} // namespace insitu::bench
