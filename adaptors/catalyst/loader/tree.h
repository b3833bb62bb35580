#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "blueprint/conduit.h"

namespace insitu::catalyst {

/// A tree of named nodes whose leaves are numbers or text, as Conduit's are: what stands in for
/// Conduit where it is not installed, and what dumps are read into.
struct Tree {
  using TypeId = blueprint::Conduit::TypeId;

  std::string name;
  TypeId type = blueprint::Conduit::empty;
  std::int64_t count = 0, offset = 0, stride = 0; ///< of a leaf; bytes
  char* data = nullptr;                           ///< of a leaf, before the offset
  bool same_endianness = true;                    ///< as the machine's
  std::vector<char> own;                          ///< the leaf's values, if they are not external
  std::vector<std::unique_ptr<Tree>> children;

  /// The node of a path; null if there is none.
  Tree* find(const std::string& path);
  /// The node of a path, made if there is none.
  Tree& make(const std::string& path);
  Tree& append();
  void remove(const std::string& path);

  /// Makes the node a leaf of numbers that stay where they are, or of a copy.
  void set_external(TypeId of, const void* values, std::int64_t n, std::int64_t first,
                    std::int64_t step);
  void set_copy(TypeId of, const void* values, std::int64_t n);

  /// The functions by which such trees are read and written, in Conduit's place.
  static const blueprint::Conduit& functions();
};

} // namespace insitu::catalyst
