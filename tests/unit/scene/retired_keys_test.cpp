// Keys that got another name go on for one version, with a warning. None is retired now, so the
// table is the test's.
#include <gtest/gtest.h>

#include "scene_test.h"

namespace insitu::scene::test {
namespace {

constexpr RetiredKey retired[] = {{"", "folder", "output", "9.9"},
                                  {"probes", "variables", "fields", "9.9"},
                                  {"frames.volume", "variable", "field", "9.9"}};

SceneDescription read(const std::string& rest) {
  return parse_scene_text("insitu: 1\n" + rest, "s.yaml", {}, retired);
}

TEST(RetiredKeys, WorkWithAWarningThatNamesTheNewOne) {
  const SceneDescription scene = read("folder: there\n"
                                      "probes:\n"
                                      "  - {name: a, points: [[0, 0, 0]], fields: [p]}\n"
                                      "  - {name: b, points: [[0, 0, 0]], variables: [q]}\n"
                                      "frames: [{name: f, volume: {variable: rho}}]\n");
  EXPECT_EQ(scene.output, "there");
  ASSERT_EQ(scene.probes.size(), 2u);
  ASSERT_EQ(scene.probes[1].fields.size(), 1u);
  EXPECT_EQ(scene.probes[1].fields[0].text, "q");
  ASSERT_EQ(scene.warnings.size(), 3u);
  EXPECT_EQ(scene.warnings[0], "s.yaml:2: key 'folder' in the scene is called 'output' now; "
                               "version 9.9 will not know the old name");
  EXPECT_EQ(scene.warnings[1], "s.yaml:5: key 'variables' in probes[1] is called 'fields' now; "
                               "version 9.9 will not know the old name");
  EXPECT_EQ(scene.warnings[2].find("s.yaml:6: key 'variable' in frames[0].volume is called"), 0u);
}

TEST(RetiredKeys, OfOtherMapsAreUnknownAndBothNamesAreTwoOfOne) {
  EXPECT_NE(error_of_call([] { read("variables: 1"); }).find("key 'variables' is unknown"),
            std::string::npos);
  const std::string both = error_of_call([] { read("folder: a\noutput: b"); });
  EXPECT_NE(both.find("given twice"), std::string::npos) << both;
  EXPECT_NE(error_of("folder: a").find("key 'folder' is unknown"), std::string::npos);
}

TEST(RetiredKeys, TodaysScenesWarnOfNothing) {
  EXPECT_TRUE(parse(probe("fields: [p]")).warnings.empty());
  EXPECT_TRUE(retired_keys().empty());
}

} // namespace
} // namespace insitu::scene::test
