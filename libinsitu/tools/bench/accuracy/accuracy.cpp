#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>

#include "accuracy/sweeps.h"
#include "commands.h"
#include "report/format.h"

namespace insitu::bench {

namespace {

using namespace accuracy;

std::string machine() {
  std::ifstream cpu("/proc/cpuinfo");
  std::string model = "an unnamed processor";
  for (std::string line; std::getline(cpu, line);)
    if (line.starts_with("model name")) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  return "Measured on " + model + ", " + std::to_string(std::thread::hardware_concurrency()) +
         " hardware threads.";
}

std::string line(const Sweep& s) {
  std::string out = s.title + "\n  " + s.advice + "\n  " + say_losers(s) + "\n";
  for (const std::string& group : s.groups()) {
    const Setting* chosen = s.default_of(group);
    if (!chosen)
      continue;
    out += format("  %-26s %-24s error %9.3g  %9.3g s", group.c_str(), chosen->name.c_str(),
                  chosen->error, chosen->seconds());
    out += format("  time over front %5.2f", default_over_front(s, group, seconds));
    if (const double counted = default_over_front(s, group, work); counted > 0.0)
      out += format(", work over front %5.2f", counted);
    out += "\n";
  }
  return out + "\n";
}

} // namespace

Output accuracy_command(const Options& o) {
  const Extent extent{!o.full, o.repetitions};
  using Make = Sweep (*)(const Extent&);
  const std::pair<const char*, Make> all[] = {{"locate", sweep_locate},
                                              {"newton", sweep_newton},
                                              {"advect", sweep_advect},
                                              {"volume", sweep_volume},
                                              {"path_tracing", sweep_path_tracing},
                                              {"amr", sweep_amr},
                                              {"update", sweep_update}};
  for (const std::string& wanted : o.sweeps)
    if (wanted != "effects" && std::none_of(std::begin(all), std::end(all),
                                            [&](const auto& a) { return wanted == a.first; })) {
      std::string known = "effects";
      for (const auto& [key, make] : all)
        known += std::string(", ") + key;
      throw UsageError("--sweep: one of " + known + " expected, '" + wanted + "' given");
    }
  const auto is_wanted = [&](const std::string& key) {
    return o.sweeps.empty() || std::find(o.sweeps.begin(), o.sweeps.end(), key) != o.sweeps.end();
  };
  const std::filesystem::path folder(o.out_folder.empty() ? "accuracy" : o.out_folder);
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    throw UsageError("--out " + folder.string() + ": " + failed.message());

  std::vector<Sweep> sweeps;
  Output out;
  out.text = "insitu-bench accuracy: " + std::string(o.full ? "full" : "quick") + ", medians of " +
             std::to_string(o.repetitions) + ", one core\n" + machine() + "\n\n";
  for (const auto& [key, make] : all) {
    if (!is_wanted(key))
      continue;
    sweeps.push_back(make(extent));
    const Sweep& s = sweeps.back();
    write_file("--out", (folder / (s.key + ".csv")).string(), csv(s));
    write_file("--out", (folder / (s.key + ".svg")).string(), plot(s));
    out.text += line(s);
  }
  Output priced;
  if (is_wanted("effects")) {
    Options e = o;
    e.command = Command::effects;
    e.cells = {o.full ? 100'000 : 4096};
    e.size = o.full ? 512 : 64;
    priced = effects(e);
    write_file("--out", (folder / "effects.csv").string(), priced.csv);
    write_file("--out", (folder / "effects.svg").string(), priced.svg);
    out.text += "Effects\n  " + priced.advice + "\n\n";
  }
  const std::string report = (folder / "report.html").string();
  write_file("--out", report, page(sweeps, priced, machine()));
  out.text += "written: " + report + ", a .csv and a .svg for each sweep beside it\n";
  return out;
}

} // namespace insitu::bench
