#pragma once

#include "math/hd.h"

namespace insitu::math {

/// A vector of three numbers; T is float, double or a SIMD pack.
template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  INSITU_HD constexpr T operator[](int i) const { return i == 0 ? x : (i == 1 ? y : z); }
  INSITU_HD constexpr T& operator[](int i) { return i == 0 ? x : (i == 1 ? y : z); }

  INSITU_HD constexpr Vec3& operator+=(const Vec3& b) {
    x = x + b.x;
    y = y + b.y;
    z = z + b.z;
    return *this;
  }
  INSITU_HD constexpr Vec3& operator-=(const Vec3& b) {
    x = x - b.x;
    y = y - b.y;
    z = z - b.z;
    return *this;
  }
};

using Vec3d = Vec3<double>;
using Vec3f = Vec3<float>;

template <class T>
INSITU_HD constexpr Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
INSITU_HD constexpr Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
INSITU_HD constexpr Vec3<T> operator-(const Vec3<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
INSITU_HD constexpr Vec3<T> operator*(const T& s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
INSITU_HD constexpr Vec3<T> operator*(const Vec3<T>& a, const T& s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <class T>
INSITU_HD constexpr Vec3<T> operator/(const Vec3<T>& a, const T& s) {
  return {a.x / s, a.y / s, a.z / s};
}
template <class T>
INSITU_HD constexpr bool operator==(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}
template <class T>
INSITU_HD constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
INSITU_HD constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

} // namespace insitu::math
