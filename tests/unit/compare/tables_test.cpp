#include <gtest/gtest.h>

#include "compare/table_compare.h"
#include "core/status.h"

namespace {

using namespace insitu::compare;
using insitu::core::Error;

Verdict compare(const std::string& a, const std::string& b, const TableOptions& options = {}) {
  return compare_tables(parse_csv(a, "a.csv"), parse_csv(b, "b.csv"), options);
}

TableOptions within(double relative, double absolute) {
  TableOptions options;
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

#define EXPECT_SAYS(verdict, part)                                                                 \
  EXPECT_NE(text_of(verdict).find(part), std::string::npos) << text_of(verdict)

TEST(ParseCsv, QuotesBlankLinesAndHeaders) {
  const Table table =
      parse_csv("name,\"a,b\"\r\n\"say \"\"x\"\"\",\"two\nlines\"\r\n\r\ny,\n", "t");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"name", "a,b"}));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"say \"x\"", "two\nlines"}));
  EXPECT_EQ(table.rows[1], (std::vector<std::string>{"y", ""}));
  EXPECT_EQ(table.lines[0], 2u);
  EXPECT_EQ(table.lines[1], 5u);
  const Table plain = parse_csv("1,2\n3,4", "t"); // no header, no last line end
  EXPECT_EQ(plain.columns, (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(plain.rows.size(), 2u);
  EXPECT_EQ(parse_csv("v\n1\n\n2\n", "t").rows.size(),
            3u); // one column: an empty line is a missing value
  const Table blanks = parse_csv("a , b\n x,\" y \" \r\n", "t");
  EXPECT_EQ(blanks.columns, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(blanks.rows[0], (std::vector<std::string>{"x", " y "}));
}

TEST(ParseCsv, BrokenTablesAreNamed) {
  try {
    (void)parse_csv("a,b\n1,2\n3\n", "gauges.csv");
    FAIL() << "parsed";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "'gauges.csv' line 3: 2 cells expected, 1 found");
  }
  EXPECT_THROW((void)parse_csv("a\n\"open", "t"), Error);
  EXPECT_THROW((void)parse_csv("a\n\"one\" two\n", "t"), Error);
  EXPECT_THROW((void)parse_csv("", "t"), Error);
}

TEST(Tables, ToleranceIsRelativePlusAbsolute) {
  const std::string a = "p\n100\n", b = "p\n101\n";
  EXPECT_FALSE(compare(a, b).same);
  EXPECT_TRUE(compare(a, b, within(0.01, 0)).same);
  EXPECT_FALSE(compare(a, b, within(0.0099, 0)).same);
  EXPECT_TRUE(compare(a, b, within(0, 1)).same);
  EXPECT_FALSE(compare(a, b, within(0, 0.99)).same);
  EXPECT_TRUE(compare(a, b, within(0.005, 0.5)).same);
  EXPECT_TRUE(compare("p\n1.50\n", "p\n1.5\n").same); // numbers, not their texts
  EXPECT_TRUE(compare("p\n1e400\n", "p\ninf\n").same);
}

TEST(Tables, ColumnsHaveTheirOwn) {
  TableOptions options;
  options.columns = {{"q", {0.1, 0}}};
  EXPECT_TRUE(compare("p,q\n1,10\n", "p,q\n1,11\n", options).same);
  const Verdict verdict = compare("p,q\n1,10\n", "p,q\n1.1,11\n", options);
  EXPECT_FALSE(verdict.same);
  EXPECT_SAYS(verdict, "'p'");
  options.ignored = {"p"};
  EXPECT_TRUE(compare("p,q\n1,10\n", "p,q\n1.1,11\n", options).same);
  options.ignored = {"pp"};
  EXPECT_THROW(compare("p,q\n1,2\n", "p,q\n1,2\n", options), Error);
  options.lenient = true;
  EXPECT_TRUE(compare("p,q\n1,2\n", "p,q\n1,2\n", options).same);
}

TEST(Tables, MissingValuesEqualEachOtherOnly) {
  EXPECT_TRUE(compare("p,q\n,1\n", "p,q\nnan,1\n").same);
  EXPECT_TRUE(compare("p,q\nNaN,1\n", "p,q\nnan,1\n").same);
  EXPECT_FALSE(compare("p,q\n,1\n", "p,q\n0,1\n", within(1, 1e9)).same);
  EXPECT_FALSE(compare("p\ninf\n", "p\n-inf\n", within(1, 1e9)).same);
  EXPECT_FALSE(compare("p\ninf\n", "p\n1e9\n", within(1, 1e9)).same);
}

TEST(Tables, TheWorstRowIsNamed) {
  const Verdict verdict =
      compare("cycle,p\n0,1\n1,2\n2,4\n3,8\n", "cycle,p\n0,1\n1,2.1\n2,4.5\n3,8.2\n");
  EXPECT_FALSE(verdict.same);
  EXPECT_SAYS(verdict, "column 'p' moved in 3 of 4 rows");
  EXPECT_SAYS(verdict, "row 3 (line 4): 4 -> 4.5 (by 0.5, relative 0.111)");
  // With a relative tolerance, the row furthest beyond it: 2 -> 2.3 is more for its size.
  const Verdict relative = compare("p\n2\n8\n", "p\n2.3\n8.5\n", within(0.01, 0));
  EXPECT_SAYS(relative, "row 1 (line 2)");
}

TEST(Tables, TextIsComparedAsText) {
  const Verdict verdict =
      compare("end,n\nleft,1\nalive,2\n", "end,n\nleft,1\nexpired,2\n", within(1, 1));
  EXPECT_FALSE(verdict.same);
  EXPECT_SAYS(verdict, "'alive' -> 'expired'");
  EXPECT_FALSE(compare("p\nx\n", "p\n1\n", within(1, 1e9)).same);
}

TEST(Tables, MissingRowsAndColumnsAreNamed) {
  const Verdict verdict = compare("a,b\n1,2\n3,4\n5,6\n", "b,c\n2,0\n4,0\n");
  EXPECT_FALSE(verdict.same);
  EXPECT_SAYS(verdict, "column 'a' is missing in the second table");
  EXPECT_SAYS(verdict, "column 'c' is missing in the first table");
  EXPECT_SAYS(verdict, "row 3 (line 4) is missing in the second table");
  EXPECT_TRUE(compare("a,b\n1,2\n", "b,a\n2,1\n").same); // by name, not by place
}

TEST(Tables, RowsByKey) {
  TableOptions options;
  options.keys = {"cycle", "id"};
  EXPECT_TRUE(
      compare("cycle,id,x\n0,a,1\n0,b,2\n1,a,3\n", "cycle,id,x\n1,a,3\n0,b,2\n0,a,1\n", options)
          .same);
  const Verdict verdict =
      compare("cycle,id,x\n0,a,1\n0,b,2\n", "cycle,id,x\n0,b,2.5\n7,c,9\n", options);
  EXPECT_SAYS(verdict, "cycle 0, id a (line 2) is missing in the second table");
  EXPECT_SAYS(verdict, "cycle 7, id c (line 3) is missing in the first table");
  EXPECT_SAYS(verdict, "moved in 1 of 1 row, most in cycle 0, id b");
  EXPECT_THROW(compare("cycle,id\n0,a\n0,a\n", "cycle,id\n0,a\n", options), Error);
  options.keys = {"step"};
  EXPECT_THROW(compare("cycle\n0\n", "cycle\n0\n", options), Error);
}

} // namespace
