#include "options.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <sstream>

namespace insitu_replay {

const char* const help_text =
    R"(usage: insitu-replay [--scene SCENE.yaml | --probe POINTS.csv] [options] FILE...

Runs a scene over mesh files as if they were the steps of a running simulation: the same probes,
tracers and frames, in the same files.

FILE is a file that VTK reads, its suffix in small or capital letters:
  .vtu (tetrahedra, voxels, hexahedra, wedges, pyramids, polyhedra), .vts, .vtr, .vti; .pvtu,
  .pvts, .pvtr, .pvti of such; legacy .vtk; .vtm (multi-block): its blocks are the pieces of the
  mesh
  .vthb or .vth (vtkOverlappingAMR), .htg (vtkHyperTreeGrid of three dimensions and branch factor
  2): adaptive meshes with cell arrays, one file a step
  .pvd or .series (ParaView's JSON): an index of any of these, in the order of time; the parts of a
  step in a .pvd are the pieces of the mesh
  .hdf: a record of a run (insitu_session_record, or 'record:' in its scene), with its meshes, and
  its scene unless another is given; or VTKHDF of other programs
  a folder of OpenFOAM (or a .foam file in it; decomposed ones too), .exo, .e, .ex2, .g (Exodus),
  .cgns, .nc (CF and UGRID conventions): all steps of a run, as far as VTK here has their readers
Or it is a folder of dumps of Catalyst's calls (CATALYST_DATA_DUMP_DIRECTORY), or such dumps with
their schemas beside them: the run is then done again, with one process in the place of all, with
the run's own scene or another (--scene, --out, --threads, --strict); --check and --plan look at
the first call, --validate at all.
Each is one step, in the order given, if it does not hold several; records go by their times.
Triangles, lines and the like beside cells of volume are left out, as are blocks of them; parts
without cells add nothing; of several parts, arrays that one of them lacks are left out. Each of
these is said once.

  --scene FILE     the scene
  --probe FILE     no scene: all fields at the points of a CSV file (columns x,y,z), in probe.csv
                   (with neither: the default scene, the first scalar field as a volume)
  --out DIR        output folder; overrides the scene's
  --mesh NAME      what the scene calls the mesh (default: mesh)
  --frame FRAME    what the files' points are: cartesian (the default), geocentric, or 'geodetic
                   [radians] [kilometres] [depth]' for longitude, latitude and height (or depth);
                   the default of netCDF in degrees of longitude and latitude is geodetic
  --pieces HOW     joined (the default): vertices of different pieces that coincide are one for
                   averages and smooth normals; or separate: each piece stands for itself
  --blank [FIELD=]VALUE
                   where the field (or any) has this value it has none: samples are NaN, surfaces
                   and volumes leave these cells out, tracers take them as walls; may be given
                   again; nan is a value. The field data _FillValue and missing_value, or FIELD.
                   before these, say the same
  --reverse        the last step first: time goes back, and with it tracers of 'direction: backward'
  --hold K         hold the last K steps, with copies of their arrays and their trees
  --order LIST     the steps in this order, by their places, from 0 on: '0-9,8-0' goes there and
                   back. A step that comes again must be held, and is neither read nor built again:
                   probes, streamlines and frames are done once more, by the next free cycle
                   number, and tracers of particles go on with steps that come first
  --threads N      at most N threads (default: all that the process may use)
  --strict         refuse arrays that would have to be converted, such as integer fields
  --plan           print what the scene needs for the first step, what it does without and why,
                   with bytes; run nothing
  --check          a dry run, of the first step: print the meshes with their fields, what the scene
                   would write and when, memory, and every item that could not be done, with the
                   nearest name for one that is not there; write nothing. Exit code 3 if there is
                   such an item, 1 if the scene has keys that are none
  --preview        draw every frame of the scene, whatever its trigger, of the last step alone, and
                   nothing else, for a look: images keep their aspect and fit into 160 x 120 pixels
                   (1024 x 1024 becomes 120 x 120), with one sample a pixel, or at most 16 paths of
                   a path traced volume; they lie in the folder preview of the output folder
  --validate       check the meshes, print what was found, run nothing
  --summary FILE   write times, memory and counts as JSON at the end
  --version
  --help

The cycle is the field data CYCLE of a file, or else its place in the order given, from 0; where a
number comes again, steps are counted on from there, and this is said. The time is the index's, or
else the field data TimeValue or TIME, or else the cycle. A mesh that keeps its
cells from one file to the next is refitted, not rebuilt.

Exit code: 0 done; 1 a file, mesh or scene is bad, and nothing after it was done; 2 wrong usage;
3 done, but a probe, tracer or frame failed and was skipped.
)";

namespace {

insitu::Frame read_frame(const std::string& text) {
  std::istringstream words(text);
  std::string kind, word;
  words >> kind;
  insitu::Angle angle = insitu::Angle::degrees;
  insitu::Length length = insitu::Length::metres;
  insitu::Vertical vertical = insitu::Vertical::up;
  bool known = kind == "cartesian" || kind == "geocentric" || kind == "geodetic";
  while (words >> word) {
    if (word == "radians")
      angle = insitu::Angle::radians;
    else if (word == "kilometres")
      length = insitu::Length::kilometres;
    else if (word == "depth")
      vertical = insitu::Vertical::down;
    else
      known = false;
    known = known && kind == "geodetic";
  }
  if (!known)
    throw UsageError("--frame: '" + text +
                     "': cartesian, geocentric or 'geodetic [radians] "
                     "[kilometres] [depth]' expected");
  return kind == "geodetic"     ? insitu::Frame::geodetic(vertical, angle, length)
         : kind == "geocentric" ? insitu::Frame::geocentric()
                                : insitu::Frame::cartesian();
}

ReplayOptions::Blank read_blank(const std::string& text) {
  ReplayOptions::Blank blank;
  const auto equals = text.rfind('=');
  if (equals != std::string::npos)
    blank.field = text.substr(0, equals);
  const std::string number = equals == std::string::npos ? text : text.substr(equals + 1);
  const auto [end, error] =
      std::from_chars(number.data(), number.data() + number.size(), blank.value);
  if (number.empty() || error != std::errc() || end != number.data() + number.size())
    throw UsageError("--blank: '" + text + "': [FIELD=]VALUE expected");
  return blank;
}

/// Reads a number from 0 on; of_key: for messages.
template <class Number>
Number read_number(const std::string& text, const std::string& of_key) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < Number())
    throw UsageError(of_key);
  return number;
}

/// "2,0-3,1" is 2, 0, 1, 2, 3, 1.
std::vector<std::size_t> read_order(const std::string& text) {
  const std::string expected = "--order: '" + text + "': places of steps, such as 0-9,8-0 expected";
  constexpr std::size_t most = 10'000'000;
  std::vector<std::size_t> order;
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    const auto dash = item.find('-');
    const auto first = read_number<std::size_t>(item.substr(0, dash), expected);
    const std::size_t last = dash == std::string::npos
                                 ? first
                                 : read_number<std::size_t>(item.substr(dash + 1), expected);
    if (std::max(first, last) >= most || order.size() >= most)
      throw UsageError(expected);
    for (std::size_t place = first; place != last; first < last ? ++place : --place)
      order.push_back(place);
    order.push_back(last);
  }
  if (order.empty() || text.back() == ',')
    throw UsageError(expected);
  return order;
}

} // namespace

ReplayOptions parse_arguments(int argc, char** argv) {
  static const std::map<std::string, bool ReplayOptions::*> switches = {
      {"--help", &ReplayOptions::help},       {"-h", &ReplayOptions::help},
      {"--version", &ReplayOptions::version}, {"--strict", &ReplayOptions::strict},
      {"--plan", &ReplayOptions::plan},       {"--validate", &ReplayOptions::validate},
      {"--check", &ReplayOptions::check},     {"--reverse", &ReplayOptions::reverse},
      {"--preview", &ReplayOptions::preview}};
  static const std::map<std::string, std::string ReplayOptions::*> texts = {
      {"--scene", &ReplayOptions::scene},
      {"--probe", &ReplayOptions::probe},
      {"--out", &ReplayOptions::out},
      {"--mesh", &ReplayOptions::mesh},
      {"--summary", &ReplayOptions::summary}};
  ReplayOptions o;
  bool only_files = false;
  for (int i = 1; i < argc; ++i) {
    std::string key = argv[i];
    if (only_files || key.size() < 2 || key[0] != '-') {
      o.files.push_back(key);
      continue;
    }
    if (key == "--") {
      only_files = true;
      continue;
    }
    std::optional<std::string> value;
    if (const auto equals = key.find('='); equals != std::string::npos) {
      value = key.substr(equals + 1);
      key.resize(equals);
    }
    if (const auto found = switches.find(key); found != switches.end()) {
      if (value)
        throw UsageError(key + ": takes no value");
      o.*found->second = true;
      continue;
    }
    const auto take = [&]() -> const std::string& {
      if (!value && i + 1 >= argc)
        throw UsageError(key + ": a value is missing");
      if (!value)
        value = argv[++i];
      if (value->empty())
        throw UsageError(key + ": the value is empty");
      return *value;
    };
    if (const auto found = texts.find(key); found != texts.end()) {
      o.*found->second = take();
    } else if (key == "--pieces") {
      if (take() != "joined" && *value != "separate")
        throw UsageError("--pieces: '" + *value + "': joined or separate expected");
      o.separate_pieces = *value == "separate";
    } else if (key == "--blank") {
      o.blanks.push_back(read_blank(take()));
    } else if (key == "--frame") {
      o.frame = read_frame(take());
      o.has_frame = true;
    } else if (key == "--threads") {
      const std::string& text = take();
      o.threads = read_number<int>(text, "--threads: '" + text + "' is not a number of threads");
    } else if (key == "--hold") {
      const std::string& text = take();
      o.hold = read_number<int>(text, "--hold: '" + text + "' is not a number of steps");
    } else if (key == "--order") {
      o.order = read_order(take());
    } else {
      throw UsageError(key + ": unknown option");
    }
  }
  if (o.help || o.version)
    return o;
  if (o.files.empty())
    throw UsageError("no mesh files given");
  if (o.plan + o.validate + o.check > 1)
    throw UsageError("--plan, --validate and --check: give one of them");
  if (o.preview)
    for (const auto& [other, key] : {std::pair{o.plan, "--plan"},
                                     {o.validate, "--validate"},
                                     {o.check, "--check"},
                                     {o.reverse, "--reverse"},
                                     {!o.probe.empty(), "--probe"}})
      if (other)
        throw UsageError(std::string("--preview and ") + key + ": give one of both");
  if (!o.order.empty())
    for (const auto& [other, key] : {std::pair{o.plan, "--plan"},
                                     {o.validate, "--validate"},
                                     {o.check, "--check"},
                                     {o.preview, "--preview"},
                                     {o.reverse, "--reverse"}})
      if (other)
        throw UsageError(std::string("--order and ") + key + ": give one of both");
  if (!o.scene.empty() && !o.probe.empty())
    throw UsageError("--scene and --probe: give one of both");
  return o;
}

std::vector<std::size_t> places_of(const ReplayOptions& options, std::size_t steps) {
  for (const std::size_t place : options.order)
    if (place >= steps)
      throw UsageError("--order: step " + std::to_string(place) + " of " + std::to_string(steps) +
                       ", which count from 0");
  if (!options.order.empty())
    return options.order;
  std::vector<std::size_t> all;
  for (std::size_t i = options.preview ? steps - 1 : 0; i < steps; ++i)
    all.push_back(options.reverse ? steps - 1 - i : i);
  return all;
}

} // namespace insitu_replay
