#pragma once

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"

namespace insitu::core {

/// Whether a value may have other bytes than its own: what fills a struct up is anything, and must
/// not reach a file. Structs of three numbers of one kind are seen to have none; others are kept
/// member by member.
template <class T>
inline constexpr bool has_padding =
    !(std::is_arithmetic_v<T> || std::has_unique_object_representations_v<T>);
template <class T>
requires requires(T v) {
  v.x, v.y, v.z;
}
inline constexpr bool has_padding<T> = sizeof(T) != 3 * sizeof(T::x);

/// Where state goes to, or comes back from: one function of an object, state(Archive&), names its
/// members in a fixed order and serves both ways. Names and sizes of items are checked on the way
/// back; what does not fit throws core::Error.
class Archive {
public:
  virtual ~Archive() = default;
  /// The state comes back: members are written to.
  virtual bool restores() const = 0;

  template <class T>
  void value(const char* name, T& value) {
    static_assert(std::is_trivially_copyable_v<T> && !has_padding<T>);
    bytes(name, sizeof(T), 1, [&](std::size_t) { return static_cast<void*>(&value); });
  }
  void value(const char* name, std::string& text) {
    bytes(name, 1, text.size(), [&](std::size_t n) {
      text.resize(n);
      return static_cast<void*>(text.data());
    });
  }
  template <class T>
  void array(const char* name, Buffer<T>& array) {
    static_assert(std::is_trivially_copyable_v<T> && !has_padding<T>);
    bytes(name, sizeof(T), array.size(), [&](std::size_t n) {
      array.resize(n);
      return static_cast<void*>(array.data());
    });
  }
  template <class T>
  void array(const char* name, std::vector<T>& array) {
    static_assert(std::is_trivially_copyable_v<T> && !has_padding<T>);
    bytes(name, sizeof(T), array.size(), [&](std::size_t n) {
      array.resize(n);
      return static_cast<void*>(array.data());
    });
  }
  void array(const char* name, std::vector<std::string>& texts) {
    std::size_t count = texts.size();
    value(name, count);
    texts.resize(count);
    for (std::string& text : texts)
      value(name, text);
  }

protected:
  /// place(n): where n items lie, made if there are other ones now. Called with `count` to keep,
  /// and with the count that is found to restore.
  virtual void bytes(const char* name, std::size_t item_bytes, std::size_t count,
                     core::FunctionRef<void*(std::size_t)> place) = 0;
};

} // namespace insitu::core
