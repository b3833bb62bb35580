#include "node.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace insitu::blueprint {

namespace {

/// Calls with a value of the leaf's type.
template <class Visit>
auto visit(const Leaf& leaf, std::int64_t i, Visit&& visit) {
  const char* at = static_cast<const char*>(leaf.data) + i * leaf.stride;
  const auto value = [&](auto zero) {
    std::memcpy(&zero, at, sizeof zero); // records may be packed
    return visit(zero);
  };
  switch (leaf.type) {
  case Conduit::int8:
    return value(std::int8_t{});
  case Conduit::int16:
    return value(std::int16_t{});
  case Conduit::int32:
    return value(std::int32_t{});
  case Conduit::int64:
    return value(std::int64_t{});
  case Conduit::uint8:
    return value(std::uint8_t{});
  case Conduit::uint16:
    return value(std::uint16_t{});
  case Conduit::uint32:
    return value(std::uint32_t{});
  case Conduit::uint64:
    return value(std::uint64_t{});
  case Conduit::float32:
    return value(float{});
  default:
    return value(double{});
  }
}

/// A number as an integer; what none is, or lies beyond, becomes the least one, which no count is.
template <class T>
std::int64_t integer_of(T value) {
  if constexpr (std::is_floating_point_v<T>)
    return std::abs(value) < T(9.2e18) ? static_cast<std::int64_t>(value) : INT64_MIN;
  else
    return static_cast<std::int64_t>(value);
}

} // namespace

double Leaf::real(std::int64_t i) const {
  return visit(*this, i, [](auto value) { return static_cast<double>(value); });
}

std::int64_t Leaf::integer(std::int64_t i) const {
  return visit(*this, i, [](auto value) { return integer_of(value); });
}

Node Node::find(const std::string& path) const {
  if (!node_ || !conduit_->has_path(node_, path.c_str()))
    return {};
  return {*conduit_, conduit_->fetch_existing(node_, path.c_str()),
          path_.empty() ? path : path_ + "/" + path};
}

Node Node::at(const std::string& path) const {
  Node found = find(path);
  if (!found)
    throw Error(INSITU_ERROR_ARGUMENT, path_ + "/" + path + " is missing");
  return found;
}

std::int64_t Node::size() const {
  return node_ ? conduit_->number_of_children(node_) : 0;
}

Node Node::child(std::int64_t i) const {
  Node out(*conduit_, conduit_->child(node_, i), "");
  const std::string name = out.name();
  out.path_ = (path_.empty() ? "" : path_ + "/") + (name.empty() ? std::to_string(i) : name);
  return out;
}

std::string Node::name() const {
  char* text = conduit_->name(node_);
  const std::string out = text ? text : "";
  std::free(text);
  return out;
}

Conduit::TypeId Node::type() const {
  return static_cast<Conduit::TypeId>(conduit_->id(conduit_->dtype(node_)));
}

bool Node::is_leaf() const {
  return node_ && type() > Conduit::list;
}

bool Node::is_text() const {
  return node_ && type() == Conduit::char8_str;
}

Leaf Node::leaf() const {
  const void* dtype = conduit_->dtype(node_);
  Leaf leaf;
  leaf.type = type();
  leaf.count = conduit_->number_of_elements(dtype);
  if (!leaf.is_number())
    refuse(INSITU_ERROR_ARGUMENT,
           "holds no numbers (Conduit's type " + std::to_string(leaf.type) + ")");
  leaf.stride = conduit_->stride(dtype);
  if (!conduit_->endianness_matches_machine(dtype))
    refuse(INSITU_ERROR_UNSUPPORTED, "has its bytes in the order of another machine");
  leaf.data = leaf.count > 0 ? conduit_->element_ptr(node_, 0) : nullptr;
  if (leaf.count > 0 && !leaf.data)
    refuse(INSITU_ERROR_ARGUMENT,
           "has " + std::to_string(leaf.count) + " values at a null pointer");
  return leaf;
}

std::string Node::text() const {
  if (!is_text())
    refuse(INSITU_ERROR_ARGUMENT, "is no text");
  const char* const text = conduit_->as_char8_str(node_);
  if (!text)
    return "";
  // Where its end is missing, it ends with the node's memory.
  const std::int64_t most = conduit_->number_of_elements(conduit_->dtype(node_));
  return {text, std::find(text, text + std::max<std::int64_t>(most, 0), '\0')};
}

double Node::real() const {
  const Leaf values = leaf();
  if (values.count < 1)
    refuse(INSITU_ERROR_ARGUMENT, "holds no number");
  return values.real(0);
}

std::int64_t Node::integer() const {
  const Leaf values = leaf();
  if (values.count < 1)
    refuse(INSITU_ERROR_ARGUMENT, "holds no number");
  return values.integer(0);
}

void Node::refuse(insitu_status status, const std::string& what) const {
  throw Error(status, path_ + " " + what);
}

} // namespace insitu::blueprint
