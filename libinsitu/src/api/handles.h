#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

namespace insitu::api {

/// Maps opaque handles to objects. A handle is a number that is never used again, so a released
/// or invented one is found out, not followed. Thread-safe; an object lives on while a call that
/// found it runs.
template <class T>
class Handles {
public:
  /// Handles of different kinds are of different residues, so one is never taken for the other.
  explicit Handles(std::uintptr_t residue) : next_(residue) {}

  std::uintptr_t add(std::shared_ptr<T> object) {
    const std::lock_guard lock(mutex_);
    // Steps of 16 from the bottom of the address space: no valid pointer, and never null.
    next_ += 16;
    objects_.emplace(next_, std::move(object));
    return next_;
  }
  std::shared_ptr<T> find(std::uintptr_t handle) const {
    const std::lock_guard lock(mutex_);
    const auto it = objects_.find(handle);
    return it == objects_.end() ? nullptr : it->second;
  }
  std::shared_ptr<T> remove(std::uintptr_t handle) {
    const std::lock_guard lock(mutex_);
    const auto it = objects_.find(handle);
    if (it == objects_.end())
      return nullptr;
    std::shared_ptr<T> object = std::move(it->second);
    objects_.erase(it);
    return object;
  }

private:
  mutable std::mutex mutex_;
  std::map<std::uintptr_t, std::shared_ptr<T>> objects_;
  std::uintptr_t next_;
};

} // namespace insitu::api
