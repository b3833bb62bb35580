// What processes send each other is what doc/design/scale.md says, on small meshes.
#include <gtest/gtest.h>

#include "program.h"

using insitu::test::number;
using insitu::test::Outcome;
using insitu::test::run;

namespace {

TEST(BenchScaling, BytesAreThoseOfTheModel) {
  const std::string arguments = "scaling --processes 1,4 --cells 13824 --points 64000 --size 128 "
                                "--repetitions 1 --json -";
  const Outcome r = run(arguments);
  if (!INSITU_BENCH_HAS_MPI) {
    EXPECT_EQ(r.exit_code, 2);
    return;
  }
  ASSERT_EQ(r.exit_code, 0) << r.out;
  int rows = 0, halos = 0;
  for (std::size_t at = r.out.find("\"name\""); at != std::string::npos; ++rows) {
    const std::size_t next = r.out.find("\"name\"", at + 1);
    const std::string row = r.out.substr(at, next - at);
    const std::size_t counted = row.find("\"counted\""), model = row.find("\"model\"");
    ASSERT_NE(model, std::string::npos) << row;
    const double bytes = number(row, "bytes", counted), expected = number(row, "bytes", model);
    // A tenth: the page says what it leaves out.
    EXPECT_NEAR(bytes, expected, 0.1 * expected) << row;
    const bool is_alone = number(row, "processes") == 1;
    EXPECT_TRUE(!is_alone || number(row, "messages", counted) == 0) << row;
    if (row.find("halo_cells") != std::string::npos) {
      EXPECT_EQ(number(row, "halo_cells"), number(row, "halo_cells_model")) << row;
      halos += number(row, "halo_cells") > 0;
    }
    EXPECT_GT(number(row, "work_s"), 0) << row;
    EXPECT_GE(number(row, "imbalance"), 0.999) << row;
    at = next;
  }
  EXPECT_EQ(rows, 2 * 2 * 11); // processes, strong and weak, pieces of work
  EXPECT_EQ(halos, 4);         // cells and leaves, strong and weak
}

} // namespace
