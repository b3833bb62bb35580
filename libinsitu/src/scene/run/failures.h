#pragma once

#include <string>

#include "core/status.h"

namespace insitu::scene {

/// Collects the failures of the formats of one item, so that a format that fails does not keep the
/// other formats from being written.
class Failures {
public:
  template <class Act>
  void catch_of(Act&& act) {
    try {
      act();
    } catch (const core::Error& e) {
      text_ += (text_.empty() ? "" : "; ") + std::string(e.what());
      status_ = e.status();
    }
  }
  bool any() const { return !text_.empty(); }
  void throw_if_any() const {
    if (any())
      throw core::Error(status_, text_);
  }

private:
  std::string text_;
  insitu_status status_ = INSITU_OK;
};

} // namespace insitu::scene
