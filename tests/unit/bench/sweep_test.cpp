// What insitu-bench accuracy says of settings that win nowhere, on data made for it.
#include <cmath>
#include <gtest/gtest.h>

#include "accuracy/sweep.h"

namespace {

using namespace insitu::bench;
using namespace insitu::bench::accuracy;

Setting setting(const std::string& group, const std::string& name, double error, double seconds) {
  Setting s;
  s.group = group;
  s.name = name;
  s.error = error;
  s.time.add(seconds);
  return s;
}

TEST(Losers, AMethodThatIsOffEveryFrontIsNamedWithItsBestRatio) {
  Sweep s;
  s.settings = {setting("a", "good, 1", 1e-3, 1.0), setting("a", "good, 2", 1e-6, 4.0),
                setting("a", "bad, 1", 1e-3, 1.5),  setting("a", "bad, 2", 1e-6, 12.0),
                setting("b", "good, 1", 0.0, 2.0),  setting("b", "bad, 1", 0.0, 2.5)};
  const std::vector<Loser> all = losers(s);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].name, "bad");
  EXPECT_TRUE(all[0].is_method);
  EXPECT_DOUBLE_EQ(all[0].at_best, 1.25);
  EXPECT_NE(
      say_losers(s).find("Methods that win nowhere here, whatever their settings: bad (1.25)."),
      std::string::npos)
      << say_losers(s);
  EXPECT_EQ(say_losers(s).find("good"), std::string::npos) << say_losers(s);
}

TEST(Losers, NoneIsNamedWhereEachMethodWinsSomewhere) {
  Sweep s;
  s.settings = {setting("a", "one, 1", 1e-3, 1.0), setting("a", "other, 1", 1e-3, 9.0),
                setting("b", "one, 1", 1e-3, 9.0), setting("b", "other, 1", 1e-3, 1.0)};
  EXPECT_TRUE(losers(s).empty());
  EXPECT_EQ(say_losers(s), "Every method wins somewhere, or loses by no more than a tenth or the "
                           "spread of repetitions.");
}

TEST(Losers, ASettingLosesAloneWhereItsMethodWins) {
  Sweep s;
  s.settings = {setting("a", "one, 1", 1e-3, 1.0), setting("a", "one, 2", 1e-2, 1.2),
                setting("a", "one, 3", 1e-4, 3.0)};
  const std::vector<Loser> all = losers(s);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].name, "one, 2");
  EXPECT_FALSE(all[0].is_method);
  EXPECT_NE(say_losers(s).find("Every method wins somewhere"), std::string::npos);
  EXPECT_NE(say_losers(s).find("Settings that win nowhere: one, 2 (1.20)."), std::string::npos)
      << say_losers(s);
}

TEST(Losers, ATenthIsNoLoss) {
  Sweep s;
  s.settings = {setting("a", "one", 1e-3, 1.0), setting("a", "other", 1e-3, 1.09)};
  EXPECT_TRUE(losers(s).empty());
  s.settings[1] = setting("a", "other", 1e-3, 1.11);
  EXPECT_EQ(losers(s).size(), 1u);
}

TEST(Losers, PeersAndStandInsNeitherWinNorBeat) {
  Sweep s;
  s.settings = {setting("a", "one", 1e-3, 1.0), setting("a", "other", 1e-3, 2.0),
                setting("a", "peer", 0.0, 0.1), setting("a", "other", 0.0, 0.1)};
  s.settings[2].is_peer = true;
  s.settings[3].is_stand_in = true;
  const std::vector<Loser> all = losers(s);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].name, "other");
  EXPECT_DOUBLE_EQ(all[0].at_best, 2.0);
  const std::vector<const Setting*> best = front(s, "a", seconds);
  ASSERT_EQ(best.size(), 1u);
  EXPECT_EQ(best[0]->name, "one");
}

// Half as much again, but repetitions of the two overlap.
TEST(Losers, WhatTheSpreadCannotTellIsNoLoss) {
  Sweep s;
  s.settings = {setting("a", "one", 1e-3, 1.0), setting("a", "other", 1e-3, 1.5)};
  s.settings[0].time.add(0.9);
  s.settings[0].time.add(1.6);
  EXPECT_TRUE(losers(s).empty());
  s.settings[0] = setting("a", "one", 1e-3, 1.0);
  s.settings[0].time.add(0.9);
  s.settings[0].time.add(1.4);
  ASSERT_EQ(losers(s).size(), 1u);
  EXPECT_DOUBLE_EQ(losers(s)[0].at_best, 1.5);
}

TEST(Front, HoldsWhatNothingElseBeatsAndTheDefaultsPlace) {
  Sweep s;
  s.settings = {setting("a", "slow", 1e-6, 4.0), setting("a", "fast", 1e-2, 1.0),
                setting("a", "beaten", 1e-2, 2.0), setting("a", "chosen", 1e-4, 3.0),
                setting("a", "as good", 1.005e-4, 2.0)};
  s.settings[3].is_default = true;
  std::string names;
  for (const Setting* best : front(s, "a", seconds))
    names += best->name + ";";
  EXPECT_EQ(names, "fast;as good;chosen;slow;");
  EXPECT_DOUBLE_EQ(default_over_front(s, "a", seconds), 1.5); // within 1 % of its error
}

} // namespace
