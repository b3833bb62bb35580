#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "core/status.h"
#include "folder.h"
#include "output/files/csv.h"

namespace {

using namespace insitu;

std::string content(const std::string& path) {
  std::ifstream in(path);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

void append(const std::string& path, std::vector<std::string> columns, std::int64_t from,
            std::initializer_list<std::int64_t> cycles) {
  output::AppendTable table(path, columns, from);
  for (const std::int64_t c : cycles) {
    for (std::size_t i = 0; i < columns.size(); ++i)
      table.rows().cell(c);
    table.rows().end_row();
  }
  table.flush();
}

} // namespace

TEST(Restart, RowsOfLaterCyclesGoAndEarlierOnesStay) {
  const test::Folder folder;
  const std::string path = folder / "t.csv";
  append(path, {"cycle", "a"}, 0, {0, 10, 20, 30});
  append(path, {"cycle", "a"}, 20, {20, 25});
  EXPECT_EQ(content(path), "cycle,a\n0,0\n10,10\n20,20\n25,25\n");
  EXPECT_THROW(append(path, {"cycle", "b"}, 21, {}), core::Error); // rows stay that do not fit
  EXPECT_EQ(content(path), "cycle,a\n0,0\n10,10\n20,20\n");
  append(path, {"cycle", "b", "c"}, 0, {0}); // nothing stays: other columns are fine
  EXPECT_EQ(content(path), "cycle,b,c\n0,0,0\n");
}

// Rows that straddle the reader's blocks.
TEST(Restart, LongTablesAreCutAtTheRightRow) {
  const test::Folder folder;
  const std::string path = folder / "t.csv";
  {
    output::AppendTable table(path, {"cycle", "a"});
    for (std::int64_t i = 0; i < 40000; ++i) {
      table.rows().cell(i).cell(i);
      table.rows().end_row();
    }
    table.flush();
  }
  append(path, {"cycle", "a"}, 31234, {});
  const std::string text = content(path);
  EXPECT_TRUE(text.ends_with("\n31233,31233\n"));
}
