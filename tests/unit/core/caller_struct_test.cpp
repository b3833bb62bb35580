// Structs of callers that were compiled against another version.
#include <gtest/gtest.h>

#include "core/caller_struct.h"

/// As a first version has it, and as a later one does, which appended `weight` and `name`.
struct first_thing {
  std::size_t size;
  std::int32_t a, b;
};
struct insitu_thing {
  std::size_t size;
  std::int32_t a, b;
  double weight;
  const char* name;
};
static insitu_thing insitu_thing_default() {
  return {sizeof(insitu_thing), 1, 2, 0.5, "none"};
}
/// With room, as structs within others have it.
struct insitu_roomy {
  std::size_t size;
  std::int64_t a;
  std::int32_t reserved[4];
};
static insitu_roomy insitu_roomy_default() {
  return {sizeof(insitu_roomy), 7, {}};
}

namespace insitu::core {
INSITU_CALLER_STRUCT(insitu_thing);
INSITU_CALLER_STRUCT(insitu_roomy);
template <>
inline constexpr std::size_t first_size<insitu_thing> = offsetof(insitu_thing, weight);
template <>
inline constexpr bool keeps_size<insitu_roomy> = true;
} // namespace insitu::core

namespace {

using namespace insitu::core;

template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_ARGUMENT);
    return e.what();
  }
  return "not refused";
}

TEST(CallerStruct, AnEarlierVersionsHasDefaultsForWhatItLacks) {
  const first_thing old{sizeof old, 3, 4};
  static_assert(sizeof old == first_size<insitu_thing>);
  const insitu_thing now = from_caller(reinterpret_cast<const insitu_thing*>(&old), "thing");
  EXPECT_EQ(now.size, sizeof now);
  EXPECT_EQ(now.a, 3);
  EXPECT_EQ(now.b, 4);
  EXPECT_EQ(now.weight, 0.5);
  EXPECT_STREQ(now.name, "none");
  // A version between the two.
  insitu_thing between{offsetof(insitu_thing, name), 5, 6, 7.0, "not told"};
  const insitu_thing mixed = from_caller(&between, "thing");
  EXPECT_EQ(mixed.weight, 7.0);
  EXPECT_STREQ(mixed.name, "none");
}

TEST(CallerStruct, ALaterVersionsIsTakenIfWhatIsNotKnownIsZero) {
  struct {
    insitu_thing known = insitu_thing_default();
    std::int64_t more[3] = {};
  } later;
  later.known.size = sizeof later;
  later.known.a = 9;
  const insitu_thing now = from_caller(&later.known, "thing");
  EXPECT_EQ(now.a, 9);
  EXPECT_EQ(now.size, sizeof now);
  for (const std::size_t byte : {std::size_t(0), sizeof later.more - 1}) {
    later.more[0] = later.more[1] = later.more[2] = 0;
    reinterpret_cast<unsigned char*>(later.more)[byte] = 200;
    const std::string what = refusal([&] { from_caller(&later.known, "thing 'x'"); });
    const std::string at = std::to_string(sizeof(insitu_thing) + byte);
    EXPECT_NE(what.find("thing 'x': byte " + at + " of insitu_thing is 200, 0 expected"),
              std::string::npos)
        << what;
    EXPECT_NE(what.find(std::to_string(sizeof(insitu_thing)) + " bytes of it"), std::string::npos);
  }
}

TEST(CallerStruct, SizesThatNoVersionHasAreRefused) {
  insitu_thing thing = insitu_thing_default();
  for (const std::size_t size : {std::size_t(0), std::size_t(8), first_size<insitu_thing> - 1,
                                 sizeof thing + 1, std::size_t(5000), ~std::size_t(7)}) {
    thing.size = size;
    const std::string what = refusal([&] { from_caller(&thing, "thing"); });
    EXPECT_NE(what.find("size is " + std::to_string(size)), std::string::npos) << what;
    EXPECT_NE(what.find("insitu_thing_default()"), std::string::npos) << what;
    EXPECT_NE(refusal([&] { to_caller(insitu_thing_default(), &thing, "thing"); }), "not refused");
  }
  const insitu_thing* volatile none = nullptr; // GCC 12 does not see that null is refused
  EXPECT_NE(refusal([&] { from_caller<insitu_thing>(none, "thing"); }).find("null"),
            std::string::npos);
}

TEST(CallerStruct, ResultsAreWrittenAsFarAsTheCallerHasRoom) {
  const insitu_thing result{sizeof result, 1, 2, 3.0, "result"};
  insitu_thing old{first_size<insitu_thing>, 0, 0, -1.0, "mine"};
  to_caller(result, &old, "thing");
  EXPECT_EQ(old.size, first_size<insitu_thing>);
  EXPECT_EQ(old.b, 2);
  EXPECT_EQ(old.weight, -1.0);
  EXPECT_STREQ(old.name, "mine");
  struct {
    insitu_thing known = insitu_thing_default();
    std::int64_t more = 11;
  } later;
  later.known.size = sizeof later;
  to_caller(result, &later.known, "thing");
  EXPECT_EQ(later.known.size, sizeof later);
  EXPECT_EQ(later.known.weight, 3.0);
  EXPECT_EQ(later.more, 11);
}

TEST(CallerStruct, StructsWithinOthersKeepTheirSizeAndReservedRoomIsZero) {
  insitu_roomy roomy = insitu_roomy_default();
  EXPECT_EQ(from_caller(&roomy, "roomy").a, 7);
  roomy.reserved[3] = 1;
  const std::string what = refusal([&] { from_caller(&roomy, "roomy"); });
  EXPECT_NE(what.find("byte " + std::to_string(offsetof(insitu_roomy, reserved) + 12)),
            std::string::npos)
      << what;
  for (const std::size_t size : {sizeof roomy - 8, sizeof roomy + 8}) {
    roomy = insitu_roomy_default();
    roomy.size = size;
    EXPECT_NE(refusal([&] {
                from_caller(&roomy, "roomy");
              }).find(", " + std::to_string(sizeof roomy) + " expected"),
              std::string::npos);
  }
}

} // namespace
