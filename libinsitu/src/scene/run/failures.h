#pragma once

#include <string>

#include "core/status.h"

namespace insitu::scene {

/// Formats of one item, of which one that fails does not keep the others from being written.
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
