#include <gtest/gtest.h>

#include "compare/json_compare.h"
#include "core/status.h"

namespace {

using namespace insitu::compare;
using insitu::core::Error;

Verdict compare(const std::string& a, const std::string& b, const JsonOptions& options = {}) {
  return compare_json(a, "a.json", b, "b.json", options);
}

JsonOptions within(double relative, double absolute) {
  JsonOptions options;
  options.tolerance = {relative, absolute};
  return options;
}

std::string text_of(const Verdict& verdict) {
  std::string text;
  for (const std::string& line : verdict.lines) {
    text += line + "\n";
  }
  return text;
}

TEST(Json, OrderOfKeysAndLayoutDoNotMatter) {
  EXPECT_TRUE(compare("{\"a\": 1, \"b\": [true, null, \"x\"]}",
                      "{\n\t\"b\":[true,null,\"x\"],\n\t\"a\":\t1.0\n}\n")
                  .same);
  EXPECT_FALSE(compare("[1, 2]", "[2, 1]").same);
}

TEST(Json, NumbersByTolerancePathsNamed) {
  const std::string a = "{\"steps\": [{\"time\": 0.5, \"n\": 3}, {\"time\": 1.0, \"n\": 4}]}";
  const std::string b = "{\"steps\": [{\"time\": 0.5, \"n\": 3}, {\"time\": 1.1, \"n\": 4}]}";
  const Verdict verdict = compare(a, b);
  EXPECT_FALSE(verdict.same);
  EXPECT_NE(text_of(verdict).find("steps[1].time: 1 -> 1.1 (by 0.1"), std::string::npos)
      << text_of(verdict);
  EXPECT_TRUE(compare(a, b, within(0.1, 0)).same);
  JsonOptions options;
  options.keys = {{"time", {0, 0.2}}};
  EXPECT_TRUE(compare(a, b, options).same);
  options.keys = {{"steps[1].time", {0, 0.01}}, {"time", {0, 0.2}}};
  EXPECT_FALSE(compare(a, b, options).same) << "the whole path goes before the key";
  options.keys.clear();
  options.ignored = {"time"};
  EXPECT_TRUE(compare(a, b, options).same);
  options.ignored = {"steps"};
  EXPECT_TRUE(compare(a, b, options).same);
}

TEST(Json, KindsAreNotMixed) {
  EXPECT_FALSE(compare("{\"a\": 1}", "{\"a\": \"1\"}", within(1, 1)).same);
  EXPECT_FALSE(compare("{\"a\": null}", "{\"a\": 0}", within(1, 1)).same);
  EXPECT_FALSE(compare("{\"a\": true}", "{\"a\": false}", within(1, 1)).same);
  EXPECT_FALSE(compare("{\"a\": []}", "{\"a\": {}}").same);
  EXPECT_FALSE(compare("{\"a\": \"\"}", "{\"a\": null}").same);
  EXPECT_TRUE(compare("{\"a\": NaN}", "{\"a\": null}").same);
  EXPECT_TRUE(compare("{\"a\": \"tab\\there \\u00e9\"}", "{\"a\": \"tab\\there \u00e9\"}").same);
}

TEST(Json, MissingValuesAreNamed) {
  const Verdict verdict = compare("{\"a\": 1, \"b\": {\"c\": 2}}", "{\"a\": 1, \"d\": [\"e\"]}");
  EXPECT_FALSE(verdict.same);
  EXPECT_NE(text_of(verdict).find("b.c: 2 is missing in the second file"), std::string::npos);
  EXPECT_NE(text_of(verdict).find("d[0]: \"e\" is missing in the first file"), std::string::npos);
}

TEST(Json, LongListsAreCutShort) {
  std::string a = "[", b = "[";
  for (int i = 0; i < 100; ++i) {
    a += (i > 0 ? "," : "") + std::to_string(i + 1);
    b += (i > 0 ? "," : "") + std::to_string(i == 60 ? 1000 : i + 2);
  }
  const Verdict verdict = compare(a + "]", b + "]");
  EXPECT_LT(verdict.lines.size(), 25u);
  EXPECT_NE(text_of(verdict).find("80 more values"), std::string::npos) << text_of(verdict);
  EXPECT_NE(text_of(verdict).find("[60] moved most"), std::string::npos) << text_of(verdict);
}

TEST(Json, UnreadableTextIsNamed) {
  try {
    compare("{\"a\": 1}", "{\"a\": 1,\n\"b\": [1, 2}\n");
    FAIL() << "read";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), INSITU_ERROR_FILE);
    EXPECT_NE(std::string(error.what()).find("'b.json' line 2"), std::string::npos) << error.what();
  }
  EXPECT_THROW(compare("", "{}"), Error);
  EXPECT_THROW(compare("42", "42"), Error);
}

} // namespace
