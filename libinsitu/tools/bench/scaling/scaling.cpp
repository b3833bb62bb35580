#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "commands.h"
#include "report/format.h"
#include "report/json.h"
#include "scaling/cases.h"

/// `insitu-bench scaling` starts itself under mpiexec once for each number of processes.
namespace insitu::bench {

namespace {

using scaling::Cost;
using scaling::Row;

/// Set for the processes that are started: where the root writes its rows.
constexpr const char* rows_variable = "INSITU_BENCH_ROWS";

Json counts(const Cost& cost) {
  return {{"exchanges", number(cost.exchanges)},
          {"messages", number(cost.messages)},
          {"bytes", number(cost.bytes)}};
}

Json to_json(const Row& row) {
  Json json = {{"name", row.name},
               {"mode", row.weak ? "weak" : "strong"},
               {"processes", row.processes},
               {"items", number(row.model.items)},
               {"seconds", number(row.seconds)},
               {"work_s", number(row.work)},
               {"imbalance", number(row.imbalance)},
               {"reductions", number(row.reductions)},
               {"counted", counts(row.counted)},
               {"model", counts(row.model)}};
  if (row.halo_cells_by_model > 0) {
    json["halo_cells"] = number(row.halo_cells);
    json["halo_cells_model"] = number(row.halo_cells_by_model);
  }
  return json;
}

/// Removes itself.
struct RowsFile {
  std::string path =
      (std::filesystem::temp_directory_path() / format("insitu-bench-rows-%d.json", int(getpid())))
          .string();
  ~RowsFile() {
    std::error_code error;
    std::filesystem::remove(path, error);
  }
};

/// Runs this program again, with the same arguments, on so many processes.
Json run_on(std::int64_t processes, const Options& options) {
  const RowsFile file;
  setenv(rows_variable, file.path.c_str(), 1);
  // Open MPI asks for leave to run as root, and more processes than cores.
  for (const char* leave : {"OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM",
                            "OMPI_MCA_rmaps_base_oversubscribe"})
    setenv(leave, "1", 0);
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  std::vector<std::string> arguments = {scaling::launcher(), "-n", std::to_string(processes),
                                        program};
  arguments.insert(arguments.end(), options.arguments.begin(), options.arguments.end());
  std::vector<char*> pointers;
  for (std::string& argument : arguments)
    pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  pid_t child = 0;
  int status = posix_spawnp(&child, pointers[0], nullptr, nullptr, pointers.data(), environ);
  if (status != 0 || waitpid(child, &status, 0) != child || status != 0)
    throw std::runtime_error("scaling: " + arguments[0] + " -n " + arguments[2] + " failed");
  std::ifstream in(file.path);
  return Json::parse(in);
}

/// The row of the same work on one process.
const Json* alone(const Json& rows, const Json& row) {
  for (const Json& one : rows)
    if (one["processes"] == 1 && one["name"] == row["name"] && one["mode"] == row["mode"])
      return &one;
  return nullptr;
}

std::string table(const Json& rows, const std::string& mode) {
  std::string text =
      format("%-22s %3s %9s %9s %6s %6s %11s %15s %21s %6s\n", mode.c_str(), "P", "seconds",
             "work s", "ratio", "imbal", "exchanges", "messages", "bytes", "ratio");
  for (const Json& row : rows) {
    if (row["mode"] != mode)
      continue;
    const Json &counted = row["counted"], &model = row["model"];
    const auto figure = [](const Json& json, const char* key) { return json[key].get<double>(); };
    const Json* const one = alone(rows, row);
    const std::string ratio =
        one ? format("%.2f", figure(row, "work_s") * figure(*one, "items") /
                                 (figure(*one, "work_s") * figure(row, "items")))
            : "-";
    const double bytes = figure(counted, "bytes"), expected = figure(model, "bytes");
    text +=
        format("%-22s %3d %9.3f %9.3f %6s %6.2f %5.0f %5.0f %7.0f %7.0f %10.0f %10.0f %6s\n",
               row["name"].get<std::string>().c_str(), row["processes"].get<int>(),
               figure(row, "seconds"), figure(row, "work_s"), ratio.c_str(),
               figure(row, "imbalance"), figure(counted, "exchanges"), figure(model, "exchanges"),
               figure(counted, "messages"), figure(model, "messages"), bytes, expected,
               expected > 0 ? format("%.2f", bytes / expected).c_str() : "-");
  }
  return text + "\n";
}

} // namespace

Output scaling_command(const Options& options) {
  if (scaling::launcher().empty())
    throw UsageError("scaling: this build has no MPI");
  if (const char* const path = std::getenv(rows_variable)) {
    const int code = scaling::run_on_mpi(options, [&](const std::vector<Row>& rows) {
      Json json = Json::array();
      for (const Row& row : rows)
        json.push_back(to_json(row));
      write_file(rows_variable, path, json_text(json));
    });
    return {"", "", code};
  }
  Json rows = Json::array();
  for (const std::int64_t processes : options.processes) {
    progress(format("%d processes", int(processes)));
    for (Json& row : run_on(processes, options))
      rows.push_back(std::move(row));
  }
  std::string text =
      format("insitu-bench scaling: strong, %.0f hexahedra, %.0f points, a quarter as many "
             "particles; weak, an eighth of these on each process; jitter %g, frames of %d x %d "
             "pixels, medians of %d\n",
             double(options.cells[0]), double(options.points), options.jitter, options.size,
             options.size, options.repetitions) +
      "work: processor time outside of MPI, of all processes; ratio: over that of one process for "
      "as many items. imbal: of the process with most over the mean.\nexchanges (of each process), "
      "messages and bytes (of all): counted, then as the cost model has them.\n\n" +
      table(rows, "strong") + table(rows, "weak");
  for (const Json& row : rows)
    if (row.contains("halo_cells"))
      text += format("halo cells, %s, %s, %d processes: %.0f, by the model %.0f\n",
                     row["name"].get<std::string>().c_str(), row["mode"].get<std::string>().c_str(),
                     row["processes"].get<int>(), row["halo_cells"].get<double>(),
                     row["halo_cells_model"].get<double>());
  return {text, json_text({{"rows", rows}}), 0};
}

} // namespace insitu::bench
