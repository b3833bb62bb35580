#include "options.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "accel/locator.h"

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

std::vector<std::int64_t> numbers(std::string_view option, std::string_view list,
                                  std::int64_t lowest, std::int64_t highest) {
  std::vector<std::int64_t> values;
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t comma = std::min(list.find(',', at), list.size());
    values.push_back(number<std::int64_t>(option, list.substr(at, comma - at), lowest, highest));
    at = comma + 1;
  }
  return values;
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

const char* name(Command command) {
  constexpr const char* names[] = {"help", "commit",  "locate", "torture",  "scale", "methods",
                                   "amr",  "effects", "render", "accuracy", "paper", "advect"};
  return names[int(command)];
}

Options parse(int argc, char** argv) {
  Options o;
  const std::string commands =
      "commit, locate, torture, scale, methods, amr, effects, render, accuracy, paper or advect";
  if (argc < 2)
    throw UsageError("a command expected: " + commands);
  const std::string_view command = argv[1];
  if (command == "--help" || command == "-h" || command == "help")
    return o;
  for (const Command c : {Command::commit, Command::locate, Command::torture, Command::scale,
                          Command::methods, Command::amr, Command::effects, Command::render,
                          Command::accuracy, Command::paper, Command::advect})
    if (command == name(c))
      o.command = c;
  if (o.command == Command::help)
    throw UsageError("'" + std::string(command) + "' is no command: " + commands + " expected");
  if (o.command == Command::methods || o.command == Command::amr || o.command == Command::effects ||
      o.command == Command::render || o.command == Command::accuracy ||
      o.command == Command::paper || o.command == Command::advect)
    o.repetitions = 3;
  if (o.command == Command::advect)
    o.cells = {64 * 64 * 64};
  if (o.command == Command::amr)
    o.cells = {4'018'176};
  if (o.command == Command::scale) {
    o.cells = {10'000, 30'000, 100'000, 300'000, 1'000'000, 3'000'000, 10'000'000, 30'000'000};
    o.repetitions = 3;
  }

  int first = 2;
  if (o.command == Command::paper) {
    o.paper = argc > 2 ? argv[first++] : "";
    if (o.paper == "--help" || o.paper == "-h")
      return Options();
    if (o.paper != "morrical" && o.paper != "rathke" && o.paper != "zellmann")
      throw UsageError("paper: morrical, rathke or zellmann expected, '" + o.paper + "' given");
    o.size = 256;
  }
  for (int i = first; i < argc; ++i) {
    const std::string_view option = argv[i];
    const auto value = [&]() -> std::string_view {
      if (i + 1 >= argc)
        throw UsageError(std::string(option) + ": a value expected");
      return argv[++i];
    };
    /// A value of one of these commands' options.
    const auto only = [&](Command a, Command b, Command c = Command::help) {
      if (o.command != a && o.command != b && o.command != c)
        throw UsageError(std::string(option) + ": not an option of " + name(o.command));
    };
    if (option == "--help" || option == "-h") {
      o.command = Command::help;
      return o;
    } else if (option == "--shape") {
      const auto v = value();
      o.kind = choice(option, v, workload::kind_from_name(v), "hex, tet, wedge, pyramid or mixed");
      o.kind_given = true;
    } else if (option == "--kind") {
      const auto v = value();
      o.spacing =
          choice(option, v, workload::spacing_from_name(v), "even, graded, layers or sparse");
    } else if (option == "--cells") {
      o.cells = numbers(option, value(), 1, 200'000'000);
    } else if (option == "--jitter") {
      o.jitter = number<double>(option, value(), 0.0, 0.5);
    } else if (option == "--mesh") {
      only(Command::commit, Command::locate);
      o.mesh_file = value();
    } else if (option == "--numbering") {
      const auto v = value();
      o.shuffled = choice(option, v,
                          v == "shuffled"  ? std::optional(true)
                          : v == "natural" ? std::optional(false)
                                           : std::nullopt,
                          "natural or shuffled");
    } else if (option == "--queries") {
      only(Command::locate, Command::locate);
      const auto v = value();
      o.pattern = choice(option, v, workload::pattern_from_name(v),
                         "uniform, random, sorted, march, vertices, edges or faces");
    } else if (option == "--points") {
      if (o.command != Command::methods && o.command != Command::amr &&
          o.command != Command::advect)
        only(Command::locate, Command::torture);
      o.points = number<std::int64_t>(option, value(), 1, 1'000'000'000);
    } else if (option == "--check") {
      only(Command::methods, Command::methods);
      o.check = true;
    } else if (option == "--sizes") {
      only(Command::amr, Command::amr);
      o.sizes = true;
    } else if (option == "--backend") {
      only(Command::methods, Command::methods);
      const auto v = value();
      o.backends.push_back(choice(
          option, v,
          v == "cpu" || v == "cuda" || v == "optix" ? std::optional(std::string(v)) : std::nullopt,
          "cpu, cuda or optix"));
    } else if (option == "--method") {
      only(Command::methods, Command::methods);
      const auto v = value();
      std::optional<std::string> known;
      for (int m = 0; m < accel::method_count; ++m)
        if (v == accel::name(accel::Method(m)))
          known = v;
      o.methods.push_back(choice(option, v, known,
                                 "bvh, user_geometry, replicated_faces, shared_faces or "
                                 "shared_bilinear_faces"));
    } else if (option == "--fields") {
      only(Command::locate, Command::locate);
      o.fields = number<int>(option, value(), 1, 100);
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
    } else if (option == "--csv") {
      only(Command::scale, Command::scale);
      o.csv_file = value();
    } else if (option == "--svg") {
      only(Command::scale, Command::scale);
      o.svg_file = value();
    } else if (option == "--size") {
      only(Command::render, Command::paper);
      o.size = number<int>(option, value(), 1, 16384);
    } else if (option == "--out") {
      only(Command::render, Command::accuracy, Command::paper);
      o.out_folder = value();
    } else if (option == "--quick" || option == "--full") {
      only(Command::accuracy, Command::paper);
      o.full = option == "--full";
      o.quick = option == "--quick";
    } else if (option == "--sweep") {
      only(Command::accuracy, Command::accuracy);
      o.sweeps.emplace_back(value());
    } else if (option == "--peers") {
      o.peers = true;
    } else if (option == "--peer-points") {
      only(Command::locate, Command::locate);
      o.peer_points = number<std::int64_t>(option, value(), 1, 1'000'000'000);
    } else if (option == "--peer") {
      o.peers = true;
      o.peer_names.emplace_back(value());
    } else {
      throw UsageError("'" + std::string(option) + "' is no option; see insitu-bench --help");
    }
  }
  if (o.command == Command::paper && o.full && !o.cells.empty())
    throw UsageError("--full: takes as many cells as the memory holds; without --cells");
  if (o.cells.empty())
    o.cells = {o.command != Command::paper ? 1'000'000 : o.quick ? 6'000 : 300'000};
  if (o.cells.size() > 1 && o.command != Command::scale)
    throw UsageError("--cells: a list is for scale only");
  return o;
}

} // namespace insitu::bench
