#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>

#include "core/status.h"

/// Structs of insitu.h that callers give and receive, and how they grow: the only place that looks
/// at their sizes. A caller was compiled against this version or another one; its struct's `size`
/// tells which members it has.
namespace insitu::core {

/// Name and defaults of such a struct; see INSITU_CALLER_STRUCT.
template <class T>
struct CallerStruct;

/// The size that T had in 0.2, the first version whose structs may grow: none is shorter. Whoever
/// appends a member to T specialises it as that member's offset, which is all that it takes.
template <class T>
inline constexpr std::size_t first_size = sizeof(T);

/// Whether T's size stays as it is: other structs hold it by value, or it comes in lists. New
/// members take their room from `reserved`, and 0 is their default.
template <class T>
inline constexpr bool keeps_size = false;

#define INSITU_CALLER_STRUCT(type)                                                                 \
  template <>                                                                                      \
  struct CallerStruct<type> {                                                                      \
    static constexpr const char* name = #type;                                                     \
    static type defaults() { return type##_default(); }                                            \
  }

INSITU_CALLER_STRUCT(insitu_advance_args);
INSITU_CALLER_STRUCT(insitu_amr);
INSITU_CALLER_STRUCT(insitu_amr_info);
INSITU_CALLER_STRUCT(insitu_array);
INSITU_CALLER_STRUCT(insitu_block);
INSITU_CALLER_STRUCT(insitu_cells);
INSITU_CALLER_STRUCT(insitu_faces);
INSITU_CALLER_STRUCT(insitu_commit_report);
INSITU_CALLER_STRUCT(insitu_frame);
INSITU_CALLER_STRUCT(insitu_leaves);
INSITU_CALLER_STRUCT(insitu_locate_args);
INSITU_CALLER_STRUCT(insitu_locator);
INSITU_CALLER_STRUCT(insitu_locator_info);
INSITU_CALLER_STRUCT(insitu_patch);
INSITU_CALLER_STRUCT(insitu_report);
INSITU_CALLER_STRUCT(insitu_sample_args);
INSITU_CALLER_STRUCT(insitu_session_options);
INSITU_CALLER_STRUCT(insitu_validation);
INSITU_CALLER_STRUCT(insitu_vertices_args);

template <>
inline constexpr bool keeps_size<insitu_array> = true;
template <>
inline constexpr bool keeps_size<insitu_locate_args> = true;
template <> // without units before 0.1
inline constexpr std::size_t first_size<insitu_frame> = offsetof(insitu_frame, angle);

namespace detail {

/// A `size` beyond is no size, and is not followed.
inline constexpr std::size_t largest_struct = 4096;

[[noreturn]] void refuse_size(const std::string& what, const char* name, std::size_t size,
                              std::size_t least, std::size_t most);
/// Throws if a byte of [begin, end) is not 0.
void expect_zeros(const void* given, std::size_t begin, std::size_t end, const std::string& what,
                  const char* name, std::size_t known);

} // namespace detail

/// Throws INSITU_ERROR_ARGUMENT, naming the struct and the numbers, unless the size of a caller's
/// struct is one that T has or may come to have. Returns how much of it is known here.
template <class T>
std::size_t check_size(const T* given, const std::string& what) {
  if (!given)
    throw Error(INSITU_ERROR_ARGUMENT,
                what + ": null; make it with " + CallerStruct<T>::name + "_default()");
  const std::size_t most = keeps_size<T> ? sizeof(T) : detail::largest_struct;
  if (given->size < first_size<T> || given->size > most || given->size % alignof(T) != 0)
    detail::refuse_size(what, CallerStruct<T>::name, given->size, first_size<T>, most);
  return std::min(given->size, sizeof(T));
}

/// Throws INSITU_ERROR_ARGUMENT if the size is wrong, or if what this version does not know of an
/// argument is not 0: a later version's caller asks for what cannot be done.
template <class T>
std::size_t check_argument(const T* given, const std::string& what) {
  const std::size_t known = check_size(given, what);
  if (given->size > known)
    detail::expect_zeros(given, known, given->size, what, CallerStruct<T>::name, sizeof(T));
  if constexpr (requires { given->reserved; })
    if (constexpr std::size_t at = offsetof(T, reserved); known > at)
      detail::expect_zeros(given, at, at + sizeof given->reserved, what, CallerStruct<T>::name,
                           sizeof(T));
  return known;
}

/// A caller's argument in this version's form, with defaults for what an earlier version's lacks.
template <class T>
T from_caller(const T* given, const std::string& what) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t known = check_argument(given, what);
  T out = CallerStruct<T>::defaults();
  std::memcpy(&out, given, known);
  out.size = sizeof out;
  return out;
}

/// Copies a result to the caller's struct, as far as it has room.
template <class T>
void to_caller(const T& from, T* to, const std::string& what) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t known = check_size(to, what), size = to->size;
  std::memcpy(to, &from, known);
  to->size = size;
}

} // namespace insitu::core
