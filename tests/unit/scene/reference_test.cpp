// doc/scene.md is the reference of the keys: it must have a row for each key that the reader knows,
// and no other, and in each section an example that the reader takes. Scenes of the guides are held
// to that too.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "scene_test.h"

using namespace insitu::scene;

namespace {

/// The keys in the first column of each section's table.
std::map<std::string, std::set<std::string>> documented() {
  std::ifstream file(INSITU_PAGES "/scene.md");
  std::map<std::string, std::set<std::string>> keys;
  std::string line, section;
  while (std::getline(file, line)) {
    if (line.rfind("## ", 0) == 0) {
      section = line.substr(3);
    } else if (line.rfind("| `", 0) == 0) {
      keys[section].insert(line.substr(3, line.find('`', 3) - 3));
    }
  }
  return keys;
}

/// A block of YAML in a page: a scene, or keys of one.
struct Example {
  std::string section, text;
  int line = 0; ///< of the page, from 1
};

std::vector<Example> examples_of(const std::filesystem::path& page) {
  std::ifstream file(page);
  std::vector<Example> examples;
  std::string line, section;
  bool inside = false;
  for (int number = 1; std::getline(file, line); ++number) {
    if (inside && line == "```")
      inside = false;
    else if (inside)
      examples.back().text += line + '\n';
    else if (line.rfind("## ", 0) == 0)
      section = line.substr(3);
    else if (line == "```yaml") {
      inside = true;
      examples.push_back({section, "", number});
    }
  }
  return examples;
}

/// The keys that the reader lists when it finds one that it does not know.
std::set<std::string> known(const std::string& scene) {
  const std::string message = test::error_of(scene);
  const std::size_t begin = message.find("(keys: ");
  std::set<std::string> keys;
  if (begin == std::string::npos) {
    return keys;
  }
  std::istringstream list(message.substr(begin + 7, message.find(')', begin) - begin - 7));
  for (std::string key; std::getline(list >> std::ws, key, ',');) {
    keys.insert(key);
  }
  return keys;
}

} // namespace

TEST(SceneReference, HasEveryKeyOfEverySection) {
  const std::map<std::string, std::string> scenes = {
      {"The scene", "zzz: 1"},
      {"checkpoint", "checkpoint: {zzz: 1}"},
      {"record", "record: {zzz: 1}"},
      {"hold", "hold: {zzz: 1}"},
      {"locator", "locator: {zzz: 1}"},
      {"probes", "probes: [{zzz: 1}]"},
      {"Points and seeds", "probes: [{points: {zzz: 1}}]"},
      {"line, transect", "probes: [{points: {line: {zzz: 1}}}]"},
      {"curtain", "probes: [{points: {curtain: {zzz: 1}}}]"},
      {"levels", "probes: [{points: {curtain: {levels: {zzz: 1}}}}]"},
      {"plane", "probes: [{points: {plane: {zzz: 1}}}]"},
      {"grid, box", "probes: [{points: {grid: {zzz: 1}}}]"},
      {"sphere", "probes: [{points: {sphere: {zzz: 1}}}]"},
      {"frame", "probes: [{frame: {zzz: 1}}]"},
      {"tracers", "tracers: [{zzz: 1}]"},
      {"integrator", "tracers: [{integrator: {zzz: 1}}]"},
      {"until", "tracers: [{until: {zzz: 1}}]"},
      {"settling", "tracers: [{effects: [{settling: {zzz: 1}}]}]"},
      {"windage", "tracers: [{effects: [{windage: {zzz: 1}}]}]"},
      {"diffusion", "tracers: [{effects: [{diffusion: {zzz: 1}}]}]"},
      {"inertia", "tracers: [{effects: [{inertia: {zzz: 1}}]}]"},
      {"coriolis", "tracers: [{effects: [{coriolis: {zzz: 1}}]}]"},
      {"boundary of particles", "tracers: [{effects: [{boundary: {zzz: 1}}]}]"},
      {"remove", "tracers: [{effects: [{remove: {zzz: 1}}]}]"},
      {"release", "tracers: [{release: {zzz: 1}}]"},
      {"spacing", "tracers: [{spacing: {zzz: 1}}]"},
      {"times", "tracers: [{times: {zzz: 1}}]"},
      {"seeds of a probe", "tracers: [{seeds: {probe: a, zzz: 1}}]"},
      {"frames", "frames: [{zzz: 1}]"},
      {"meshes", "frames: [{meshes: [{zzz: 1}]}]"},
      {"scalar_bar", "frames: [{scalar_bar: {zzz: 1}}]"},
      {"background", "frames: [{background: {zzz: 1}}]"},
      {"camera", "frames: [{camera: {zzz: 1}}]"},
      {"path", "frames: [{camera: {path: [{zzz: 1}]}}]"},
      {"geocentric", "frames: [{geocentric: {zzz: 1}}]"},
      {"look_at", "frames: [{geocentric: {}, camera: {look_at: {zzz: 1}}}]"},
      {"orbit", "frames: [{camera: {orbit: {zzz: 1}}}]"},
      {"volume", "frames: [{volume: {zzz: 1}}]"},
      {"path_tracing", "frames: [{path_tracing: {zzz: 1}}]"},
      {"isosurfaces", "frames: [{isosurfaces: [{zzz: 1}]}]"},
      {"lights", "frames: [{lights: [{zzz: 1}]}]"},
      {"clip", "frames: [{clip: [{zzz: 1}]}]"},
      {"plane of a clip", "frames: [{clip: [{plane: {zzz: 1}}]}]"},
      {"box of a clip", "frames: [{clip: [{box: {zzz: 1}}]}]"},
      {"sphere of a clip", "frames: [{clip: [{sphere: {zzz: 1}}]}]"},
      {"ambient_occlusion", "frames: [{effects: [{ambient_occlusion: {zzz: 1}}]}]"},
      {"boundary", "frames: [{boundary: {zzz: 1}}]"},
      {"bodies", "frames: [{bodies: [{zzz: 1}]}]"},
      {"outline", "frames: [{outline: {zzz: 1}}]"},
      {"color", "frames: [{isosurfaces: [{color: {zzz: 1}}]}]"}};
  const auto sections = documented();
  for (const auto& [section, scene] : scenes) {
    const auto found = sections.find(section);
    ASSERT_NE(found, sections.end()) << section;
    const auto expected = known(scene);
    EXPECT_FALSE(expected.empty()) << section;
    EXPECT_EQ(found->second, expected) << section;
  }
  EXPECT_EQ(sections.size(), scenes.size());
}

TEST(SceneReference, HasAnExampleOfEverySection) {
  std::map<std::string, std::string> text_of;
  for (const Example& example : examples_of(INSITU_PAGES "/scene.md"))
    text_of[example.section] += example.text;
  for (const auto& [section, keys] : documented())
    EXPECT_TRUE(std::any_of(keys.begin(), keys.end(),
                            [&](const std::string& key) {
                              return text_of[section].find(key + ":") != std::string::npos;
                            }))
        << "no example of section '" << section << "' has one of its keys";
}

TEST(SceneReference, ExamplesAreTaken) {
  std::vector<std::filesystem::path> pages = {INSITU_PAGES "/scene.md"};
  for (const auto& entry : std::filesystem::directory_iterator(INSITU_PAGES "/guide"))
    pages.push_back(entry.path());
  for (const auto& page : pages)
    for (const Example& example : examples_of(page)) {
      const std::string version = example.text.rfind("insitu:", 0) == 0 ? "" : "insitu: 1\n";
      EXPECT_EQ(test::error_of_text(version + example.text), "no error")
          << page << ", line " << example.line;
    }
}
