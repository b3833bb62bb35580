// What reaches the parser of YAML before any key is looked at.
#include <algorithm>
#include <gtest/gtest.h>
#include <sstream>

#include "scene_test.h"

using namespace insitu::scene;
using test::error_of;
using test::error_of_text;

TEST(Document, EmptyTexts) {
  for (const char* text : {"", "\n\n", "# a comment\n", "---\n", "~", "\xEF\xBB\xBF"}) {
    EXPECT_EQ(error_of_text(text), "s.yaml: the scene is empty; it begins with 'insitu: 1'")
        << text;
  }
}

TEST(Document, OtherThanAMap) {
  EXPECT_EQ(error_of_text("hello").find("s.yaml:1: a map of insitu, output,"), 0u);
  EXPECT_NE(error_of_text("[1, 2]").find("expected, a list of 2 found"), std::string::npos);
}

TEST(Document, MarksAndLineEndsOfEditors) {
  EXPECT_NO_THROW(parse_scene_text("\xEF\xBB\xBFinsitu: 1\r\nevery: 3\r\n", "s.yaml"));
  EXPECT_EQ(error_of_text("\xEF\xBB\xBFinsitu: 1\r\neverry: 3\r\n").find("s.yaml:2: key 'everry'"),
            0u);
}

TEST(Document, TabsAndBinary) {
  EXPECT_EQ(error_of("probes:\n\t- name: a\n"),
            "s.yaml:3: the indentation has a tab; YAML takes spaces only");
  EXPECT_EQ(error_of(std::string("a\0b", 3)),
            "s.yaml:2: byte 0 found; the scene must be text in UTF-8");
  EXPECT_NE(error_of_text(std::string("\xFF\xFEi\0n\0", 6)).find("UTF-8"), std::string::npos);
}

TEST(Document, BrokenSyntaxHasALine) {
  EXPECT_EQ(error_of("probes: [{name: a\n").find("s.yaml:"), 0u);
  EXPECT_EQ(error_of("probes: [a, b\nevery: 3\n").find("s.yaml:3: not valid YAML"), 0u);
  EXPECT_EQ(error_of("locator: {method: bvh\n").find("s.yaml:"), 0u);
  EXPECT_EQ(error_of("output: %x\n").find("s.yaml:2: not valid YAML"), 0u);
}

TEST(Document, QuotationsMustEnd) {
  for (const char* text : {"output: 'abc\n", "output: \"abc", "output: 'abc''"}) {
    EXPECT_EQ(error_of(text).find("s.yaml:"), 0u) << text << error_of(text);
  }
  EXPECT_EQ(error_of("output: 'abc"),
            "s.yaml:2: not valid YAML: the text ends within a quotation, list or map");
}

TEST(Document, MarkerOfTheEndIsAllowed) {
  EXPECT_NO_THROW(parse_scene_text("%YAML 1.2\n---\ninsitu: 1\n...\n", "s.yaml"));
  EXPECT_NO_THROW(parse_scene_text("insitu: 1\n...\n# the end\n", "s.yaml"));
  EXPECT_NO_THROW(parse_scene_text("insitu: 1\noutput: |\n  text", "s.yaml"));
}

TEST(Document, SecondDocument) {
  EXPECT_EQ(error_of("---\ninsitu: 1\n"),
            "s.yaml:3: a second document begins here; a scene is one document");
}

TEST(Document, RepeatedKeys) {
  EXPECT_EQ(error_of("every: 2\noutput: o\nevery: 3\n"),
            "s.yaml:4: key 'every' is given twice in the scene (first in line 2)");
  EXPECT_EQ(error_of("frames:\n- name: f\n  volume: {field: a, field: b}\n"),
            "s.yaml:4: key 'field' is given twice in frames[0].volume (first in line 4)");
}

TEST(Document, Tags) {
  EXPECT_NE(error_of("every: !!int 3").find("the tag 'tag:yaml.org,2002:int' is not supported"),
            std::string::npos);
}

TEST(Document, KeysAreTexts) {
  EXPECT_NE(error_of("[a, b]: 1").find("s.yaml:2: a list or map stands where a key should"),
            std::string::npos);
  EXPECT_NE(error_of("? {a: b}\n: 1").find("a list or map stands where a key should"),
            std::string::npos);
  EXPECT_NE(error_of(": 1").find("s.yaml:2: "), std::string::npos);
  EXPECT_NE(error_of("<<: {every: 3}").find("merge keys"), std::string::npos);
}

TEST(Document, DepthIsLimited) {
  const auto nested = [](int levels, const std::string& open, const std::string& close) {
    std::string text;
    for (int i = 0; i < 2 * levels; ++i) {
      text += i < levels ? open : close;
    }
    return error_of("output: " + text);
  };
  for (const auto& [open, close] : {std::pair("[", "]"), std::pair("{a: ", "}")}) {
    EXPECT_NE(nested(23, open, close).find("a text expected"), std::string::npos);
    EXPECT_NE(nested(24, open, close).find("more than 24 lists and maps within each other"),
              std::string::npos);
    EXPECT_EQ(nested(100000, open, close).find("s.yaml:2: "), 0u);
    EXPECT_EQ(nested(100000, open, "").find("s.yaml:2: "), 0u);
  }
  std::string text;
  for (int i = 0; i < 100000; ++i) {
    text += "- ";
  }
  EXPECT_NE(error_of("output:\n " + text).find("s.yaml:3: "), std::string::npos);
}

TEST(Document, SizeIsLimited) {
  EXPECT_NE(error_of("# " + std::string(1 << 20, 'x')).find("more than 1048576"),
            std::string::npos);
}

TEST(Document, AliasesWork) {
  const auto scene =
      test::parse("probes:\n- {name: a, points: &p [[1, 2, 3]]}\n- {name: b, points: *p}\n");
  EXPECT_EQ(std::get<PointList>(scene.probes[1].points).points[0].z, 3);
}

TEST(Document, AliasesDoNotExpandWithoutEnd) {
  std::string text = "a: &a0 [x]\n";
  for (int i = 1; i < 24; ++i) {
    std::ostringstream line;
    line << "k" << i << ": &a" << i << " [*a" << i - 1 << ", *a" << i - 1 << ", *a" << i - 1
         << "]\n";
    text += line.str();
  }
  EXPECT_NE(error_of(text).find("the aliases expand to more than 1048576 values"),
            std::string::npos);
  EXPECT_EQ(error_of("probes: &a [*a]"), "s.yaml:2: an alias refers to a node that contains it");
  EXPECT_NE(error_of("probes: *nowhere").find("s.yaml:2: not valid YAML"), std::string::npos);
}

TEST(Document, AllProblemsAreReportedTogetherUpToTwenty) {
  EXPECT_EQ(error_of("every: 0\nprobes: 3\noutput: []\n"),
            "s.yaml:2: every: an integer from 1 to 1000000000 expected, '0' found\n"
            "s.yaml:3: probes: a list expected, '3' found\n"
            "s.yaml:4: output: a text expected, a list of 0 found");
  std::string text;
  for (int i = 0; i < 50; ++i) {
    text += "wrong" + std::to_string(i) + ": 1\n";
  }
  const std::string message = error_of(text);
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 20);
  EXPECT_NE(message.find("s.yaml:21: key 'wrong19'"), std::string::npos);
  EXPECT_EQ(message.find("'wrong20'"), std::string::npos);
  EXPECT_NE(message.find("\ns.yaml: and 30 more"), std::string::npos);
}

TEST(Document, QuotedTextsInMessagesAreShortAndPrintable) {
  const std::string message = error_of("every: \"" + std::string(5000, 'x') + "\\e[31m\"");
  EXPECT_LT(message.size(), 200u);
  EXPECT_EQ(message.find('\x1B'), std::string::npos);
}
