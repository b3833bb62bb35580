// Steps that come again, from those that are held.
#include "replay.h"

namespace {

struct Order : Replay {
  void SetUp() override {
    Replay::SetUp();
    for (const int step : {0, 1, 2, 3})
      mesh("m" + std::to_string(step) + ".vtu", 10.0 * step, 10 * step, 0.5 * step);
    put("look.yaml", R"(insitu: 1
page: false
probes: [{name: g, points: points.csv, fields: [linear]}]
frames: [{name: seen, size: [32, 24], volume: {field: linear}}]
)");
  }
  const std::string files = "--scene look.yaml --out out m0.vtu m1.vtu m2.vtu m3.vtu";
};

} // namespace

TEST_F(Order, ThereAndBackReadsAndBuildsNothingAgain) {
  const Outcome o = run("--hold 4 --order 0-3,2-0 --summary sum.json " + files);
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("steps are counted on"), std::string::npos) << o.err;
  const std::vector<Row> table = rows("out/g.csv");
  ASSERT_EQ(table.size(), 21u);
  const int cycles[] = {0, 10, 20, 30, 31, 32, 33}, places[] = {0, 1, 2, 3, 2, 1, 0};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const Row &row = table[i], &live = table[std::size_t(places[i / 3]) * 3 + i % 3];
    EXPECT_EQ(row.at("cycle"), cycles[i / 3]);
    EXPECT_EQ(row.at("time"), 0.5 * places[i / 3]);
    EXPECT_TRUE(row.at("linear") == live.at("linear") || std::isnan(live.at("linear"))) << i;
  }
  EXPECT_NE(table[0].at("linear"), table[3].at("linear"));
  for (const auto& [again, live] : {std::pair("31", "20"), {"32", "10"}, {"33", "00"}})
    EXPECT_TRUE(contents(path("out/seen_0000" + std::string(again) + ".png")) ==
                contents(path("out/seen_0000" + std::string(live) + ".png")))
        << again;
  const std::string summary = contents(path("sum.json"));
  EXPECT_NE(summary.find("\"rebuild\": 1"), std::string::npos) << summary;
}

TEST_F(Order, AStepThatIsNotHeldIsNamed) {
  const Outcome o = run("--hold 2 --order 0-3,0 " + files);
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("m0.vtu: cycle 0 is not held; those held are 20 30"), std::string::npos)
      << o.err;
}

TEST_F(Order, Usage) {
  for (const char* const options : {"--order 4", "--order 0-3,x", "--order 1,", "--order -1",
                                    "--order 0,1 --reverse", "--hold -1", "--hold some"})
    EXPECT_EQ(run(std::string(options) + " " + files).code, 2) << options;
  EXPECT_NE(run("--order 4 " + files).err.find("step 4 of 4"), std::string::npos);
}
