#pragma once

#include <cstdint>

namespace insitu::blueprint {

/// The functions of Conduit's C interface by which nodes are read, and results written. Conduit is
/// not needed to build: resolve() finds the functions in the program that gives the nodes. A table
/// of another origin may read trees of another kind (insitu-replay: those of dumps).
struct Conduit {
  int (*has_path)(const void* node, const char* path);
  void* (*fetch_existing)(void* node, const char* path);
  void* (*child)(void* node, std::int64_t index);
  std::int64_t (*number_of_children)(void* node);
  char* (*name)(const void* node); ///< memory of malloc()
  const void* (*dtype)(const void* node);
  char* (*as_char8_str)(void* node);
  void* (*element_ptr)(void* node, std::int64_t index);
  std::int64_t (*id)(const void* dtype); ///< a TypeId
  std::int64_t (*number_of_elements)(const void* dtype);
  std::int64_t (*stride)(const void* dtype); ///< bytes
  int (*endianness_matches_machine)(const void* dtype);
  void (*set_path_int64)(void* node, const char* path, std::int64_t value);
  void (*set_path_float64)(void* node, const char* path, double value);
  void (*set_path_char8_str)(void* node, const char* path, const char* value);
  /// Of copies of n numbers.
  void (*set_path_uint8_ptr)(void* node, const char* path, std::uint8_t* values, std::int64_t n);
  void (*set_path_float64_ptr)(void* node, const char* path, double* values, std::int64_t n);

  /// Conduit's numbers of types, which are part of its binary interface.
  enum TypeId : std::int64_t {
    empty = 0,
    object = 1,
    list = 2,
    int8 = 3,
    int16 = 4,
    int32 = 5,
    int64 = 6,
    uint8 = 7,
    uint16 = 8,
    uint32 = 9,
    uint64 = 10,
    float32 = 11,
    float64 = 12,
    char8_str = 13
  };

  /// Bytes of one value: 0 of what is no leaf.
  static constexpr std::int64_t bytes_of(TypeId type) {
    switch (type) {
    case int16:
    case uint16:
      return 2;
    case int32:
    case uint32:
    case float32:
      return 4;
    case int64:
    case uint64:
    case float64:
      return 8;
    default:
      return type > list ? 1 : 0;
    }
  }

  /// Whose nodes are read: those of the Conduit that is part of libcatalyst (its functions are
  /// named catalyst_conduit_...), if the program has it, or those of a Conduit of the program's
  /// own.
  enum class Preferred { catalyst, own };
  /// Finds the functions among the libraries that the program has loaded, however they were loaded.
  /// Throws INSITU_ERROR_UNSUPPORTED, which names the first function that is missing.
  static const Conduit& resolve(Preferred preferred);
};

} // namespace insitu::blueprint
