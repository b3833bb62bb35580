#include "report.h"

#include <cmath>
#include <cstdio>

namespace insitu::bench {

namespace {

template <class... A>
std::string format(const char* pattern, A... a) {
  char text[512];
  std::snprintf(text, sizeof text, pattern, a...);
  return text;
}

std::string grouped(std::int64_t n) {
  std::string digits = std::to_string(n);
  for (int i = int(digits.size()) - 3; i > (n < 0 ? 1 : 0); i -= 3)
    digits.insert(std::size_t(i), ",");
  return digits;
}

std::string number(double x) {
  return std::isfinite(x) ? format("%.9g", x) : "null";
}

std::string quoted(const std::string& s) {
  std::string out = "\"";
  for (const char c : s) {
    if (c == '"' || c == '\\')
      out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += format("\\u%04x", unsigned(c));
    else
      out += c;
  }
  return out + "\"";
}

std::string seconds(const Series& s) {
  return s.empty() ? "null" : number(s.median());
}

std::string figures_json(const Figures& f, const std::string& indent) {
  const auto line = [&](const char* key, const std::string& value) {
    return indent + "\"" + key + "\": " + value + ",\n";
  };
  return line("cells", std::to_string(f.cells)) + line("queries", std::to_string(f.queries)) +
         line("threads", std::to_string(f.threads)) + line("build_s", seconds(f.build)) +
         line("refit_s", seconds(f.refit)) + line("mqps", number(f.mqps(f.locate))) +
         line("mqps_sample", number(f.mqps(f.sample))) + line("bytes", std::to_string(f.bytes)) +
         line("bytes_peak", std::to_string(f.bytes_peak)) +
         line("lost", std::to_string(f.verdict.lost)) +
         line("wrong", f.tells_cells ? std::to_string(f.verdict.wrong) : "null") + indent +
         "\"max_error\": " + number(f.verdict.max_error);
}

std::string series_row(const std::string& name, const Series& s, std::int64_t items) {
  const double rate = s.median() > 0.0 ? 1e-6 * double(items) / s.median() : 0.0;
  return format("  %-24s %10.3f %10.3f %10.3f %10.3f %12.3f\n", name.c_str(), 1e3 * s.min(),
                1e3 * s.median(), 1e3 * s.max(), 1e3 * s.cpu_median(), rate);
}

} // namespace

std::string describe(const Options& o, std::int64_t cells, int threads) {
  std::string out = grouped(cells) + " cells";
  out += o.mesh_file.empty() ? format(" (%s, jitter %g%s)", workload::name(o.kind), o.jitter,
                                      o.renumber ? ", renumbered" : "")
                             : " (" + o.mesh_file + (o.renumber ? ", renumbered)" : ")");
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
    out += series_row(name, series, points ? r.ours.queries : r.ours.cells);
  }
  out += "\n";
  for (const auto& [name, value] : r.numbers)
    out += format("  %-24s %10.4g\n", name.c_str(), value);
  out += "\n";
  out += format("  %-22s %8s %8s %9s %9s %9s %9s %6s %6s %10s\n", "", "build ms", "refit ms", "Mq/s",
                "sample", "B/cell", "peak", "lost", "wrong", "max error");
  const auto row = [&](const Figures& f) {
    const double cells = double(f.cells);
    out +=
        format("  %-22s %8.2f %8s %9.3f %9.3f %9.1f %9.1f %6lld %6s %10.2g\n", f.name.c_str(),
               1e3 * f.build.median(),
              f.refit.empty() ? "-" : format("%.2f", 1e3 * f.refit.median()).c_str(),
               f.mqps(f.locate), f.mqps(f.sample), double(f.bytes) / cells,
               double(f.bytes_peak) / cells, static_cast<long long>(f.verdict.lost),
               f.tells_cells ? std::to_string(f.verdict.wrong).c_str() : "-", f.verdict.max_error);
  };
  row(r.ours);
  for (const Figures& peer : r.peers)
    row(peer);
  for (const std::string& note : r.notes)
    out += "  " + note + "\n";
  return out;
}

std::string json(const Report& r, const Options& o) {
  std::string out = "{\n";
  out += "  \"command\": " + quoted(o.command == Command::commit ? "commit" : "locate") + ",\n";
  out +=
      "  \"mesh\": " + quoted(o.mesh_file.empty() ? workload::name(o.kind) : o.mesh_file) + ",\n";
  if (o.mesh_file.empty())
    out += "  \"jitter\": " + number(o.jitter) + ",\n";
  out += "  \"pattern\": " + quoted(workload::name(o.pattern)) + ",\n";
  out += "  \"accuracy\": " + quoted(o.accuracy == INSITU_EXACT ? "exact" : "standard") + ",\n";
  out += "  \"repetitions\": " + std::to_string(o.repetitions) + ",\n";
  out += figures_json(r.ours, "  ") + ",\n";
  for (const auto& [name, value] : r.numbers)
    out += "  " + quoted(name) + ": " + number(value) + ",\n";
  out += "  \"timings\": {";
  const char* separator = "\n";
  for (const auto& [name, s] : r.timings) {
    out += separator + format("    %s: {\"min\": %s, \"median\": %s, \"max\": %s, \"cpu\": %s}",
                              quoted(name).c_str(), number(s.min()).c_str(),
                              number(s.median()).c_str(), number(s.max()).c_str(),
                              number(s.cpu_median()).c_str());
    separator = ",\n";
  }
  out += "\n  }";
  if (o.peers) {
    out += ",\n  \"peers\": {";
    separator = "\n";
    for (const Figures& peer : r.peers) {
      out += separator + ("    " + quoted(peer.name)) + ": {\n" + figures_json(peer, "      ") +
             "\n    }";
      separator = ",\n";
    }
    out += r.peers.empty() ? "}" : "\n  }";
  }
  return out + "\n}\n";
}

} // namespace insitu::bench
