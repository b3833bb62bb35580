#include <gtest/gtest.h>

#include "core/suggest.h"

using namespace insitu::core;

TEST(Suggest, DistanceCountsEdits) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("opactiy", "opacity"), 1u); // one swap, not two replacements
  EXPECT_EQ(edit_distance("ca", "abc"), 3u);          // no part is edited twice
  EXPECT_EQ(edit_distance("Pressure", "pRESSURE"), 0u);
}

TEST(Suggest, DistanceIsSymmetric) {
  const char* words[] = {"", "a", "ab", "ba", "velocity", "veolcity", "density", "vorticity"};
  for (const char* a : words) {
    for (const char* b : words) {
      EXPECT_EQ(edit_distance(a, b), edit_distance(b, a)) << a << " " << b;
    }
  }
}

TEST(Suggest, TakesTheNearest) {
  const std::vector<std::string> fields = {"density", "pressure", "velocity", "x"};
  EXPECT_EQ(suggest("presure", fields), "pressure");
  EXPECT_EQ(suggest("Density", fields), "density");
  EXPECT_EQ(suggest("veloctiy", fields), "velocity");
  EXPECT_EQ(suggest("vel", fields), "velocity"); // a beginning
}

TEST(Suggest, IsSilentWhenNothingIsNear) {
  const std::vector<std::string> fields = {"density", "pressure", "velocity", "x"};
  EXPECT_EQ(suggest("temperature", fields), "");
  EXPECT_EQ(suggest("y", fields), ""); // an edit of its only letter is another word
  EXPECT_EQ(suggest("", fields), "");
  EXPECT_EQ(suggest("pressure", {}), "");
  EXPECT_EQ(suggest(std::string(100000, 'p'), fields), "");
}

TEST(Suggest, Sentence) {
  EXPECT_EQ(did_you_mean("exat", {"fast", "exact"}), "; did you mean 'exact'?");
  EXPECT_EQ(did_you_mean("zzzz", {"fast", "exact"}), "");
}
