#pragma once

#include <coroutine>
#include <cstddef>
#include <exception>
#include <new>
#include <utility>

#include "insitu/insitu.h"

namespace insitu::advect {

/// An integration under way, a coroutine that pauses where it needs a velocity, so that many can be
/// answered at once. Between two pauses it runs on the thread that resumes it.
class Stepping {
public:
  struct promise_type {
    insitu_ending ending = INSITU_END_COUNT;
    std::exception_ptr error;

    Stepping get_return_object() { return Stepping(Handle::from_promise(*this)); }
    std::suspend_always initial_suspend() noexcept { return {}; }
    std::suspend_always final_suspend() noexcept { return {}; }
    void return_value(insitu_ending value) { ending = value; }
    void unhandled_exception() { error = std::current_exception(); }

    // An integration's memory serves the thread's next one.
    static void* operator new(std::size_t size) { return frames().take(size); }
    static void operator delete(void* frame, std::size_t size) { frames().give(frame, size); }
  };

  Stepping() = default;
  Stepping(Stepping&& b) noexcept : handle_(std::exchange(b.handle_, nullptr)) {}
  Stepping& operator=(Stepping&& b) noexcept {
    std::swap(handle_, b.handle_);
    return *this;
  }
  ~Stepping() {
    if (handle_)
      handle_.destroy();
  }

  explicit operator bool() const { return bool(handle_); }
  /// Goes on to the next pause, or to the end.
  void resume() { handle_.resume(); }
  bool done() const { return handle_.done(); }
  /// How it ended; what was thrown in it is thrown again.
  insitu_ending ending() const {
    if (handle_.promise().error)
      std::rethrow_exception(handle_.promise().error);
    return handle_.promise().ending;
  }

private:
  using Handle = std::coroutine_handle<promise_type>;
  explicit Stepping(Handle handle) : handle_(handle) {}

  /// Blocks of one size, that of the last; the few that are free at a time.
  class Frames {
  public:
    ~Frames() { clear(); }
    void* take(std::size_t size) {
      if (size != size_ || count_ == 0)
        return ::operator new(size);
      return free_[--count_];
    }
    void give(void* frame, std::size_t size) noexcept {
      if (size != size_)
        clear();
      size_ = size;
      if (count_ == most)
        ::operator delete(frame);
      else
        free_[count_++] = frame;
    }

  private:
    static constexpr int most = 8;
    void clear() noexcept {
      while (count_ > 0)
        ::operator delete(free_[--count_]);
    }
    std::size_t size_ = 0;
    int count_ = 0;
    void* free_[most];
  };
  static Frames& frames() {
    thread_local Frames frames;
    return frames;
  }

  Handle handle_;
};

} // namespace insitu::advect
