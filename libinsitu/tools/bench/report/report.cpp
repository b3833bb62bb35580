#include "report/report.h"

#include "report/format.h"
#include "report/json.h"

namespace insitu::bench {

namespace {

Json seconds(const Series& s) {
  return s.empty() ? Json() : number(s.median());
}

Json figures_json(const Figures& f) {
  const auto count = [&](std::int64_t n) { return f.tells_cells ? Json(n) : Json(); };
  return {{"cells", f.cells},
          {"queries", f.queries},
          {"threads", f.threads},
          {"build_s", seconds(f.build)},
          {"refit_s", seconds(f.refit)},
          {"mqps", number(f.mqps(f.locate))},
          {"mqps_sample", number(f.mqps(f.sample))},
          {"bytes", f.bytes},
          {"bytes_peak", f.bytes_peak},
          {"lost", f.verdict.lost},
          {"wrong", count(f.verdict.wrong)},
          {"not_lowest", count(f.verdict.not_lowest)},
          {"max_error", number(f.verdict.max_error)}};
}

std::string series_row(const std::string& name, const Series& s, std::int64_t items) {
  const double rate = s.median() > 0.0 ? 1e-6 * double(items) / s.median() : 0.0;
  return format("  %-24s %10.3f %10.3f %10.3f %10.3f %12.3f\n", name.c_str(), 1e3 * s.min(),
                1e3 * s.median(), 1e3 * s.max(), 1e3 * s.cpu_median(), rate);
}

} // namespace

std::string grouped(std::int64_t n) {
  std::string digits = std::to_string(n);
  for (int i = int(digits.size()) - 3; i > (n < 0 ? 1 : 0); i -= 3)
    digits.insert(std::size_t(i), ",");
  return digits;
}

std::string describe(const Options& o, std::int64_t cells, int threads) {
  std::string out = grouped(cells) + " cells";
  out += o.mesh_file.empty() ? format(" (%s, %s, jitter %g", workload::name(o.kind),
                                      workload::name(o.spacing), o.jitter)
                             : " (" + o.mesh_file;
  out += o.shuffled ? ", shuffled)" : ")";
  out += format(", %d thread%s", threads, threads == 1 ? "" : "s");
  if (o.command == Command::locate)
    out += format(", %s queries, %s", workload::name(o.pattern),
                  o.accuracy == INSITU_EXACT ? "exact" : "standard");
  return out;
}

std::string table(const Report& r) {
  std::string out = r.title + "\n\n";
  out += format("  %-24s %10s %10s %10s %10s %12s\n", "milliseconds", "min", "median", "max",
                "processor", "M items/s");
  for (const auto& [name, series] : r.timings) {
    const bool points = name.starts_with("locate") || name.starts_with("sample");
    std::int64_t items = points ? r.ours.queries : r.ours.cells;
    for (const Figures& peer : r.peers)
      if (name == "locate_" + peer.name)
        items = peer.queries;
    out += series_row(name, series, items);
  }
  out += "\n";
  for (const auto& [name, value] : r.numbers)
    out += format("  %-34s %10.4g\n", name.c_str(), value);
  out += "\n";
  out += format("  %-22s %8s %8s %9s %6s %9s %9s %9s %6s %6s %9s %10s\n", "", "build ms",
                "refit ms", "Mq/s", "ratio", "sample", "B/cell", "peak", "lost", "wrong",
                "notlowest", "max error");
  const auto row = [&](const Figures& f) {
    const double cells = double(f.cells);
    const auto count = [&](std::int64_t n) { return f.tells_cells ? std::to_string(n) : "-"; };
    const double rate = f.mqps(f.locate);
    out += format("  %-22s %8.2f %8s %9.3f %6s %9.3f %9.1f %9.1f %6lld %6s %9s %10.2g\n",
                  f.name.c_str(), 1e3 * f.build.median(),
                  f.refit.empty() ? "-" : format("%.2f", 1e3 * f.refit.median()).c_str(), rate,
                  &f == &r.ours ? "" : format("%.2f", r.ratio(f, r.ours.locate)).c_str(),
                  f.mqps(f.sample), double(f.bytes) / cells, double(f.bytes_peak) / cells,
                  static_cast<long long>(f.verdict.lost), count(f.verdict.wrong).c_str(),
                  count(f.verdict.not_lowest).c_str(), f.verdict.max_error);
  };
  row(r.ours);
  for (const Figures& peer : r.peers)
    row(peer);
  for (const std::string& note : r.notes)
    out += "  " + note + "\n";
  return out;
}

std::string json(const Report& r, const Options& o) {
  Json out = {{"command", name(o.command)},
              {"mesh", o.mesh_file.empty() ? workload::name(o.kind) : o.mesh_file}};
  if (o.mesh_file.empty()) {
    out["kind"] = workload::name(o.spacing);
    out["jitter"] = number(o.jitter);
  }
  out["numbering"] = o.shuffled ? "shuffled" : "natural";
  out["pattern"] = workload::name(o.pattern);
  out["accuracy"] = o.accuracy == INSITU_EXACT ? "exact" : "standard";
  out["repetitions"] = o.repetitions;
  out.update(figures_json(r.ours));
  for (const auto& [name, value] : r.numbers)
    out[name] = number(value);
  out["timings"] = Json::object();
  for (const auto& [name, s] : r.timings)
    out["timings"][name] = {{"min", number(s.min())},
                            {"median", number(s.median())},
                            {"max", number(s.max())},
                            {"cpu", number(s.cpu_median())}};
  if (o.peers) {
    out["peers"] = Json::object();
    for (const Figures& peer : r.peers)
      out["peers"][peer.name] = figures_json(peer);
  }
  return json_text(out);
}

} // namespace insitu::bench
