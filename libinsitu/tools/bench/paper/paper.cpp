#include "paper/paper.h"

#include <filesystem>

#include "commands.h"
#include "format.h"

namespace insitu::bench {

Output paper_command(const Options& o) {
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
