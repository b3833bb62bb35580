// What is said where a backend cannot be used.
#include <gtest/gtest.h>

#include "accel/optix/unavailable.h"
#include "core/status.h"
#include "query/device/device_locator.h"

using namespace insitu;
using accel::Backend;
using accel::Method;
using accel::optix::LoadFailure;
using accel::optix::why_not_loaded;

TEST(Unavailable, OptixSaysWhatTheDriverLacks) {
  EXPECT_EQ(why_not_loaded(LoadFailure::driver_too_old, 80000, 105, ""),
            "driver too old for this OptiX (ABI 105)");
  EXPECT_EQ(why_not_loaded(LoadFailure::not_found, 70700, 84, "no such file"),
            "libnvoptix.so.1 was not found (no such file); it comes with the display driver");
  EXPECT_EQ(why_not_loaded(LoadFailure::not_found, 70700, 84, ""),
            "libnvoptix.so.1 was not found; it comes with the display driver");
  EXPECT_EQ(why_not_loaded(LoadFailure::other, 70700, 84, "result 7001"),
            "libnvoptix.so.1 does not serve OptiX 7.7 (ABI 84): result 7001");
}

TEST(Unavailable, LocatorsAreRefusedWithTheReason) {
  EXPECT_EQ(query::why_unavailable(Backend::cpu), "");
  core::Memory memory;
  for (const auto& [backend, method] :
       {std::pair{Backend::cuda, Method::bvh}, {Backend::optix, Method::user_geometry}}) {
    const std::string why = query::why_unavailable(backend);
    if (why.empty())
      continue; // it can be used here
    try {
      query::make_device_locator(backend, method, memory);
      ADD_FAILURE() << name(backend) << " was made, though: " << why;
    } catch (const core::Error& e) {
      EXPECT_EQ(e.status(), INSITU_ERROR_UNSUPPORTED);
      EXPECT_EQ(std::string(e.what()), std::string("backend ") + name(backend) + ": " + why);
    }
  }
}
