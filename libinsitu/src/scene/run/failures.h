#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/status.h"
#include "scene/run/step.h"

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

/// The formats of one item, which are written at a step: one that fails keeps none of the others
/// from being written, and where the step comes again, those that were written are left alone.
class Formats {
public:
  /// Calls write(i) of `count` formats. Throws core::Error with all that failed.
  template <class Write>
  void write(const Step& step, std::size_t count, Write&& write) {
    if (!note_.again(step))
      done_.assign(count, 0);
    Failures failures;
    for (std::size_t i = 0; i < count; ++i)
      if (!done_[i])
        failures.catch_of([&] {
          write(i);
          done_[i] = 1;
        });
    failures.throw_if_any();
  }

private:
  StepNote note_;
  std::vector<std::uint8_t> done_; ///< [format] at the step
};

} // namespace insitu::scene
