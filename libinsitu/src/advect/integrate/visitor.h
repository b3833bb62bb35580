#pragma once

#include <concepts>
#include <type_traits>

#include "advect/integrate/dense.h"
#include "advect/integrate/settings.h"

namespace insitu::advect {

/// Who is told of a particle's steps by integrate() and integration(), whatever its type, so that
/// these are compiled once for each field. A visitor is called with the particle's State or, if it
/// can be, with that and the DenseStep that led there; it may return a bool: false ends the way.
class Visitor {
public:
  /// Nobody.
  Visitor() = default;
  /// visit must outlive the object.
  template <class Visit>
  requires(!std::same_as<std::remove_const_t<Visit>, Visitor> &&
           std::invocable<Visit&, const State&>) Visitor(Visit& visit) // NOLINT: stands for it
      : visit_(const_cast<std::remove_const_t<Visit>*>(&visit)),
        call_([](void* called, const State& p, const DenseStep* path) {
          Visit& to = *static_cast<Visit*>(called);
          if constexpr (std::invocable<Visit&, const State&, const DenseStep&>)
            if (path)
              return goes_on(to, p, *path);
          return goes_on(to, p);
        }),
        is_dense_(std::invocable<Visit&, const State&, const DenseStep&>) {}

  /// Whether it wants the ways of steps too.
  bool is_dense() const { return is_dense_; }
  /// False: the way ends here.
  bool operator()(const State& p) const { return !call_ || call_(visit_, p, nullptr); }
  bool operator()(const State& p, const DenseStep& path) const { return call_(visit_, p, &path); }

private:
  template <class Visit, class... Step>
  static bool goes_on(Visit& visit, const Step&... step) {
    if constexpr (std::same_as<std::invoke_result_t<Visit&, const Step&...>, bool>)
      return visit(step...);
    visit(step...);
    return true;
  }

  void* visit_ = nullptr;
  bool (*call_)(void*, const State&, const DenseStep*) = nullptr;
  bool is_dense_ = false;
};

} // namespace insitu::advect
