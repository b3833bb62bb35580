#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "insitu/insitu.hpp"

#include "conduit.h"

namespace insitu::blueprint {

/// The values of a leaf, where the solver has them.
struct Leaf {
  const void* data = nullptr;
  Conduit::TypeId type = Conduit::empty;
  std::int64_t count = 0;
  std::int64_t stride = 0; ///< bytes

  bool is_real() const { return type == Conduit::float32 || type == Conduit::float64; }
  bool is_integer() const { return type >= Conduit::int8 && type <= Conduit::uint64; }
  bool is_number() const { return type >= Conduit::int8 && type <= Conduit::float64; }
  std::int64_t bytes() const { return Conduit::bytes_of(type); } ///< of one value
  /// Value i, of any type of number; i: from 0 to count - 1.
  double real(std::int64_t i) const;
  std::int64_t integer(std::int64_t i) const;
};

/// A node of Conduit's, with the path by which messages name it. A Node is null, or there.
class Node {
public:
  Node() = default;
  Node(const Conduit& conduit, void* node, std::string path)
      : conduit_(&conduit), node_(node), path_(std::move(path)) {}

  explicit operator bool() const { return node_ != nullptr; }
  const std::string& path() const { return path_; }

  /// The node of a path below; null if there is none.
  Node find(const std::string& path) const;
  /// Throws INSITU_ERROR_ARGUMENT, by the path, if there is none.
  Node at(const std::string& path) const;

  std::int64_t size() const; ///< number of children
  Node child(std::int64_t i) const;
  std::string name() const; ///< "" for a child of a list

  bool is_leaf() const;
  bool is_text() const;
  /// These throw INSITU_ERROR_ARGUMENT, by the path, if the node is not such a one.
  Leaf leaf() const; ///< of numbers, in the machine's order of bytes
  std::string text() const;
  double real() const;
  std::int64_t integer() const;

  [[noreturn]] void refuse(insitu_status status, const std::string& what) const;

private:
  Conduit::TypeId type() const;

  const Conduit* conduit_ = nullptr;
  void* node_ = nullptr;
  std::string path_;
};

} // namespace insitu::blueprint
