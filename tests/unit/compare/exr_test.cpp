// OpenEXR files compared channel by channel.
#include <cmath>
#include <gtest/gtest.h>

#include "compare/exr_compare.h"
#include "core/status.h"
#include "output/image/exr.h"
#include "unit/output/folder.h"

namespace {

using insitu::compare::compare_exr;
using insitu::compare::ExrOptions;
using insitu::compare::Verdict;
using test::Folder;

/// A depth and ids of 3 x 2 pixels.
struct Numbers {
  std::vector<float> depth{1, 2, 3, 4, HUGE_VALF, NAN};
  std::vector<std::uint32_t> ids{0, 1, 2, 4000000000u, 4, 5};

  std::string write(const Folder& folder, const std::string& name) const {
    const insitu::output::ExrChannel channels[] = {{"Z", depth.data()}, {"id", ids.data()}};
    const insitu::output::ExrAttribute from[] = {{"from", name}};
    insitu::output::write_exr(folder / name, 3, 2, channels, from);
    return folder / name;
  }
};

bool says(const Verdict& v, const std::string& what) {
  for (const std::string& line : v.lines)
    if (line.find(what) != std::string::npos)
      return true;
  return false;
}

TEST(CompareExr, SameWhateverTheAttributes) {
  const Folder folder;
  const Verdict v =
      compare_exr(Numbers().write(folder, "a.exr"), Numbers().write(folder, "b.exr"), {});
  EXPECT_TRUE(v.same);
  EXPECT_TRUE(says(v, "2 channels of 3 x 2"));
}

TEST(CompareExr, OneIdOrOneRoundingIsSeenUnlessAdmitted) {
  const Folder folder;
  const std::string a = Numbers().write(folder, "a.exr");
  Numbers other;
  other.ids[3] += 1;
  const std::string b = other.write(folder, "b.exr");
  const Verdict id = compare_exr(a, b, {});
  EXPECT_FALSE(id.same);
  EXPECT_TRUE(says(id, "channel 'id': 1 pixel of 6 moved, most (0, 1): 4e+09 -> 4000000001"))
      << id.lines[0];
  EXPECT_TRUE(compare_exr(a, b, {.ignored = {"id"}}).same);
  EXPECT_TRUE(compare_exr(a, b, {.max_share = 0.17}).same);
  EXPECT_FALSE(compare_exr(a, b, {.max_share = 0.16}).same);
  EXPECT_TRUE(compare_exr(a, b, {.channels = {{"id", {0, 1}}}}).same);

  Numbers near;
  near.depth[1] = std::nextafter(2.0f, 3.0f);
  const std::string c = near.write(folder, "c.exr");
  EXPECT_FALSE(compare_exr(a, c, {}).same);
  EXPECT_TRUE(compare_exr(a, c, {.tolerance = {1e-6, 0}}).same);
  near.depth[1] = 2;
  near.depth[5] = 0; // from no number
  EXPECT_FALSE(compare_exr(a, near.write(folder, "d.exr"), {.tolerance = {1, 100}}).same);
}

TEST(CompareExr, SizesChannelsAndUnreadableFiles) {
  const Folder folder;
  const std::string a = Numbers().write(folder, "a.exr");
  const std::vector<float> few{1, 2};
  const insitu::output::ExrChannel z[] = {{"Z", few.data()}};
  insitu::output::write_exr(folder / "b.exr", 2, 1, z);
  EXPECT_TRUE(says(compare_exr(a, folder / "b.exr", {}), "sizes: 3 x 2 -> 2 x 1"));
  const Numbers numbers;
  const insitu::output::ExrChannel depth[] = {{"Z", numbers.depth.data()}};
  insitu::output::write_exr(folder / "c.exr", 3, 2, depth);
  EXPECT_TRUE(says(compare_exr(a, folder / "c.exr", {}), "'id' is missing in the second"));
  EXPECT_TRUE(says(compare_exr(folder / "c.exr", a, {}), "'id' is missing in the first"));
  test::put(folder / "d.exr", "no image");
  try {
    compare_exr(a, folder / "d.exr", {});
    FAIL();
  } catch (const insitu::core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_FILE);
    EXPECT_NE(std::string(e.what()).find("d.exr"), std::string::npos);
  }
}

} // namespace
