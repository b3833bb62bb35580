#pragma once

#include <string>

#include "mesh/array_view.h"

namespace insitu::mesh {

/// A checked insitu_array: what the caller gave, with extents and strides made explicit.
struct ExternalArray {
  const std::byte* data = nullptr;
  insitu_type type = INSITU_FLOAT64;
  int components = 0;
  std::int64_t component_stride = 0;
  ItemLayout layout;
  insitu_memory memory = INSITU_HOST;
  std::string converted; ///< empty: borrowed; else why it is a copy
  bool indirect = false; ///< `data` holds pointers, and the items lie `offset` bytes behind them
  std::int64_t offset = 0;
  /// Of items of different lengths behind pointers: how many values they have in all, once a commit
  /// has counted them; -1 for all other arrays.
  std::int64_t indirect_values = -1;

  bool given() const { return components > 0; }
  /// Component c of item i.
  const std::byte* at(std::int64_t i, int c) const {
    const std::byte* item = data + layout.offset(i);
    return (indirect ? load_as<const std::byte*>(item) + offset : item) + c * component_stride;
  }
  std::int64_t bytes() const; ///< of the items

  /// The smallest range of addresses that holds all items; of items behind pointers, the pointers.
  struct Range {
    std::uintptr_t begin, end;
    bool meets(const Range& other) const {
      return begin < other.end && other.begin < end; // an empty range meets nothing
    }
  };
  Range range() const;
};

int size_of(insitu_type type);
const char* type_name(insitu_type type);

/// Who reads an array follows pointers to its items, or cannot.
enum class Pointers { refused, followed };

/// Checks and adopts; `name` is what messages call it. Throws core::Error.
ExternalArray adopt(const insitu_array* array, const std::string& name,
                    Pointers pointers = Pointers::refused);

/// Throws unless the array holds float32 or float64.
void require_real(const ExternalArray& array, const std::string& name);
/// Throws unless the array holds int32 or int64.
void require_integer(const ExternalArray& array, const std::string& name);

} // namespace insitu::mesh
