// The page of a run: texts that try to break out of a script, numbers that JSON lacks, restarts,
// partial lines, second writers, files of others.
#include <gtest/gtest.h>
#include <limits>
#include <yaml-cpp/yaml.h>

#include "core/status.h"
#include "folder.h"
#include "output/files/json_text.h"
#include "output/page/run_page.h"

namespace {

using namespace insitu;
using output::JsonText;
using output::RunPage;

std::string json(std::string_view text) {
  return JsonText().value(text).text();
}

std::string entry(std::int64_t cycle, const std::string& text = "") {
  JsonText j;
  return j.open('{').key("cycle").value(cycle).key("text").value(text).close().text();
}

const std::string header = "var insitu = []; // written by libinsitu for index.html, an entry a "
                           "line\n";

std::string lines(std::initializer_list<std::int64_t> cycles) {
  std::string text = header;
  for (const std::int64_t c : cycles)
    text += "insitu.push(" + entry(c) + ");\n";
  return text;
}

void write(const test::Folder& folder, std::int64_t from,
           std::initializer_list<std::int64_t> cycles) {
  RunPage page(folder.path(), from);
  for (const std::int64_t c : cycles)
    page.add(entry(c));
}

std::string data(const test::Folder& folder) {
  return test::content(folder / RunPage::data_name);
}

} // namespace

TEST(JsonTexts, StayInTheirQuotes) {
  EXPECT_EQ(json("a\"b\\c\n\r\t\x01 d"), R"("a\"b\\c\n\u000d\u0009\u0001 d")");
  EXPECT_EQ(json("</script><img onerror=alert(1)>&amp;"),
            R"("\u003c/script\u003e\u003cimg onerror=alert(1)\u003e\u0026amp;")");
  EXPECT_EQ(json("\u2028\u2029\u00b0\u65e5"), R"("\u2028\u2029\u00b0\u65e5")");
  EXPECT_EQ(json("\U0001F300"), R"("\ud83c\udf00")");
  EXPECT_EQ(json(std::string_view("a\0b", 3)), R"("a\u0000b")");
  EXPECT_EQ(json(""), "\"\"");
}

// Invalid UTF-8: cut, overlong, surrogates, beyond U+10FFFF, a lone continuation byte.
TEST(JsonTexts, OfBrokenUtf8AreAsciiToo) {
  for (const char* broken : {"\xe2\x82", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\x80",
                             "\xff", "\xe0\x80\xaf"}) {
    const std::string text = json(std::string(broken) + "z");
    EXPECT_TRUE(text.starts_with("\"\\ufffd") && text.ends_with("z\"")) << text;
    for (const char c : text)
      EXPECT_TRUE(c >= 0x20 && c < 0x7f) << text;
  }
}

TEST(JsonTexts, HaveLinesWhereAsked) {
  JsonText j = JsonText::spaced();
  j.open('{').key("a").value(1).key("rows").open('[');
  for (int i = 0; i < 2; ++i)
    j.line().open('[').value(i).value(true).close();
  j.close().key("b").open('{').line().key("c").open('{').line().key("d").value(2);
  j.close().close().close();
  EXPECT_EQ(j.text(), "{\"a\": 1, \"rows\": [\n  [0, true],\n  [1, true]\n], \"b\": {\n  \"c\": "
                      "{\n    \"d\": 2\n  }\n}}");
}

TEST(JsonTexts, NumbersThatJsonLacksAreNull) {
  JsonText j;
  const double infinity = std::numeric_limits<double>::infinity();
  j.open('[').value(std::numeric_limits<double>::quiet_NaN()).value(infinity).value(-infinity);
  j.short_value(std::numeric_limits<double>::quiet_NaN()).short_value(-infinity);
  j.value(0.1).short_value(1.0 / 3).value(1e300).short_value(1e-300).value(-0.0).value(true);
  j.value(std::numeric_limits<std::int64_t>::min()).open('{').close().open('[').close().close();
  EXPECT_EQ(j.text(), "[null,null,null,null,null,0.1,0.3333333,1e+300,1e-300,0,true,"
                      "-9223372036854775808,{},[]]");
}

TEST(RunPages, ThePageIsWholeAndTheDataGrows) {
  const test::Folder folder;
  RunPage page(folder.path(), 0);
  EXPECT_EQ(data(folder), header);
  page.add(entry(3));
  EXPECT_EQ(data(folder), lines({3}));
  page.add(entry(4, "</script>"));
  EXPECT_EQ(data(folder), lines({3}) + "insitu.push(" + entry(4, "</script>") + ");\n");
  EXPECT_EQ(folder.count(), 3u) << "the page, its data, and the lock while it is written";
  const std::string html = test::content(folder / RunPage::page_name);
  EXPECT_TRUE(html.starts_with("<!doctype html>") && html.ends_with("</html>\n"));
  EXPECT_EQ(html.find("/*page"), std::string::npos) << "a part is missing";
  EXPECT_NE(html.find("function showPage"), std::string::npos);
  EXPECT_NE(html.find("prefers-color-scheme: dark"), std::string::npos);
  // Nothing is fetched: the only addresses are that of SVG's namespace, which is a name, and the
  // files beside the page.
  std::size_t found = 0;
  for (std::size_t at = 0; (at = html.find("://", at)) != std::string::npos; at += 3, ++found)
    EXPECT_EQ(html.substr(at - 4, 29), "http://www.w3.org/2000/svg\", ")
        << html.substr(at - 10, 60);
  EXPECT_EQ(found, 1u);
  for (const char* word : {"innerHTML", "insertAdjacentHTML", "document.write", "eval("})
    EXPECT_EQ(html.find(word), std::string::npos) << word << ": texts could become markup";
}

TEST(RunPages, ARestartDropsItsCycleAndLaterOnes) {
  const test::Folder folder;
  write(folder, 0, {0, 10, 20, 30});
  write(folder, 20, {20, 25});
  EXPECT_EQ(data(folder), lines({0, 10, 20, 25}));
  write(folder, 0, {1});
  EXPECT_EQ(data(folder), lines({1}));
  write(folder, -5, {-5});
  EXPECT_EQ(data(folder), lines({-5}));
}

// A kill may come between any two bytes.
TEST(RunPages, CutAtAnyByteTheScriptStillRunsAndTheNextRunMendsIt) {
  const test::Folder folder;
  write(folder, 0, {0, 1});
  const std::string whole = data(folder), unfinished = "//situ.push(" + entry(2) + ");\n";
  for (std::size_t bytes = 0; bytes <= unfinished.size(); ++bytes) {
    test::put(folder / RunPage::data_name, whole + unfinished.substr(0, bytes));
    write(folder, 2, {2});
    ASSERT_EQ(data(folder), lines({0, 1, 2})) << "cut after " << bytes << " bytes";
  }
  for (std::size_t bytes = 0; bytes < header.size(); ++bytes) {
    test::put(folder / RunPage::data_name, header.substr(0, bytes));
    write(folder, 2, {2});
    ASSERT_EQ(data(folder), lines({2})) << "cut after " << bytes << " bytes";
  }
}

TEST(RunPages, OneWriterAtATime) {
  const test::Folder folder;
  RunPage page(folder.path(), 0);
  page.add(entry(0));
  EXPECT_THROW(RunPage(folder.path(), 0), output::BeingWritten);
  EXPECT_EQ(data(folder), lines({0})) << "the second writer changed what the first one wrote";
  page.add(entry(1));
  EXPECT_EQ(data(folder), lines({0, 1}));
}

TEST(RunPages, FilesOfOthersAreLeftAlone) {
  for (const char* name : {RunPage::page_name, RunPage::data_name}) {
    const test::Folder folder;
    const std::string theirs = "const my = 'site'"; // no line end: not to be taken for a cut line
    test::put(folder / name, theirs);
    try {
      RunPage page(folder.path(), 0);
      FAIL() << name << " was taken";
    } catch (const core::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
      EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("page: false"), std::string::npos) << e.what();
    }
    EXPECT_EQ(test::content(folder / name), theirs);
  }
}

TEST(RunPages, EntriesOfAnotherVersionGo) {
  const test::Folder folder;
  test::put(folder / RunPage::data_name,
            "var insitu = {version: 2};\ninsitu.push({\"cycle\":0});\n");
  write(folder, 5, {5});
  EXPECT_EQ(data(folder), lines({5}));
}
