#include <algorithm>
#include <functional>
#include <iterator>
#include <optional>

#include "commands.h"
#include "methods/rates.h"
#include "query/device/device_locator.h"
#include "query/locator_choice.h"
#include "report/format.h"
#include "report/json.h"

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
  std::string mesh;
  std::string absent; ///< why there are no figures
  Sizes sizes;
  double build_s = 0.0, refit_s = 0.0;
  Rates uniform, random;
  /// How many points were asked, and how many of them were answered otherwise than by exact bvh on
  /// the CPU: random ones, and ones on faces, edges and vertices.
  struct Answers {
    std::int64_t points = 0, other[accuracy_count] = {};
  } inside, boundary;
  Ways ways;                    ///< of the random ones, in exact
  std::optional<double> joules; ///< a million random queries, ids, fast
};

std::string full_name(const Row& row) {
  return std::string(name(row.backend)) + " " + name(row.method);
}

Rates time_rates(MethodRunner& runner, std::size_t points, int repetitions) {
  Rates rates;
  for (int a = 0; a < accuracy_count; ++a)
    for (int w = 0; w < wanted_count; ++w)
      rates.of[a][w] = time_rate(runner, Wanted(w), accuracies[a], points, repetitions);
  return rates;
}

class Bench {
public:
  explicit Bench(const Options& o) : o_(o), context_(o.threads, core::Log()) {}

  std::vector<Row> run() {
    using workload::Kind;
    struct Case {
      std::string name;
      std::function<MethodMesh()> make;
    };
    std::vector<Case> cases;
    const auto add_box = [&](const std::string& name, Kind kind, double jitter) {
      cases.push_back(
          {name, [=, this] { return make_method_mesh(kind, o_.spacing, o_.cells[0], jitter); }});
    };
    const auto add = [&](Kind kind) { add_box(workload::name(kind), kind, o_.jitter); };
    if (o_.kind_given) {
      add(o_.kind);
    } else {
      for (const Kind kind : {Kind::tetrahedra, Kind::hexahedra, Kind::wedges, Kind::mixed})
        add(kind);
      if (o_.check) {
        add(Kind::pyramids);
        cases.push_back(
            {"hex, twisted", [this] { return make_twisted_method_mesh(o_.cells[0], 0.4); }});
        add_box("hex, some folded", Kind::hexahedra, 0.35); // one in twenty: the tree answers all
      }
    }
    std::vector<Row> rows;
    for (const Case& c : cases) {
      progress("making the mesh of " + c.name);
      use(c.make());
      for (int b = 0; b < accel::backend_count; ++b)
        for (int m = 0; m < accel::method_count; ++m)
          if (has(Backend(b), Method(m)) && wanted(Backend(b), Method(m)))
            rows.push_back(measure(Backend(b), Method(m), c.name));
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

  void use(MethodMesh&& mesh) {
    using workload::Pattern;
    mesh_ = std::move(mesh);
    const std::int64_t count = o_.points > 0 ? o_.points : mesh_.mesh.cell_count();
    uniform_ = workload::make_queries(mesh_.mesh, Pattern::uniform, 0).points;
    random_ = workload::make_queries(mesh_.mesh, Pattern::random, count).points;
    boundary_.clear();
    for (const Pattern pattern : {Pattern::faces, Pattern::edges, Pattern::vertices}) {
      const auto some = workload::make_queries(mesh_.mesh, pattern, count / 30).points;
      boundary_.insert(boundary_.end(), some.begin(), some.end());
    }
    const auto truth = make_cpu_runner(Method::bvh, mesh_, context_);
    owners_of(*truth, random_, INSITU_EXACT, owners_);
    owners_of(*truth, boundary_, INSITU_EXACT, boundary_owners_);
  }

  static void owners_of(MethodRunner& runner, std::span<const math::Vec3d> points,
                        insitu_accuracy accuracy, std::vector<std::int64_t>& owners) {
    runner.set_points(points);
    runner.answer(Wanted::ids, accuracy);
    runner.ids(owners);
  }

  Row::Answers compare(MethodRunner& runner, std::span<const math::Vec3d> points,
                       const std::vector<std::int64_t>& owners) const {
    Row::Answers answers;
    answers.points = std::int64_t(points.size());
    std::vector<std::int64_t> ids;
    for (int a = 0; a < accuracy_count; ++a) {
      owners_of(runner, points, accuracies[a], ids);
      for (std::size_t i = 0; i < points.size(); ++i)
        answers.other[a] += ids[i] != owners[i];
    }
    return answers;
  }

  Row measure(Backend backend, Method method, const std::string& mesh) {
    Row row;
    row.backend = backend;
    row.method = method;
    row.mesh = mesh;
    row.absent = query::why_unavailable(backend);
    if (!row.absent.empty())
      return row;
    progress(mesh + ", " + full_name(row));
    const bool cpu = backend == Backend::cpu;
    const auto first_of = [&](const std::vector<math::Vec3d>& points) {
      const std::size_t most = o_.check ? points.size() : most_points(backend, method);
      return std::span(points).first(std::min(points.size(), most));
    };
    const auto runner = cpu ? make_cpu_runner(method, mesh_, context_)
                            : make_device_runner(backend, method, mesh_, context_);
    row.sizes = runner->build(row.build_s);
    if (!o_.check) {
      row.refit_s = runner->refit();
      runner->set_points(first_of(uniform_));
      row.uniform = time_rates(*runner, first_of(uniform_).size(), o_.repetitions);
      runner->set_points(first_of(random_));
      row.random = time_rates(*runner, first_of(random_).size(), o_.repetitions);
      EnergyMeter& meter = cpu ? processor_ : card_;
      if (meter.works()) {
        const Drawn drawn = draw_power(*runner, meter, Wanted::ids, first_of(random_).size());
        row.joules = drawn.joules / drawn.millions;
      }
    }
    row.inside = compare(*runner, first_of(random_), owners_);
    row.ways = runner->ways(); // exact comes last
    row.boundary = compare(*runner, first_of(boundary_), boundary_owners_);
    return row;
  }

  const Options& o_;
  core::Context context_;
  MethodMesh mesh_;
  std::vector<math::Vec3d> uniform_, random_, boundary_;
  std::vector<std::int64_t> owners_, boundary_owners_; ///< by exact bvh on the CPU
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
  std::string mesh;
  for (const Row& row : rows) {
    if (!row.absent.empty())
      continue; // said once, below the tables
    if (row.mesh != mesh)
      text += format("  %-29s %s\n", row.mesh.c_str(), columns.c_str());
    mesh = row.mesh;
    text += format("    %-27s ", full_name(row).c_str()) + cells(row) + "\n";
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

std::string timing_tables(const std::vector<Row>& rows) {
  std::string text;
  text += table_of(
      rows,
      "Memory (Morrical 2020, table 1): bytes; peak while building, all at once and in "
      "groups of 2^20 primitives; finding faces, build with that, and refit in ms",
      "primitives    final peak, whole peak, groups     faces     build     refit",
      [](const Row& r) {
        return format("%12s %8s %11s %12s %9s %9.1f %9.1f", grouped(r.sizes.primitives).c_str(),
                      megabytes(r.sizes.bytes).c_str(), megabytes(r.sizes.peak_whole).c_str(),
                      megabytes(r.sizes.peak).c_str(),
                      r.sizes.faces_s > 0.0 ? format("%.1f", 1e3 * r.sizes.faces_s).c_str() : "-",
                      1e3 * r.build_s, 1e3 * r.refit_s);
      });
  text += rates_table(rows, "Uniform (table 2): a point a cell, million samples a second",
                      &Row::uniform);
  text += rates_table(rows, "Random (table 3): million samples a second", &Row::random);
  return text;
}

std::string energy_table(const std::vector<Row>& rows, const Bench& bench) {
  std::vector<Row> measured;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(measured),
               [](const Row& r) { return r.joules.has_value(); });
  std::string text =
      table_of(measured, "Energy (section 9.4): joules a million random queries, ids, fast",
               "    joules", [](const Row& r) { return format("%10.4f", *r.joules); });
  if (!bench.processor().works())
    text += "  Processor: " + bench.processor().why() + ".\n";
  if (!bench.card().works())
    text += "  Card: " + bench.card().why() + ".\n";
  return text;
}

std::string text_of(const std::vector<Row>& rows, const Bench& bench, const Options& o) {
  std::string text = format("insitu-bench methods: about %s cells, jitter %g",
                            grouped(o.cells[0]).c_str(), o.jitter);
  const std::string device = device_name();
  text += device.empty() ? "\n" : "; " + device + "\n";
  if (!o.check)
    text += timing_tables(rows);
  text += table_of(
      rows,
      "Points answered otherwise than by exact bvh on the CPU: random ones; ones on faces, "
      "edges and vertices",
      "      random       fast   standard      exact    boundary       fast   standard      exact",
      [](const Row& r) {
        const auto columns = [](const Row::Answers& a) {
          return format("%12s %10s %10s %10s", grouped(a.points).c_str(),
                        grouped(a.other[0]).c_str(), grouped(a.other[1]).c_str(),
                        grouped(a.other[2]).c_str());
        };
        return columns(r.inside) + columns(r.boundary);
      });
  text += table_of(
      rows,
      "How those random points were answered in exact: by the cell that the ray told, proven; by "
      "the one across the face (on a device: among those kept); by the tree; and undecided by a "
      "device, on the host",
      "        kept by neighbour      by tree      by host", [](const Row& r) {
        return format("%12s %12s %12s %12s", grouped(r.ways.kept).c_str(),
                      grouped(r.ways.by_neighbour).c_str(), grouped(r.ways.by_tree).c_str(),
                      grouped(r.ways.on_host).c_str());
      });
  if (!o.check)
    text += energy_table(rows, bench);
  text += "\n";
  for (int b = 0; b < accel::backend_count; ++b)
    if (const std::string why = query::why_unavailable(Backend(b)); !why.empty())
      text += std::string("Not here: ") + name(Backend(b)) + ", " + why + ".\n";
  for (const bool on_device : {false, true}) {
    text += on_device ? "auto, mesh in device memory: " : "auto, mesh in host memory: ";
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
  Json json = {{"command", "methods"},
               {"cells", o.cells[0]},
               {"device", device_name()},
               {"rows", Json::array()}};
  for (const Row& r : rows) {
    Json& row = json["rows"].emplace_back(
        Json{{"shape", r.mesh}, {"backend", name(r.backend)}, {"method", name(r.method)}});
    if (!r.absent.empty()) {
      row["absent"] = r.absent;
      continue;
    }
    row.update({{"primitives", r.sizes.primitives},
                {"bytes", r.sizes.bytes},
                {"peak_whole", r.sizes.peak_whole},
                {"peak_groups", r.sizes.peak},
                {"faces_s", number(r.sizes.faces_s)},
                {"exact_kept", r.ways.kept},
                {"exact_by_neighbour", r.ways.by_neighbour},
                {"exact_by_tree", r.ways.by_tree},
                {"exact_on_host", r.ways.on_host},
                {"build_s", number(r.build_s)},
                {"refit_s", number(r.refit_s)},
                {"random_points", r.inside.points},
                {"boundary_points", r.boundary.points}});
    for (int a = 0; a < accuracy_count; ++a) {
      const std::string accuracy = accuracy_names[a];
      row["other_" + accuracy] = r.inside.other[a];
      row["boundary_other_" + accuracy] = r.boundary.other[a];
      for (int w = 0; w < wanted_count; ++w) {
        row["uniform_" + accuracy + "_" + wanted_names[w]] = number(r.uniform.of[a][w]);
        row["random_" + accuracy + "_" + wanted_names[w]] = number(r.random.of[a][w]);
      }
    }
    row["joules"] = r.joules ? number(*r.joules) : Json();
  }
  return json_text(json);
}

} // namespace

Output methods(const Options& options) {
  Bench bench(options);
  const std::vector<Row> rows = bench.run();
  Output out{text_of(rows, bench, options), json_of(rows, options), 0};
  for (const Row& r : rows)
    if (r.inside.other[2] + r.boundary.other[2] > 0) // exact is exact
      out.exit_code = 1;
  return out;
}

} // namespace insitu::bench
