// Without the backend that the tests are for, ctest is told that they were skipped, not passed.
#include <cstdio>
#include <gtest/gtest.h>

#include "query/device/device_locator.h"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const std::string why =
      insitu::query::why_unavailable(insitu::accel::Backend::INSITU_GPU_TEST_BACKEND);
  if (why.empty())
    return RUN_ALL_TESTS();
  std::printf("skipped: %s\n", why.c_str());
  return INSITU_GPU_TEST_SKIPPED;
}
