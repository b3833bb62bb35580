#include "tree.h"

#include <algorithm>
#include <cstring>

namespace insitu::catalyst {

namespace {

using blueprint::Conduit;

/// The first name of a path, which it then lacks.
std::string take_name(std::string& path) {
  const std::size_t slash = path.find('/');
  const std::string first = path.substr(0, slash);
  path = slash == std::string::npos ? "" : path.substr(slash + 1);
  return first;
}

Tree* child_of(Tree& tree, const std::string& name) {
  for (const auto& child : tree.children)
    if (child->name == name)
      return child.get();
  return nullptr;
}

Tree& of(const void* node) {
  return *static_cast<Tree*>(const_cast<void*>(node));
}

} // namespace

Tree* Tree::find(const std::string& path) {
  Tree* at = this;
  for (std::string rest = path; at && !rest.empty();)
    at = child_of(*at, take_name(rest));
  return at;
}

Tree& Tree::make(const std::string& path) {
  Tree* at = this;
  for (std::string rest = path; !rest.empty();) {
    const std::string next = take_name(rest);
    Tree* child = child_of(*at, next);
    if (!child) {
      at->type = Conduit::object;
      child = at->children.emplace_back(std::make_unique<Tree>()).get();
      child->name = next;
    }
    at = child;
  }
  return *at;
}

Tree& Tree::append() {
  type = Conduit::list;
  return *children.emplace_back(std::make_unique<Tree>());
}

void Tree::remove(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  Tree* parent = slash == std::string::npos ? this : find(path.substr(0, slash));
  const std::string last = slash == std::string::npos ? path : path.substr(slash + 1);
  if (parent)
    parent->children.erase(
        std::remove_if(parent->children.begin(), parent->children.end(),
                       [&](const std::unique_ptr<Tree>& c) { return c->name == last; }),
        parent->children.end());
}

void Tree::set_external(TypeId of_type, const void* values, std::int64_t n, std::int64_t first,
                        std::int64_t step) {
  children.clear();
  own.clear();
  type = of_type;
  data = static_cast<char*>(const_cast<void*>(values));
  count = n;
  offset = first;
  stride = step;
}

void Tree::set_copy(TypeId of_type, const void* values, std::int64_t n) {
  const std::int64_t bytes = Conduit::bytes_of(of_type);
  std::vector<char> copy(static_cast<std::size_t>(n * bytes));
  if (n > 0)
    std::memcpy(copy.data(), values, copy.size());
  set_external(of_type, nullptr, n, 0, bytes);
  own = std::move(copy);
  data = own.data();
}

const Conduit& Tree::functions() {
  static const Conduit table = [] {
    Conduit c{};
    c.has_path = [](const void* n, const char* path) { return int(of(n).find(path) != nullptr); };
    c.fetch_existing = [](void* n, const char* path) -> void* { return of(n).find(path); };
    c.child = [](void* n, std::int64_t i) -> void* {
      return of(n).children.at(static_cast<std::size_t>(i)).get();
    };
    c.number_of_children = [](void* n) { return std::int64_t(of(n).children.size()); };
    c.name = [](const void* n) { return strdup(of(n).name.c_str()); };
    c.dtype = [](const void* n) { return n; };
    c.as_char8_str = [](void* n) { return of(n).data; };
    c.element_ptr = [](void* n, std::int64_t i) -> void* {
      return of(n).data ? of(n).data + of(n).offset + i * of(n).stride : nullptr;
    };
    c.id = [](const void* n) { return std::int64_t(of(n).type); };
    c.number_of_elements = [](const void* n) { return of(n).count; };
    c.stride = [](const void* n) { return of(n).stride; };
    c.endianness_matches_machine = [](const void* n) { return int(of(n).same_endianness); };
    c.set_path_int64 = [](void* n, const char* path, std::int64_t value) {
      of(n).make(path).set_copy(Conduit::int64, &value, 1);
    };
    c.set_path_float64 = [](void* n, const char* path, double value) {
      of(n).make(path).set_copy(Conduit::float64, &value, 1);
    };
    c.set_path_uint8_ptr = [](void* n, const char* path, std::uint8_t* values, std::int64_t count) {
      of(n).make(path).set_copy(Conduit::uint8, values, count);
    };
    c.set_path_float64_ptr = [](void* n, const char* path, double* values, std::int64_t count) {
      of(n).make(path).set_copy(Conduit::float64, values, count);
    };
    c.set_path_char8_str = [](void* n, const char* path, const char* text) {
      of(n).make(path).set_copy(Conduit::char8_str, text, std::int64_t(std::strlen(text)) + 1);
    };
    return c;
  }();
  return table;
}

} // namespace insitu::catalyst
