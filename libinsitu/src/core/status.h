#pragma once

#include <stdexcept>
#include <string>

#include "insitu/insitu.h"

namespace insitu::core {

/// The one exception type of the library. src/api turns it into a status and a message.
class Error : public std::runtime_error {
public:
  Error(insitu_status status, const std::string& message)
      : std::runtime_error(message), status_(status) {}
  insitu_status status() const { return status_; }

private:
  insitu_status status_;
};

} // namespace insitu::core
