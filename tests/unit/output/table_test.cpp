#include <cmath>
#include <csignal>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/status.h"
#include "output/files/csv.h"
#include "unit/output/folder.h"

namespace {

using insitu::core::Error;
using insitu::output::append_number;
using insitu::output::append_text;
using insitu::output::AppendTable;
using insitu::output::CsvRows;
using test::content;
using test::Folder;
using test::put;

template <class T>
std::string number(T value) {
  std::string text;
  append_number(text, value);
  return text;
}

TEST(Csv, NumbersAreShortestAndReadBack) {
  EXPECT_EQ(number(0.1), "0.1");
  EXPECT_EQ(number(0.1f), "0.1");
  EXPECT_EQ(number(-0.0), "-0");
  EXPECT_EQ(number(1e300), "1e+300");
  EXPECT_EQ(number(5e-324), "5e-324");
  EXPECT_EQ(number(std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_EQ(number(-std::numeric_limits<double>::infinity()), "-inf");
  EXPECT_EQ(number(std::numeric_limits<std::int64_t>::min()), "-9223372036854775808");
  std::mt19937_64 random(3);
  for (int i = 0; i < 100000; ++i) {
    const std::uint64_t bits = random();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) {
      ASSERT_EQ(std::strtod(number(value).c_str(), nullptr), value);
    }
  }
}

TEST(Csv, TextIsQuotedWhereNeeded) {
  std::string text;
  for (const char* value : {"plain", "a,b", "say \"x\"", "two\nlines", " blank"}) {
    append_text(text, value);
    text += '|';
  }
  EXPECT_EQ(text, "plain|\"a,b\"|\"say \"\"x\"\"\"|\"two lines\"|\" blank\"|");
}

TEST(Csv, RowsOfWrongLengthAreRefusedAndDropped) {
  CsvRows rows(2);
  rows.cell(1).cell(2.5).end_row();
  rows.cell(1);
  EXPECT_THROW(rows.end_row(), Error);
  rows.cell("x").cell(std::nan(""));
  EXPECT_EQ(rows.text(), "1,2.5\n"); // a row that was not ended is not there yet
  rows.end_row();
  EXPECT_EQ(rows.text(), "1,2.5\nx,\n");
}

TEST(Csv, WholeTable) {
  const Folder folder;
  CsvRows rows(1);
  rows.cell(3).end_row();
  write_csv(folder / "t.csv", {"n"}, rows);
  EXPECT_EQ(content(folder / "t.csv"), "n\n3\n");
}

TEST(AppendTable, GrowsOverRestartsWithOneHeader) {
  const Folder folder;
  const std::string path = folder / "probes/gauges.csv";
  for (int run = 0; run < 3; ++run) {
    AppendTable table(path, {"cycle", "pressure"});
    table.rows().cell(run).cell(run * 0.5).end_row();
    if (run == 1) {
      table.flush(); // else the destructor does
    }
  }
  EXPECT_EQ(content(path), "cycle,pressure\n0,0\n1,0.5\n2,1\n");
}

TEST(AppendTable, CutsWhatAKillLeft) {
  const Folder folder;
  const std::string path = folder / "t.csv";
  const std::string long_tail(10000, '7'); // longer than a block of the backwards search
  struct Case {
    std::string before, after;
  };
  for (const Case& c :
       {Case{"a,b\n1,2\n3", "a,b\n1,2\n"}, Case{"a,b\n1,2\n" + long_tail, "a,b\n1,2\n"},
        Case{"a,", "a,b\n"}, Case{"", "a,b\n"}, Case{"a,b\n1,2\n", "a,b\n1,2\n"}}) {
    put(path, c.before);
    {
      AppendTable table(path, {"a", "b"});
      EXPECT_EQ(content(path), c.after);
      table.rows().cell(8).cell(9).end_row();
    }
    EXPECT_EQ(content(path), c.after + "8,9\n");
  }
}

TEST(AppendTable, OtherColumnsAreRefusedAndKept) {
  const Folder folder;
  put(folder / "t.csv", "a,c\n1,2\n");
  try {
    AppendTable table(folder / "t.csv", {"a", "b"});
    FAIL() << "opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), INSITU_ERROR_FILE);
    EXPECT_NE(std::string(error.what()).find("'a,c', not 'a,b'"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(content(folder / "t.csv"), "a,c\n1,2\n");
}

TEST(AppendTable, OneWriterAtATime) {
  const Folder folder;
  AppendTable table(folder / "t.csv", {"a"});
  EXPECT_THROW(AppendTable(folder / "t.csv", {"a"}), Error);
}

TEST(AppendTable, FullDiskTakesThePartialRowsBack) {
  const Folder folder;
  const std::string path = folder / "t.csv";
  AppendTable table(path, {"a"});
  for (int i = 0; i < 1000; ++i) {
    table.rows().cell(1000 + i).end_row();
  }
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  struct rlimit small = before;
  small.rlim_cur = 2004; // in the middle of a row
  void (*const handler)(int) = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(table.flush(), Error);
  EXPECT_EQ(content(path), "a\n");
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  table.flush(); // space again: all rows, once
  const std::string text = content(path);
  EXPECT_EQ(text.size(), 2 + 1000 * 5u);
  EXPECT_TRUE(text.starts_with("a\n1000\n1001\n"));
  EXPECT_TRUE(text.ends_with("1998\n1999\n"));
}

TEST(AppendTable, KilledWriterLeavesWholeRows) {
  const Folder folder;
  const std::string path = folder / "t.csv";
  const std::string column(300, 'c');
  for (int round = 0; round < 5; ++round) {
    const pid_t pid = ::fork();
    ASSERT_GE(pid, 0);
    if (pid == 0) {
      AppendTable table(path, {"a", "b"});
      for (int i = 0;; ++i) {
        table.rows().cell(i).cell(column).end_row();
        if (i % 50 == 0) {
          table.flush();
        }
      }
    }
    ::usleep(20000);
    ::kill(pid, SIGKILL);
    ASSERT_EQ(::waitpid(pid, nullptr, 0), pid);
  }
  { const AppendTable table(path, {"a", "b"}); } // cuts, should the last kill have split a row
  std::ifstream in(path);
  std::string line;
  std::size_t lines = 0;
  ASSERT_TRUE(std::getline(in, line));
  EXPECT_EQ(line, "a,b");
  while (std::getline(in, line)) {
    ++lines;
    ASSERT_TRUE(line.ends_with("," + column)) << line;
    ASSERT_LE(line.size(), column.size() + 9) << line;
  }
  EXPECT_GT(lines, 0u);
  EXPECT_EQ(content(path).back(), '\n');
}

} // namespace
