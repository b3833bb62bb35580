#include <cstdio>
#include <exception>
#include <fstream>

#include "commands.h"

int main(int argc, char** argv) {
  using namespace insitu::bench;
  try {
    const Options options = parse(argc, argv);
    if (options.command == Command::help) {
      std::fputs(help_text(), stdout);
      return 0;
    }
    if (!options.json_file.empty() && options.json_file != "-" &&
        !std::ofstream(options.json_file, std::ios::app))
      throw UsageError("--json " + options.json_file + ": cannot be written");
    const Report report = options.command == Command::commit ? commit(options) : locate(options);
    progress("");
    if (options.json_file == "-") {
      std::fputs(json(report, options).c_str(), stdout);
      return 0;
    }
    std::fputs(table(report).c_str(), stdout);
    if (!options.json_file.empty()) {
      std::ofstream file(options.json_file, std::ios::trunc);
      file << json(report, options);
      file.close();
      if (!file) {
        std::fprintf(stderr, "insitu-bench: --json %s: writing failed\n",
                     options.json_file.c_str());
        return 1;
      }
    }
    return 0;
  } catch (const UsageError& e) {
    std::fprintf(stderr, "insitu-bench: %s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "insitu-bench: %s\n", e.what());
    return 1;
  }
}
