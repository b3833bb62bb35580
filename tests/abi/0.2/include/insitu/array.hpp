/** @file array.hpp
 *  View, Array and Points are views of the caller's memory, for insitu.hpp, which includes this
 *  file. */
#ifndef INSITU_ARRAY_HPP
#define INSITU_ARRAY_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "insitu/insitu.h"

#if __cplusplus >= 202002L
#include <span>
#endif

/** Marks an exception class as visible, since one library throws the exception and another catches
 *  it. */
#if defined(__GNUC__)
#define INSITU_VISIBLE __attribute__((visibility("default")))
#else
#define INSITU_VISIBLE
#endif

namespace insitu {

/** Every failed call throws this exception. what() is the library's message, which names the
 *  argument and the numbers. */
class INSITU_VISIBLE Error : public std::runtime_error {
public:
  Error(insitu_status status, const std::string& message)
      : std::runtime_error(message.empty() ? insitu_status_name(status) : message),
        status_(status) {}
  /** Returns an INSITU_ERROR_... value, never INSITU_OK. */
  insitu_status status() const noexcept { return status_; }

private:
  insitu_status status_;
};

/** A pointer and a number of items, as std::span is in C++20. A View neither owns nor copies the
 *  memory. */
template <class T>
class View {
public:
  using value_type = std::remove_cv_t<T>;

  constexpr View() noexcept = default;
  constexpr View(T* data, std::size_t size) noexcept : data_(data), size_(size) {}
  template <std::size_t N>
  constexpr View(T (&items)[N]) noexcept : data_(items), size_(N) {}
  /** Takes a view of anything with data() and size(): std::vector, std::array, std::span, another
   *  View. */
  template <class C, class Item = std::remove_pointer_t<decltype(std::declval<C&>().data())>,
            class = std::enable_if_t<std::is_convertible_v<Item (*)[], T (*)[]>>>
  constexpr View(C& container) noexcept : data_(container.data()), size_(container.size()) {}
  template <class U, class = std::enable_if_t<std::is_convertible_v<U (*)[], T (*)[]>>>
  constexpr View(const View<U>& other) noexcept : data_(other.data()), size_(other.size()) {}

  constexpr T* data() const noexcept { return data_; }
  constexpr std::size_t size() const noexcept { return size_; }
  constexpr bool empty() const noexcept { return size_ == 0; }
  constexpr T& operator[](std::size_t i) const noexcept { return data_[i]; }
  constexpr T* begin() const noexcept { return data_; }
  constexpr T* end() const noexcept { return data_ + size_; }

private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

template <class T>
View(T*, std::size_t) -> View<T>;
template <class T, std::size_t N>
View(T (&)[N]) -> View<T>;
template <class C>
View(C&) -> View<std::remove_pointer_t<decltype(std::declval<C&>().data())>>;

namespace detail {

/** Returns the library's number for a C++ type, or 0 for a type that the library does not read. */
template <class T>
constexpr int type_number() {
  using U = std::remove_cv_t<T>;
  if constexpr (std::is_same_v<U, float>)
    return INSITU_FLOAT32;
  else if constexpr (std::is_same_v<U, double>)
    return INSITU_FLOAT64;
  else if constexpr (std::is_same_v<U, std::uint8_t>)
    return INSITU_UINT8;
  else if constexpr (std::is_integral_v<U> && std::is_signed_v<U> && sizeof(U) == 4)
    return INSITU_INT32;
  else if constexpr (std::is_integral_v<U> && std::is_signed_v<U> && sizeof(U) == 8)
    return INSITU_INT64;
  else
    return 0;
}

template <class T>
constexpr bool is_number = type_number<T>() != 0;
template <class P>
constexpr bool is_number_pointer =
    std::is_pointer_v<P>&& is_number<std::remove_cv_t<std::remove_pointer_t<P>>>;
template <class T>
constexpr bool is_real =
    std::is_same_v<std::remove_cv_t<T>, float> || std::is_same_v<std::remove_cv_t<T>, double>;
template <class T>
constexpr bool is_index = type_number<T>() == INSITU_INT32 || type_number<T>() == INSITU_INT64;

/** The item type of a container with data() and size(). */
template <class C>
using item_of = std::remove_cv_t<
    std::remove_pointer_t<decltype(std::declval<const std::remove_reference_t<C>&>().data() +
                                   std::declval<C&>().size())>>;

template <class C>
struct is_view : std::false_type {};
template <class T>
struct is_view<View<T>> : std::true_type {};
#if __cplusplus >= 202002L
template <class T, std::size_t N>
struct is_view<std::span<T, N>> : std::true_type {};
#endif

/** Whether the memory outlives the expression C, as that of a named container or a view does. */
template <class C>
constexpr bool outlives = std::is_lvalue_reference_v<C> || is_view<std::remove_cv_t<C>>::value;

inline std::string text(std::int64_t number) {
  return std::to_string(number);
}

[[noreturn]] inline void refuse(const std::string& name, const std::string& what) {
  throw Error(INSITU_ERROR_ARGUMENT, name + ": " + what);
}

} // namespace detail

/** An array of the caller's, in any layout: items of one or more components, evenly spaced, or a
 *  block of items inside a larger array. Pointers and containers convert to it, so that programs
 *  rarely name it:
 *
 *      mesh.cell_field("density", rho.data());                // as many as the mesh has cells
 *      mesh.cell_field("density", rho);                       // a container: its size is checked
 *      mesh.cell_field("density", Array(&zones[0].rho).stride(sizeof(Zone)));
 *      mesh.vertex_field("velocity", Array(v).components(3)); // x, y, z of an item side by side
 *      mesh.cell_field("T", Array(&t[g][g][g]).block({ni, nj, nk}, {8, 8 * mi, 8 * mi * mj}));
 *      mesh.cell_field("T", Array::behind<double>(&leaf[0].data, offsetof(Zone, T))
 *                               .stride(sizeof(Leaf))); // one record a cell, behind a pointer each
 *
 *  The memory is external: the library reads it in place from the next commit to the return of the
 *  last call that uses the mesh in that step. The compiler refuses a temporary container. */
class Array {
public:
  /** Takes the array that starts at the first item. It has as many items as the mesh has, unless
   *  count() says otherwise. */
  template <class P, class = std::enable_if_t<detail::is_number_pointer<P>>>
  Array(P data) noexcept : array_(insitu_array_default()) {
    array_.data = data;
    array_.type = static_cast<insitu_type>(detail::type_number<std::remove_pointer_t<P>>());
  }
  /** Takes an array of a number of items, at least 0. */
  template <class T, class N,
            class = std::enable_if_t<detail::is_number<T> && std::is_integral_v<N>>>
  Array(const T* data, N items) noexcept : Array(data) {
    count(static_cast<std::int64_t>(items));
  }
  /** Takes all values of a std::vector, std::array, std::span, View or C array. */
  template <class C, class T = detail::item_of<C>, class = std::enable_if_t<detail::is_number<T>>>
  Array(C&& container) noexcept : Array(static_cast<const T*>(container.data())) {
    static_assert(detail::outlives<C>, "the library reads this memory later: give a container that "
                                       "lives on, not a temporary");
    values_ = static_cast<std::int64_t>(container.size());
  }
  template <class T, std::size_t N, class = std::enable_if_t<detail::is_number<T>>>
  Array(const T (&items)[N]) noexcept : Array(static_cast<const T*>(items)) {
    values_ = static_cast<std::int64_t>(N);
  }
  Array(std::nullptr_t) = delete;

  /** Makes an array of items of type T in records of their own: item i lies offset bytes behind
   *  pointer i, and stride() counts from one pointer to the next. Fields and leaves in host memory
   *  may lie so. */
  template <class T, class Pointer, class = std::enable_if_t<detail::is_number<T>>>
  static Array behind(Pointer* const* pointers, std::size_t offset) noexcept {
    Array a(static_cast<const T*>(nullptr));
    a.array_.data = pointers;
    a.array_.indirect = 1;
    a.array_.offset = static_cast<std::int64_t>(offset);
    return a;
  }

  /** Sets the number of items. */
  Array& count(std::int64_t items) noexcept {
    array_.count = items;
    counted_ = true;
    return *this;
  }
  /** Sets the number of values of one item, which is 1 at first. */
  Array& components(int number) noexcept {
    array_.components = number;
    return *this;
  }
  /** Sets the bytes from one item to the next, which may be negative. Items are packed at first. */
  Array& stride(std::int64_t bytes) noexcept {
    array_.stride[0] = bytes;
    return *this;
  }
  /** Sets the bytes from one component of an item to the next. Components are adjacent at first. */
  Array& component_stride(std::int64_t bytes) noexcept {
    array_.component_stride = bytes;
    return *this;
  }
  /** Makes the items a block within a larger array: extent items along each axis, stride_bytes from
   *  one to the next along it. Item ids run i fastest, whatever the strides. */
  Array& block(const std::array<std::int64_t, 3>& extent,
               const std::array<std::int64_t, 3>& stride_bytes) noexcept {
    for (std::size_t a = 0; a < 3; ++a) {
      array_.extent[a] = extent[a];
      array_.stride[a] = stride_bytes[a];
    }
    return count(extent[0] * extent[1] * extent[2]);
  }
  /** Says that the memory is a device's: the mesh then answers there (see insitu_mesh_locator).
   *  Queries whose points and answers stay there go through insitu.h. */
  Array& on_device() noexcept {
    array_.memory = INSITU_DEVICE;
    return *this;
  }
  /** Says that this array is a copy that an adaptor had to make, and why. The array keeps the
   *  pointer, so the text must live on. */
  Array& converted(const char* reason) noexcept {
    array_.converted = reason;
    return *this;
  }

  const void* data() const noexcept { return array_.data; }
  insitu_type type() const noexcept { return array_.type; }
  int components() const noexcept { return array_.components; }

  /** Returns the C struct. expected: the number of items for an array that does not know its own;
   *  -1: unknown, which is an error for such an array. Throws Error if the size of the container
   *  does not fit the layout. */
  insitu_array get(std::int64_t expected, const std::string& name) const {
    insitu_array out = array_;
    if (!counted_ && values_ >= 0 && is_packed()) {
      if (array_.components < 1 || values_ % array_.components != 0)
        detail::refuse(name, detail::text(values_) + " values are not whole items of " +
                                 detail::text(array_.components) + " components");
      out.count = values_ / array_.components;
    } else if (!counted_) {
      if (expected < 0)
        throw Error(INSITU_ERROR_ORDER, name + ": the number of items is not known yet; give the "
                                               "points and cells first, or an Array with a count");
      out.count = expected;
    }
    if (values_ >= 0)
      check_reach(out, name);
    return out;
  }

private:
  bool is_packed() const noexcept { return array_.stride[0] == 0 && array_.component_stride == 0; }
  int item_bytes() const noexcept {
    return array_.type == INSITU_UINT8                                    ? 1
           : array_.type == INSITU_FLOAT32 || array_.type == INSITU_INT32 ? 4
                                                                          : 8;
  }
  /** Throws Error if the layout reaches outside the container. */
  void check_reach(const insitu_array& a, const std::string& name) const {
    if (a.count <= 0)
      return;
    const std::int64_t bytes = item_bytes();
    const std::int64_t between = a.component_stride != 0 ? a.component_stride : bytes;
    const bool block = a.extent[0] != 0;
    std::int64_t low = 0, high = bytes;
    const auto extend = [&](std::int64_t steps, std::int64_t step) {
      (steps * step < 0 ? low : high) += steps * step;
    };
    extend(a.components - 1, between);
    for (int d = 0; d < (block ? 3 : 1); ++d) {
      const std::int64_t packed = a.component_stride != 0 ? bytes : bytes * a.components;
      extend((block ? a.extent[d] : a.count) - 1, a.stride[d] != 0 ? a.stride[d] : packed);
    }
    if (low < 0 || high > values_ * bytes)
      detail::refuse(name, detail::text(a.count) + " items of " + detail::text(a.components) +
                               " components reach from byte " + detail::text(low) + " to byte " +
                               detail::text(high) + ", the container holds " +
                               detail::text(values_ * bytes));
  }

  insitu_array array_;
  std::int64_t values_ = -1; ///< number of the container's values; -1: a pointer alone
  bool counted_ = false;
};

/** The points of a query, which the library reads during the call only, so that temporaries are
 *  fine:
 *
 *      mesh.locate({xyz.data(), n});           // interleaved
 *      mesh.locate({x.data(), y.data(), z.data(), n});
 *      mesh.locate(xyz);                       // a container of 3 n float or double
 *      mesh.locate(points);                    // a container of n std::array<double, 3> */
class Points {
public:
  /** Takes interleaved x, y, z of count points. */
  template <class T, class N, class = std::enable_if_t<detail::is_real<T> && std::is_integral_v<N>>>
  Points(const T* xyz, N count) noexcept : arrays_{one(xyz, count, 3)}, number_(1) {}
  /** Takes separate arrays x, y and z of count points. */
  template <class T, class N, class = std::enable_if_t<detail::is_real<T> && std::is_integral_v<N>>>
  Points(const T* x, const T* y, const T* z, N count) noexcept
      : arrays_{one(x, count, 1), one(y, count, 1), one(z, count, 1)}, number_(3) {}
  /** Takes a container of 3 n interleaved numbers; throws Error if 3 does not divide its size. */
  template <class C, class T = detail::item_of<C>, std::enable_if_t<detail::is_real<T>, int> = 0>
  Points(const C& xyz) : Points(static_cast<const T*>(xyz.data()), xyz.size() / 3) {
    if (xyz.size() % 3 != 0)
      detail::refuse("points", detail::text(static_cast<std::int64_t>(xyz.size())) +
                                   " values are not whole points of 3 coordinates");
  }
  /** Takes a container of std::array<float or double, 3>. */
  template <class C, class P = detail::item_of<C>, class T = typename P::value_type,
            std::enable_if_t<detail::is_real<T> && std::is_same_v<P, std::array<T, 3>>, int> = 0>
  Points(const C& points)
      : Points(points.size() == 0 ? static_cast<const T*>(nullptr) : points.data()->data(),
               points.size()) {
    static_assert(sizeof(P) == 3 * sizeof(T), "points must be packed");
  }

  std::size_t size() const noexcept { return static_cast<std::size_t>(arrays_[0].count); }
  const insitu_array* arrays() const noexcept { return arrays_; }
  int array_count() const noexcept { return number_; }

private:
  template <class T, class N>
  static insitu_array one(const T* data, N count, int components) noexcept {
    return insitu_array_of(data, static_cast<insitu_type>(detail::type_number<T>()),
                           static_cast<std::int64_t>(count), components);
  }

  insitu_array arrays_[3] = {};
  int number_;
};

} // namespace insitu

#endif // INSITU_ARRAY_HPP
