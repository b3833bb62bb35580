#include <algorithm>
#include <optional>

#include "accel/device_locator.h"
#include "commands.h"
#include "core/timer.h"
#include "energy.h"
#include "format.h"
#include "methods/runner.h"
#include "query/locator_choice.h"

namespace insitu::bench {

namespace {

using accel::Backend;
using accel::Method;

constexpr insitu_accuracy accuracies[] = {INSITU_FAST, INSITU_STANDARD, INSITU_EXACT};
constexpr const char* accuracy_names[] = {"fast", "standard", "exact"};
constexpr const char* wanted_names[] = {"ids", "cell_value", "vertex_value"};
constexpr int accuracy_count = 3;

/// Million samples a second.
struct Rates {
  double of[accuracy_count][wanted_count] = {};
};

/// One method on one mesh.
struct Row {
  Backend backend;
  Method method;
  workload::Kind kind;
  std::string absent; ///< why there are no figures
  Sizes sizes;
  double build_s = 0.0, refit_s = 0.0;
  Rates uniform, random;
  std::int64_t points = 0; ///< random ones that were answered
  std::int64_t other[accuracy_count] =
      {};                       ///< of them, answered otherwise than by exact bvh on the CPU
  std::optional<double> joules; ///< a million random queries, ids, fast
};

std::string full_name(const Row& row) {
  return std::string(name(row.backend)) + " " + name(row.method);
}

/// Medians of a few runs each; of one where it takes long.
Rates time_rates(MethodRunner& runner, std::size_t points, int repetitions) {
  Rates rates;
  for (int a = 0; a < accuracy_count; ++a)
    for (int w = 0; w < wanted_count; ++w) {
      Series series;
      const core::Timer timer;
      runner.answer(Wanted(w), accuracies[a]); // touches buffers
      const int times = timer.seconds() > 0.25 ? 1 : repetitions;
      for (int i = 0; i < times; ++i)
        series.time([&] { runner.answer(Wanted(w), accuracies[a]); });
      rates.of[a][w] = 1e-6 * double(points) / series.median();
    }
  return rates;
}

/// Joules a million queries, over a second or more of them: counters tick slowly.
double joules_a_million(MethodRunner& runner, EnergyMeter& meter, std::size_t points) {
  const core::Timer timer;
  const double before = meter.joules();
  double millions = 0.0;
  while (timer.seconds() < 1.5) {
    runner.answer(Wanted::ids, INSITU_FAST);
    millions += 1e-6 * double(points);
  }
  return (meter.joules() - before) / millions;
}

/// Ray methods are slow on processors: they answer the first of the points only, and bvh there the
/// first million.
std::size_t most_points(Backend backend, Method method) {
  if (backend != Backend::cpu)
    return std::size_t(-1);
  return method == Method::bvh ? 1'000'000 : 100'000;
}

class Bench {
public:
  explicit Bench(const Options& o) : o_(o), context_(o.threads, core::Log()) {}

  std::vector<Row> run() {
    using workload::Kind;
    const std::vector<Kind> kinds =
        o_.kind_given ? std::vector{o_.kind}
                      : std::vector{Kind::tetrahedra, Kind::hexahedra, Kind::wedges, Kind::mixed};
    std::vector<Row> rows;
    for (const Kind kind : kinds) {
      make(kind);
      for (int b = 0; b < accel::backend_count; ++b)
        for (int m = 0; m < accel::method_count; ++m)
          if (has(Backend(b), Method(m)) && wanted(Backend(b), Method(m)))
            rows.push_back(measure(Backend(b), Method(m), kind));
    }
    return rows;
  }

  const EnergyMeter& processor() const { return processor_; }
  const EnergyMeter& card() const { return card_; }

private:
  bool wanted(Backend b, Method m) const {
    const auto in = [](const std::vector<std::string>& names, const char* one) {
      return names.empty() || std::find(names.begin(), names.end(), one) != names.end();
    };
    return in(o_.backends, name(b)) && in(o_.methods, name(m));
  }

  void make(workload::Kind kind) {
    progress(std::string("making the mesh of ") + workload::name(kind));
    mesh_.mesh = workload::make_box(kind, workload::box_size(kind, o_.cells[0], o_.spacing),
                                    o_.jitter, o_.spacing);
    mesh_.vertex_field = workload::vertex_field(mesh_.mesh);
    mesh_.cell_field.resize(std::size_t(mesh_.mesh.cell_count()));
    for (std::size_t c = 0; c < mesh_.cell_field.size(); ++c)
      mesh_.cell_field[c] = double(c);
    uniform_ = workload::make_queries(mesh_.mesh, workload::Pattern::uniform, 0).points;
    random_ = workload::make_queries(mesh_.mesh, workload::Pattern::random,
                                     o_.points > 0 ? o_.points : mesh_.mesh.cell_count())
                  .points;
    const auto truth = make_cpu_runner(Method::bvh, mesh_, context_);
    truth->set_points(random_);
    truth->answer(Wanted::ids, INSITU_EXACT);
    truth->ids(owners_);
  }

  Row measure(Backend backend, Method method, workload::Kind kind) {
    Row row{backend, method, kind, accel::why_unavailable(backend), {}, 0.0, 0.0, {}, {},
            0,       {},     {}};
    if (!row.absent.empty())
      return row;
    progress(std::string(workload::name(kind)) + ", " + full_name(row));
    const bool cpu = backend == Backend::cpu;
    const auto first_of = [&](const std::vector<math::Vec3d>& points) {
      return std::span(points).first(std::min(points.size(), most_points(backend, method)));
    };
    const auto runner = cpu ? make_cpu_runner(method, mesh_, context_)
                            : make_device_runner(backend, method, mesh_, context_);
    row.sizes = runner->build(row.build_s);
    row.refit_s = runner->refit();
    runner->set_points(first_of(uniform_));
    row.uniform = time_rates(*runner, first_of(uniform_).size(), o_.repetitions);
    const std::span<const math::Vec3d> random = first_of(random_);
    runner->set_points(random);
    row.random = time_rates(*runner, random.size(), o_.repetitions);
    row.points = std::int64_t(random.size());
    std::vector<std::int64_t> ids;
    for (int a = 0; a < accuracy_count; ++a) {
      runner->answer(Wanted::ids, accuracies[a]);
      runner->ids(ids);
      for (std::size_t i = 0; i < random.size(); ++i)
        row.other[a] += ids[i] != owners_[i];
    }
    EnergyMeter& meter = cpu ? processor_ : card_;
    if (meter.works())
      row.joules = joules_a_million(*runner, meter, random.size());
    return row;
  }

  const Options& o_;
  core::Context context_;
  MethodMesh mesh_;
  std::vector<math::Vec3d> uniform_, random_;
  std::vector<std::int64_t> owners_; ///< of random points, by exact bvh on the CPU
  EnergyMeter processor_{EnergyMeter::Of::processor}, card_{EnergyMeter::Of::card};
};

std::string megabytes(std::int64_t bytes) {
  return bytes ? format("%.0fM", double(bytes) / 1e6) : "-";
}

/// A table: rows are methods, columns `cells` of each mesh.
template <class Cells>
std::string table_of(const std::vector<Row>& rows, const std::string& title,
                     const std::string& columns, Cells&& cells) {
  std::string text = "\n" + title + "\n";
  for (const Row& row : rows) {
    if (&row == &rows.front() || row.kind != (&row - 1)->kind)
      text += format("  %-29s %s\n", workload::name(row.kind), columns.c_str());
    text += format("    %-27s ", full_name(row).c_str()) +
            (row.absent.empty() ? cells(row) : "  " + row.absent) + "\n";
  }
  return text;
}

std::string rates_table(const std::vector<Row>& rows, const std::string& title, Rates Row::*rates) {
  return table_of(
      rows, title,
      "   fast: ids   cell value vertex value | standard: ids vertex | exact: ids vertex",
      [rates](const Row& row) {
        const auto& of = (row.*rates).of;
        return format("%12.1f %12.1f %12.1f | %13.1f %6.1f | %10.1f %6.1f", of[0][0], of[0][1],
                      of[0][2], of[1][0], of[1][2], of[2][0], of[2][2]);
      });
}

std::string text_of(const std::vector<Row>& rows, const Bench& bench, const Options& o) {
  std::string text = format("insitu-bench methods: about %s cells, jitter %g",
                            grouped(o.cells[0]).c_str(), o.jitter);
  const std::string device = device_name();
  text += device.empty() ? "\n" : "; " + device + "\n";
  text += table_of(
      rows,
      "Memory (Morrical 2020, table 1): bytes; peak while building, all at once and in "
      "groups of 2^20 primitives; build and refit in ms",
      "primitives    final peak, whole peak, groups     build     refit", [](const Row& r) {
        return format("%12s %8s %11s %12s %9.1f %9.1f", grouped(r.sizes.primitives).c_str(),
                      megabytes(r.sizes.bytes).c_str(), megabytes(r.sizes.peak_whole).c_str(),
                      megabytes(r.sizes.peak).c_str(), 1e3 * r.build_s, 1e3 * r.refit_s);
      });
  text += rates_table(rows, "Uniform (table 2): a point a cell, million samples a second",
                      &Row::uniform);
  text += rates_table(rows, "Random (table 3): million samples a second", &Row::random);
  text += table_of(rows, "Random points answered otherwise than by exact bvh on the CPU",
                   "      points       fast   standard      exact", [](const Row& r) {
                     return format("%12s %10s %10s %10s", grouped(r.points).c_str(),
                                   grouped(r.other[0]).c_str(), grouped(r.other[1]).c_str(),
                                   grouped(r.other[2]).c_str());
                   });
  text += table_of(rows, "Energy (section 9.4): joules a million random queries, ids, fast", "",
                   [](const Row& r) {
                     return r.joules ? format("%10.4f", *r.joules) : std::string("         -");
                   });
  if (!bench.processor().works())
    text += "  Processor: " + bench.processor().why() + ".\n";
  if (!bench.card().works())
    text += "  Card: " + bench.card().why() + ".\n";
  for (const bool on_device : {false, true}) {
    text += on_device ? "auto, mesh in device memory: " : "\nauto, mesh in host memory: ";
    try {
      const query::LocatorPick pick = query::pick_locator({}, on_device);
      text +=
          std::string(name(pick.backend)) + " " + name(pick.method) + " (" + pick.reason + ")\n";
    } catch (const std::exception& e) {
      text += std::string(e.what()) + "\n";
    }
  }
  return text;
}

std::string json_of(const std::vector<Row>& rows, const Options& o) {
  std::string text = "{\"command\": \"methods\", \"cells\": " + std::to_string(o.cells[0]) +
                     ", \"device\": " + quoted(device_name()) + ", \"rows\": [";
  for (const Row& r : rows) {
    text += (&r == &rows.front() ? "\n" : ",\n") + std::string("  {\"shape\": ") +
            quoted(workload::name(r.kind)) + ", \"backend\": " + quoted(name(r.backend)) +
            ", \"method\": " + quoted(name(r.method));
    if (!r.absent.empty()) {
      text += ", \"absent\": " + quoted(r.absent) + "}";
      continue;
    }
    text += ", \"primitives\": " + std::to_string(r.sizes.primitives) +
            ", \"bytes\": " + std::to_string(r.sizes.bytes) +
            ", \"peak_whole\": " + std::to_string(r.sizes.peak_whole) +
            ", \"peak_groups\": " + std::to_string(r.sizes.peak) +
            ", \"build_s\": " + number(r.build_s) + ", \"refit_s\": " + number(r.refit_s) +
            ", \"random_points\": " + std::to_string(r.points);
    for (int a = 0; a < accuracy_count; ++a) {
      text += std::string(", \"other_") + accuracy_names[a] + "\": " + std::to_string(r.other[a]);
      for (int w = 0; w < wanted_count; ++w)
        text += std::string(", \"uniform_") + accuracy_names[a] + "_" + wanted_names[w] +
                "\": " + number(r.uniform.of[a][w]) + ", \"random_" + accuracy_names[a] + "_" +
                wanted_names[w] + "\": " + number(r.random.of[a][w]);
    }
    text += ", \"joules\": " + (r.joules ? number(*r.joules) : std::string("null")) + "}";
  }
  return text + "\n]}\n";
}

} // namespace

Output methods(const Options& options) {
  Bench bench(options);
  const std::vector<Row> rows = bench.run();
  Output out{text_of(rows, bench, options), json_of(rows, options), 0};
  for (const Row& r : rows)
    if (r.other[2] > 0) // exact is exact
      out.exit_code = 1;
  return out;
}

} // namespace insitu::bench
