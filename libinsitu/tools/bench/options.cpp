#include "options.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <optional>
#include <string_view>
#include <type_traits>

#include "accel/locator.h"

namespace insitu::bench {

namespace {

constexpr const char* commands =
    "commit, locate, torture, scale, methods, amr, effects, render, accuracy, paper, advect, "
    "scaling or sections";

/// An argument: the option's name and the text of its value.
struct Argument {
  std::string_view option, text = {};

  template <class T>
  T number(T lowest, T highest) const {
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

  std::vector<std::int64_t> numbers(std::int64_t lowest, std::int64_t highest) const {
    std::vector<std::int64_t> values;
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t comma = std::min(text.find(',', at), text.size());
      values.push_back(Argument{option, text.substr(at, comma - at)}.number(lowest, highest));
      at = comma + 1;
    }
    return values;
  }

  /// value: what the text stands for, if it is one of these choices.
  template <class T>
  T choice(const std::optional<T>& value, const char* choices) const {
    if (!value)
      throw UsageError(std::string(option) + ": " + choices + " expected, '" + std::string(text) +
                       "' given");
    return *value;
  }
};

using Set = std::function<void(Options&, const Argument&)>;

Set flag(bool Options::*member) {
  return [=](Options& o, const Argument&) { o.*member = true; };
}
Set text(std::string Options::*member) {
  return [=](Options& o, const Argument& a) { o.*member = a.text; };
}
template <class T>
Set number(T Options::*member, std::type_identity_t<T> lowest, std::type_identity_t<T> highest) {
  return [=](Options& o, const Argument& a) { o.*member = a.number(lowest, highest); };
}
/// value: what a text stands for, if it is one of these choices.
template <class T>
Set choice(T Options::*member, std::optional<T> (*value)(std::string_view), const char* choices) {
  return [=](Options& o, const Argument& a) { o.*member = a.choice(value(a.text), choices); };
}

std::optional<bool> is_shuffled(std::string_view name) {
  return name == "shuffled"  ? std::optional(true)
         : name == "natural" ? std::optional(false)
                             : std::nullopt;
}
std::optional<insitu_accuracy> accuracy_from_name(std::string_view name) {
  return name == "standard" ? std::optional(INSITU_STANDARD)
         : name == "exact"  ? std::optional(INSITU_EXACT)
                            : std::nullopt;
}

void set_shape(Options& o, const Argument& a) {
  o.kind = a.choice(workload::kind_from_name(a.text),
                    "hex, tet, wedge, pyramid, mixed, poly or hexfaces");
  o.kind_given = true;
}
void add_backend(Options& o, const Argument& a) {
  const bool known = a.text == "cpu" || a.text == "cuda" || a.text == "optix";
  o.backends.push_back(
      a.choice(known ? std::optional(std::string(a.text)) : std::nullopt, "cpu, cuda or optix"));
}
void add_method(Options& o, const Argument& a) {
  std::optional<std::string> known;
  for (int m = 0; m < accel::method_count; ++m)
    if (a.text == accel::name(accel::Method(m)))
      known = a.text;
  o.methods.push_back(a.choice(known, "bvh, user_geometry, replicated_faces, shared_faces or "
                                      "shared_bilinear_faces"));
}
void add_peer(Options& o, const Argument& a) {
  o.peers = true;
  o.peer_names.emplace_back(a.text);
}
void set_extent(Options& o, const Argument& a) {
  o.full = a.option == "--full";
  o.quick = a.option == "--quick";
}

/// An option, the commands that have it (none: all) and what it sets.
struct Option {
  std::string_view name;
  std::vector<Command> commands;
  Set set;
  bool has_value = true;
};

using C = Command;

const Option options[] = {
    {"--shape", {}, set_shape},
    {"--kind",
     {},
     choice(&Options::spacing, workload::spacing_from_name, "even, graded, layers or sparse")},
    {"--cells", {}, [](Options& o, const Argument& a) { o.cells = a.numbers(1, 200'000'000); }},
    {"--jitter", {}, number(&Options::jitter, 0.0, 0.5)},
    {"--mesh", {C::commit, C::locate}, text(&Options::mesh_file)},
    {"--numbering", {}, choice(&Options::shuffled, is_shuffled, "natural or shuffled")},
    {"--queries",
     {C::locate},
     choice(&Options::pattern, workload::pattern_from_name,
            "uniform, random, sorted, march, vertices, edges or faces")},
    {"--points",
     {C::locate, C::torture, C::methods, C::amr, C::advect, C::scaling, C::sections},
     number(&Options::points, 1, 1'000'000'000)},
    {"--check", {C::methods}, flag(&Options::check), false},
    {"--sizes", {C::amr}, flag(&Options::sizes), false},
    {"--backend", {C::methods}, add_backend},
    {"--method", {C::methods}, add_method},
    {"--fields", {C::locate}, number(&Options::fields, 1, 100)},
    {"--threads", {}, number(&Options::threads, 0, 4096)},
    {"--accuracy", {}, choice(&Options::accuracy, accuracy_from_name, "standard or exact")},
    {"--repetitions", {}, number(&Options::repetitions, 1, 1000)},
    {"--json", {}, text(&Options::json_file)},
    {"--csv", {C::scale}, text(&Options::csv_file)},
    {"--svg", {C::scale}, text(&Options::svg_file)},
    {"--processes",
     {C::scaling},
     [](Options& o, const Argument& a) { o.processes = a.numbers(1, 4096); }},
    {"--size", {C::render, C::paper, C::scaling, C::sections}, number(&Options::size, 1, 16384)},
    {"--out", {C::render, C::accuracy, C::paper}, text(&Options::out_folder)},
    {"--quick", {C::accuracy, C::paper}, set_extent, false},
    {"--full", {C::accuracy, C::paper}, set_extent, false},
    {"--table", {C::paper}, number(&Options::table, 1, 4)},
    {"--sweep",
     {C::accuracy},
     [](Options& o, const Argument& a) { o.sweeps.emplace_back(a.text); }},
    {"--peers", {}, flag(&Options::peers), false},
    {"--peer-points", {C::locate}, number(&Options::peer_points, 1, 1'000'000'000)},
    {"--peer", {}, add_peer},
};

const Option& option_of(std::string_view name) {
  for (const Option& option : options)
    if (option.name == name)
      return option;
  throw UsageError("'" + std::string(name) + "' is no option; see insitu-bench --help");
}

Command command_of(std::string_view text) {
  for (int c = int(C::help) + 1; c <= int(C::sections); ++c)
    if (text == name(C(c)))
      return C(c);
  throw UsageError("'" + std::string(text) + "' is no command: " + commands + " expected");
}

/// What a command does without options.
void set_defaults(Options& o) {
  switch (o.command) {
  case C::advect:
    o.cells = {64 * 64 * 64};
    break;
  case C::amr:
    o.cells = {4'018'176};
    break;
  case C::scale:
    o.cells = {10'000, 30'000, 100'000, 300'000, 1'000'000, 3'000'000, 10'000'000, 30'000'000};
    break;
  case C::paper:
    o.size = 256;
    break;
  case C::scaling:
    o.points = 400'000;
    break;
  default:
    break;
  }
  if (o.command != C::commit && o.command != C::locate && o.command != C::torture)
    o.repetitions = 3;
}

bool asks_for_help(std::string_view text) {
  return text == "--help" || text == "-h";
}

} // namespace

const char* name(Command command) {
  constexpr const char* names[] = {"help",    "commit", "locate",  "torture", "scale",
                                   "methods", "amr",    "effects", "render",  "accuracy",
                                   "paper",   "advect", "scaling", "sections"};
  return names[int(command)];
}

Options parse(int argc, char** argv) {
  if (argc < 2)
    throw UsageError("a command expected: " + std::string(commands));
  if (asks_for_help(argv[1]) || argv[1] == std::string_view("help"))
    return {};
  Options o;
  o.command = command_of(argv[1]);
  o.arguments.assign(argv + 1, argv + argc);
  set_defaults(o);
  int next = 2;
  if (o.command == C::paper) {
    o.paper = argc > 2 ? argv[next++] : "";
    if (asks_for_help(o.paper))
      return {};
    if (o.paper != "morrical" && o.paper != "rathke" && o.paper != "zellmann")
      throw UsageError("paper: morrical, rathke or zellmann expected, '" + o.paper + "' given");
  }
  while (next < argc) {
    const std::string_view given = argv[next++];
    if (asks_for_help(given)) {
      o.command = C::help;
      return o;
    }
    const Option& option = option_of(given);
    if (!option.commands.empty() && std::ranges::count(option.commands, o.command) == 0)
      throw UsageError(std::string(given) + ": not an option of " + name(o.command));
    if (option.has_value && next == argc)
      throw UsageError(std::string(given) + ": a value expected");
    option.set(o, {given, option.has_value ? argv[next++] : ""});
  }
  if (o.command == C::paper && o.full && !o.cells.empty())
    throw UsageError("--full: takes as many cells as the memory holds; without --cells");
  if (o.table > 0 && o.paper != "rathke")
    throw UsageError("--table: for paper rathke only");
  if (o.cells.empty())
    o.cells = {o.command != C::paper ? 1'000'000 : o.quick ? 6'000 : 300'000};
  if (o.cells.size() > 1 && o.command != C::scale)
    throw UsageError("--cells: a list is for scale only");
  return o;
}

} // namespace insitu::bench
