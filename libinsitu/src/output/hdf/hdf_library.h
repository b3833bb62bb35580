#pragma once

#include <hdf5.h>
#include <mutex>
#include <string>

#include "insitu/insitu.h"

/// What the writer and the reader of HDF5 files have in common.
namespace insitu::output::hdf {

/// While one lives, no other thread is in HDF5 through this library, and HDF5 prints nothing: its
/// host's error handler is put back afterwards.
class Call {
public:
  Call() : lock_(library()) {
    H5Eget_auto2(H5E_DEFAULT, &handler_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Call() { H5Eset_auto2(H5E_DEFAULT, handler_, data_); }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

private:
  static std::recursive_mutex& library() {
    static std::recursive_mutex mutex;
    return mutex;
  }
  std::lock_guard<std::recursive_mutex> lock_;
  H5E_auto2_t handler_ = nullptr;
  void* data_ = nullptr;
};

/// A handle of HDF5, closed in any case.
class Handle {
public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close close) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(other.id_), close_(other.close_) { other.id_ = -1; }
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      reset();
      id_ = other.id_;
      close_ = other.close_;
      other.id_ = -1;
    }
    return *this;
  }
  ~Handle() { reset(); }

  hid_t get() const { return id_; }
  bool open() const { return id_ >= 0; }
  /// Returns whether all went well.
  bool reset() {
    const bool well = id_ < 0 || close_(id_) >= 0;
    id_ = -1;
    return well;
  }

private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// The innermost reason of the last failure; HDF5's stack is of this thread.
inline std::string reason() {
  std::string text;
  const auto first = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
    auto& out = *static_cast<std::string*>(to);
    if (out.empty() && error->desc)
      out = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, first, &text);
  return text.empty() ? "failed" : text;
}

inline hid_t type_of(insitu_type type) {
  switch (type) {
  case INSITU_FLOAT32:
    return H5T_NATIVE_FLOAT;
  case INSITU_FLOAT64:
    return H5T_NATIVE_DOUBLE;
  case INSITU_INT32:
    return H5T_NATIVE_INT32;
  case INSITU_INT64:
    return H5T_NATIVE_INT64;
  case INSITU_UINT8:
    break;
  }
  return H5T_NATIVE_UINT8;
}

} // namespace insitu::output::hdf
