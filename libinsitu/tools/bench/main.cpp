#include <cstdio>
#include <exception>
#include <fstream>

#include "commands.h"

namespace {

using namespace insitu::bench;

/// Before the work, not after it.
void require_writable(const std::string& option, const std::string& file) {
  if (!file.empty() && !std::ofstream(file, std::ios::app))
    throw UsageError(option + " " + file + ": cannot be written");
}

Output run(const Options& options) {
  if (options.command == Command::torture)
    return run_torture(options);
  if (options.command == Command::scale)
    return scale(options);
  if (options.command == Command::methods)
    return methods(options);
  if (options.command == Command::amr)
    return amr(options);
  if (options.command == Command::render)
    return render(options);
  if (options.command == Command::accuracy)
    return accuracy_command(options);
  if (options.command == Command::paper)
    return paper_command(options);
  if (options.command == Command::effects)
    return effects(options);
  if (options.command == Command::advect)
    return advect(options);
  if (options.command == Command::scaling)
    return scaling_command(options);
  if (options.command == Command::sections)
    return sections(options);
  const Report report = options.command == Command::commit ? commit(options) : locate(options);
  return {table(report), json(report, options), 0};
}

} // namespace

int main(int argc, char** argv) {
  try {
    const Options options = parse(argc, argv);
    if (options.command == Command::help) {
      std::fputs(help_text(), stdout);
      return 0;
    }
    if (options.json_file != "-")
      require_writable("--json", options.json_file);
    require_writable("--csv", options.csv_file);
    require_writable("--svg", options.svg_file);
    const Output out = run(options);
    progress("");
    if (options.json_file == "-") {
      std::fputs(out.json.c_str(), stdout);
      return out.exit_code;
    }
    std::fputs(out.text.c_str(), stdout);
    if (!options.json_file.empty())
      write_file("--json", options.json_file, out.json);
    return out.exit_code;
  } catch (const UsageError& e) {
    std::fprintf(stderr, "insitu-bench: %s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "insitu-bench: %s\n", e.what());
    return 1;
  }
}
