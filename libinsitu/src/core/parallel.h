#pragma once

#include <cstdint>
#include <memory>
#include <type_traits>

namespace insitu::core {

/// A reference to a callable, which it does not own. It must not outlive the call that it is passed
/// to.
template <class Signature>
class FunctionRef;
template <class R, class... A>
class FunctionRef<R(A...)> {
public:
  template <class F>
    requires(!std::is_same_v<std::remove_cvref_t<F>, FunctionRef>)
  FunctionRef(F&& f)
      : object_(const_cast<void*>(static_cast<const void*>(&f))), call_([](void* o, A... a) -> R {
          return (*static_cast<std::remove_reference_t<F>*>(o))(static_cast<A>(a)...);
        }) {}
  R operator()(A... a) const { return call_(object_, static_cast<A>(a)...); }

private:
  void* object_;
  R (*call_)(void*, A...);
};

/// The threads of a session: at most `limit` (0: no limit), and at most as many as the affinity of
/// the process allows.
class Threads {
public:
  explicit Threads(int limit = 0);
  ~Threads();
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  int count() const { return count_; }

  /// Calls body(begin, end) for consecutive ranges of at most `grain` items that cover [0, n). The
  /// ranges depend on n and grain alone, never on the number of threads. Every range runs in the
  /// default floating-point environment. The call rethrows the first exception.
  void parallel_for(std::int64_t n, std::int64_t grain,
                    FunctionRef<void(std::int64_t, std::int64_t)> body) const;

  /// Runs f on the threads of the session, so that parallel code inside it (that of Embree) keeps
  /// the limit.
  void run(FunctionRef<void()> f) const;

private:
  struct Arena;
  int count_;
  std::unique_ptr<Arena> arena_;
};

} // namespace insitu::core
