// INSITU_SIMD_TARGET is read when the library is loaded, so each value has a process of its own.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <hwy/highway.h>
#include <string>

#include "core/context.h"
#include "core/simd_target.h"
#include "core/status.h"
#include "fixtures/simd_targets.h"

namespace insitu {
namespace {

std::string asked() {
  const char* const text = std::getenv("INSITU_SIMD_TARGET");
  return text ? text : "";
}

bool is_there(const std::string& name) {
  for (const std::int64_t target : fixtures::simd_targets())
    if (name == hwy::TargetName(target))
      return true;
  return false;
}

/// The tests of this program that say what holds whatever the environment says.
int run_with(const std::string& value) {
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  return std::system(("INSITU_SIMD_TARGET='" + value + "' '" + program +
                      "' --gtest_filter='SimdTargetOf*' > /dev/null")
                         .c_str());
}

TEST(SimdTargetOfThisProcess, IsWhatTheEnvironmentSays) {
  const core::SimdTarget& target = core::simd_target();
  if (asked() == "baseline") {
    EXPECT_EQ(fixtures::simd_targets().size(), 1u);
    EXPECT_EQ(target.name, hwy::TargetName(fixtures::simd_targets().front()));
    return;
  }
  const bool named = !asked().empty() && asked() != "best";
  if (!named || !is_there(asked())) {
    EXPECT_FALSE(target.asked);
    EXPECT_EQ(target.name, hwy::TargetName(fixtures::simd_targets().front()));
    EXPECT_EQ(target.embree, nullptr);
    return;
  }
  EXPECT_TRUE(target.asked);
  EXPECT_EQ(target.name, asked());
  EXPECT_EQ(fixtures::simd_targets().size(), 1u) << "nothing else is dispatched to";
}

TEST(SimdTargetOfThisProcess, IsRefusedWhereItIsNotThere) {
  if (asked().empty() || asked() == "best" || asked() == "baseline" || is_there(asked())) {
    EXPECT_NO_THROW(core::Context(1, core::Log()));
    return;
  }
  try {
    core::Context(1, core::Log());
    ADD_FAILURE() << "no error for " << asked();
  } catch (const core::Error& e) {
    EXPECT_EQ(e.status(), INSITU_ERROR_ARGUMENT);
    EXPECT_NE(std::string(e.what()).find("'" + asked() + "'"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find(core::simd_target().name), std::string::npos) << e.what();
  }
}

TEST(SimdTarget, EveryOneOfTheMachineCanBeChosen) {
  for (const std::int64_t target : fixtures::simd_targets())
    EXPECT_EQ(run_with(hwy::TargetName(target)), 0) << hwy::TargetName(target);
  EXPECT_EQ(run_with("best"), 0);
  EXPECT_EQ(run_with("baseline"), 0);
  EXPECT_EQ(run_with(""), 0);
}

TEST(SimdTarget, OthersAreRefused) {
  for (const char* name : {"AVX9", "avx2", "SSE2 ", "0"})
    EXPECT_EQ(run_with(name), 0) << name;
}

} // namespace
} // namespace insitu
