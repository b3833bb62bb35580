#include "check.h"

#include <fstream>
#include <iostream>
#include <iterator>
#include <set>
#include <sstream>
#include <yaml-cpp/yaml.h>

namespace insitu_replay {

namespace {

constexpr const char* not_done = "  skipped  all of it";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    lines.push_back(line);
  return lines;
}

/// When an item is due, in words.
std::string trigger_of(const YAML::Node& item, const YAML::Node& scene) {
  std::string out;
  for (const char* key : {"every", "when"}) {
    const YAML::Node own = item[key] ? item[key] : scene[key];
    if (own && own.IsScalar())
      out += (out.empty() ? "" : ", ") + std::string(key) + " " + own.as<std::string>();
  }
  return out.empty() ? "every cycle" : out;
}

/// The words of a list, or the default.
std::vector<std::string> words_of(const YAML::Node& list, const char* otherwise) {
  std::vector<std::string> out;
  if (list && list.IsSequence())
    for (const YAML::Node& word : list)
      if (word.IsScalar())
        out.push_back(word.as<std::string>());
  return out.empty() ? std::vector<std::string>{otherwise} : out;
}

void add_tables(const YAML::Node& scene, const char* kind, const std::string& folder,
                std::string& out) {
  const YAML::Node items = scene[kind];
  if (!items || !items.IsSequence())
    return;
  for (const YAML::Node& item : items) {
    if (!item.IsMap() || !item["name"])
      continue;
    const auto name = item["name"].as<std::string>();
    for (const std::string& format : words_of(item["output"], "csv")) {
      const bool a_cycle = format == "vtp" || format == "json";
      out += "  " + folder + "/" + name + (a_cycle ? "_*." : ".") +
             (format == "netcdf" ? "nc" : format) + " (" + trigger_of(item, scene) + ")\n";
    }
  }
}

void add_frames(const YAML::Node& scene, const std::string& folder, std::string& out) {
  const YAML::Node frames = scene["frames"];
  if (!frames || !frames.IsSequence())
    return;
  for (const YAML::Node& frame : frames)
    if (frame.IsMap() && frame["name"])
      out += "  " + folder + "/" + frame["name"].as<std::string>() + "_*." +
             (frame["format"] && frame["format"].IsScalar() ? frame["format"].as<std::string>()
                                                            : std::string("png")) +
             " (" + trigger_of(frame, scene) + ")\n";
}

/// A mesh's cells and vertices, and each field.
std::string describe(const std::string& name, insitu::Mesh mesh) {
  const insitu::CommitReport report = mesh.commit();
  std::string out = "mesh '" + name + "': " + std::to_string(report.cells) + " cells, " +
                    std::to_string(report.vertices) + " vertices\n";
  std::set<std::string> known;
  for (const insitu::AuditEntry& entry : mesh.audit()) {
    const std::string text = entry.name; // "piece 0 field 'pressure'"
    const std::size_t begin = text.find(" field '"), end = text.rfind('\'');
    if (begin == std::string::npos || end <= begin + 8)
      continue;
    const std::string field = text.substr(begin + 8, end - begin - 8);
    if (!known.insert(field).second)
      continue;
    const insitu::FieldInfo info = mesh.field_info(field);
    out += "  field '" + field + "' on " +
           (info.association == insitu::Association::cell ? "cells" : "vertices") + ", " +
           std::to_string(info.components) +
           (info.components == 1 ? " component\n" : " components\n");
  }
  return out + (known.empty() ? "  no fields\n" : "");
}

/// The files that a scene asks for, a line each, with when they are written; empty for a text that
/// is none. given: a folder in the place of the scene's.
std::string outputs_of(const std::string& scene_text, const std::string& given) {
  std::string out;
  try {
    const YAML::Node scene = YAML::Load(scene_text);
    if (!scene.IsMap())
      return out;
    const std::string folder = !given.empty() ? given
                               : scene["output"] && scene["output"].IsScalar()
                                   ? scene["output"].as<std::string>()
                                   : std::string("out");
    add_tables(scene, "probes", folder, out);
    add_tables(scene, "tracers", folder, out);
    add_frames(scene, folder, out);
    for (const auto& [key, file] :
         {std::pair{"checkpoint", "/checkpoint_*.insitu"}, {"record", "/record_*.hdf"}})
      if (const YAML::Node one = scene[key]; one && one.IsMap())
        out += "  " + folder + file + " (" + trigger_of(one, one) + ")\n";
  } catch (const YAML::Exception&) { // the session says what is wrong
    return {};
  }
  return out;
}

/// The lines of a plan that say why an item cannot be done: "probe 'gauges' ...: reason".
std::vector<std::string> problems_of(const std::string& plan) {
  std::vector<std::string> out;
  std::string item;
  for (const std::string& line : lines_of(plan)) {
    if (!line.starts_with(' '))
      item = line;
    if (!line.starts_with(not_done))
      continue;
    const std::size_t reason = line.find_first_not_of(' ', std::string(not_done).size());
    out.push_back(item + ": " + (reason == std::string::npos ? "not done" : line.substr(reason)));
  }
  return out;
}

/// A plan's last line, which sums memory up.
std::string memory_of(const std::string& plan) {
  const std::vector<std::string> lines = lines_of(plan);
  return lines.empty() ? std::string() : lines.back();
}

} // namespace

std::vector<std::string> check_run(insitu::Session& session, const NamedMeshes& meshes,
                                   std::size_t steps, const std::string& scene_text,
                                   const std::string& folder) {
  for (const auto& [name, mesh] : meshes)
    std::cout << describe(name, mesh);
  std::cout << plural(std::int64_t(steps), "step") << "\n";
  const std::string plan = session.plan();
  if (const std::string outputs = outputs_of(scene_text, folder); !outputs.empty())
    std::cout << "would write\n" << outputs;
  std::cout << memory_of(plan) << "\n";
  return problems_of(plan);
}

bool validate_meshes(const NamedMeshes& meshes, const std::string& file) {
  bool well = true;
  for (const auto& [name, mesh] : meshes) {
    const insitu::Validation v = insitu::Mesh(mesh).validate();
    const insitu_validation& c = v.counts;
    std::cout << file << ": " << (v.accepted ? "accepted" : "refused") << ", "
              << plural(c.cells, "cell") << ", " << c.ghost_cells << " ghost, " << c.inverted_cells
              << " inverted, " << c.zero_volume_cells << " of zero volume, " << c.folded_cells
              << " folded, " << c.collapsed_cells << " collapsed; " << c.coincident_vertices
              << " vertices coincide, " << c.crowded_faces << " faces of more than two cells, "
              << c.split_faces << " quads against other faces, " << c.hanging_vertices
              << " vertices on faces or edges of other cells, " << c.covered_vertices
              << " inside other cells\n";
    if (!v.accepted)
      std::cout << v.findings << "\n";
    well = well && v.accepted;
  }
  return well;
}

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string plural(std::int64_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

} // namespace insitu_replay
