#include "paper/paper.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "commands.h"
#include "report/format.h"
#include "free_memory.h"

namespace insitu::bench {

namespace {

/// With --full, of the largest mesh.
std::int64_t most_cells(const std::string& paper) {
  // The paper's largest, and what a cell takes here at most, in bytes: the mesh and the dearest
  // method's structures while they are built (morrical: four triangles of Embree's a tetrahedron;
  // zellmann: twelve a cube).
  const auto [largest, bytes] = paper == "morrical" ? std::pair(62e6, 1000.0)
                                : paper == "rathke" ? std::pair(47e6, 400.0)
                                                    : std::pair(660e6, 3700.0);
  return std::max(std::int64_t(300'000),
                  std::int64_t(std::min(largest, 0.75 * double(free_memory()) / bytes)));
}

} // namespace

Output paper_command(const Options& options) {
  Options o = options;
  if (o.full)
    o.cells = {most_cells(o.paper)};
  const std::filesystem::path folder(o.out_folder);
  if (!o.out_folder.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed)
      throw UsageError("--out " + folder.string() + ": " + failed.message());
  }
  const paper::Tables all = o.paper == "morrical" ? paper::morrical(o)
                            : o.paper == "rathke" ? paper::rathke(o)
                                                  : paper::zellmann(o);
  Output out;
  out.text = "insitu-bench paper: " + paper::heading(all);
  for (const paper::Table& table : all.tables) {
    out.text += paper::text(table);
    if (!o.out_folder.empty())
      write_file("--out", (folder / (table.key + ".csv")).string(), paper::csv(table));
  }
  if (!o.out_folder.empty()) {
    for (const auto& [name, content] : all.files)
      write_file("--out", (folder / name).string(), content);
    out.text += "written: a .csv of each table" +
                std::string(all.files.empty() ? "" : ", and plots,") + " in " + folder.string() +
                "\n";
  }
  out.json = paper::json(all);
  out.exit_code = all.failed ? 1 : 0;
  return out;
}

} // namespace insitu::bench
