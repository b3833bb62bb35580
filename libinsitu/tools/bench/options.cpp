#include "options.h"

#include <charconv>
#include <string_view>

namespace insitu::bench {

namespace {

template <class T>
T number(std::string_view option, std::string_view text, T lowest, T highest) {
  T value{};
  const auto end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, value);
  if (parsed.ec != std::errc() || parsed.ptr != end || !(value >= lowest && value <= highest)) {
    const auto shown = [](T x) {
      std::string s = std::to_string(x);
      if (s.find('.') != std::string::npos)
        s.erase(s.find_last_not_of("0.") + 1);
      return s.empty() ? std::string("0") : s;
    };
    throw UsageError(std::string(option) + ": a number from " + shown(lowest) + " to " +
                     shown(highest) + " expected, '" + std::string(text) + "' given");
  }
  return value;
}

template <class T>
T choice(std::string_view option, std::string_view text, const std::optional<T>& value,
         const char* choices) {
  if (!value)
    throw UsageError(std::string(option) + ": " + choices + " expected, '" + std::string(text) +
                     "' given");
  return *value;
}

} // namespace

Options parse(int argc, char** argv) {
  Options o;
  if (argc < 2)
    throw UsageError("a command expected: commit or locate");
  const std::string_view command = argv[1];
  if (command == "--help" || command == "-h" || command == "help")
    return o;
  if (command == "commit")
    o.command = Command::commit;
  else if (command == "locate")
    o.command = Command::locate;
  else
    throw UsageError("'" + std::string(command) + "' is no command: commit or locate expected");

  for (int i = 2; i < argc; ++i) {
    const std::string_view option = argv[i];
    const auto value = [&]() -> std::string_view {
      if (i + 1 >= argc)
        throw UsageError(std::string(option) + ": a value expected");
      return argv[++i];
    };
    if (option == "--help" || option == "-h") {
      o.command = Command::help;
      return o;
    } else if (option == "--shape") {
      const auto v = value();
      o.kind = choice(option, v, workload::kind_from_name(v), "hex, tet, wedge, pyramid or mixed");
    } else if (option == "--cells") {
      o.cells = number<std::int64_t>(option, value(), 1, 200'000'000);
    } else if (option == "--jitter") {
      o.jitter = number<double>(option, value(), 0.0, 0.5);
    } else if (option == "--mesh") {
      o.mesh_file = value();
    } else if (option == "--renumber") {
      o.renumber = true;
    } else if (option == "--queries") {
      const auto v = value();
      o.pattern =
          choice(option, v, workload::pattern_from_name(v), "uniform, random, sorted or march");
    } else if (option == "--points") {
      o.points = number<std::int64_t>(option, value(), 1, 1'000'000'000);
    } else if (option == "--threads") {
      o.threads = number<int>(option, value(), 0, 4096);
    } else if (option == "--accuracy") {
      const auto v = value();
      const auto accuracy = v == "standard" ? std::optional(INSITU_STANDARD)
                            : v == "exact"  ? std::optional(INSITU_EXACT)
                                            : std::nullopt;
      o.accuracy = choice(option, v, accuracy, "standard or exact");
    } else if (option == "--repetitions") {
      o.repetitions = number<int>(option, value(), 1, 1000);
    } else if (option == "--json") {
      o.json_file = value();
    } else if (option == "--peers") {
      o.peers = true;
    } else {
      throw UsageError("'" + std::string(option) + "' is no option; see insitu-bench --help");
    }
  }
  return o;
}

const char* help_text() {
  return R"(insitu-bench commit|locate [options]

Times libinsitu on the standard workload and checks its answers.
  commit   building and refitting the acceleration structure, cold and warm
  locate   point queries, with Newton's parametric coordinates, and sampling of one field

The mesh
  --shape hex|tet|wedge|pyramid|mixed   cells of the unit box [hex]
  --cells N         the box with the number of cells nearest to N [1000000]
  --jitter J        interior vertices move by up to J of a cell, 0 to 0.5 [0.2]
  --mesh FILE.vtu   a mesh from a file instead (where built with VTK)
  --renumber        cells and vertices in random order
The queries
  --queries uniform|random|sorted|march [uniform]
                    every cell's centre in cell order | random cells, random points |
                    these in Morton order | along view rays, half a cell apart
  --points Q        how many, but for uniform [as many as cells]
  --accuracy standard|exact [standard]
The run
  --threads T       0: all that the process may use [1]
  --repetitions R   medians of R repetitions [5]
  --peers           also the peers of VTK, on one thread, interleaved with ours
  --json FILE       writes the figures; - for standard output, instead of the table

Figures
  build_s      rebuild in Morton order into warm buffers
  refit_s      boxes fitted to moved vertices
  mqps         million points a second, located: cell and parametric coordinates
  mqps_sample  the same, located and one vertex field interpolated
  bytes        the tree; bytes_peak: with the builder's scratch
  lost         points that no cell claimed
  wrong        points answered by a cell that does not hold them, by exact arithmetic
  max_error    largest |sampled - exact| of the field x + 2 y + 3 z
Exit code: 0; 1 if the run failed; 2 if the arguments cannot be used.
)";
}

} // namespace insitu::bench
