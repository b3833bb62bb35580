#pragma once

#include <string>

/// Why the driver's OptiX library does not serve, in words: without the SDK's headers, so that
/// tests can read what a machine without a driver cannot show.
namespace insitu::accel::optix {

enum class LoadFailure {
  driver_too_old, ///< the library lacks this ABI
  not_found,      ///< no library; detail: the loader's message, or empty
  other           ///< detail: what the library returned
};

/// version: OPTIX_VERSION, as 70700; abi: OPTIX_ABI_VERSION.
inline std::string why_not_loaded(LoadFailure failure, int version, int abi,
                                  const std::string& detail) {
  const std::string in_abi = "(ABI " + std::to_string(abi) + ")";
  if (failure == LoadFailure::driver_too_old)
    return "driver too old for this OptiX " + in_abi;
  if (failure == LoadFailure::not_found)
    return "libnvoptix.so.1 was not found" + (detail.empty() ? "" : " (" + detail + ")") +
           "; it comes with the display driver";
  return "libnvoptix.so.1 does not serve OptiX " + std::to_string(version / 10000) + "." +
         std::to_string(version / 100 % 100) + " " + in_abi + ": " + detail;
}

} // namespace insitu::accel::optix
