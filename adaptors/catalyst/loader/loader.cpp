// Catalyst's loader and the part of Conduit's C interface that catalyst.h declares.
#include <catalyst.h>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <string>

#include "catalyst/loader/tree.h"

using insitu::blueprint::Conduit;
using insitu::catalyst::Tree;

namespace {

Tree& tree_of(const conduit_node* node) {
  return *reinterpret_cast<Tree*>(const_cast<conduit_node*>(node));
}

conduit_node* node_of(Tree* tree) {
  return reinterpret_cast<conduit_node*>(tree);
}

const Tree& tree_of(const conduit_datatype* type) {
  return *reinterpret_cast<const Tree*>(type);
}

/// Of the loader's implementation.
struct Implementation {
  int version;
  enum catalyst_status (*initialize)(const conduit_node*);
  enum catalyst_status (*execute)(const conduit_node*);
  enum catalyst_status (*finalize)(const conduit_node*);
  enum catalyst_status (*about)(conduit_node*);
  enum catalyst_status (*results)(conduit_node*);
};

const Implementation* implementation = nullptr;

enum catalyst_status load(const conduit_node* parameters) {
  const char* name = std::getenv("CATALYST_IMPLEMENTATION_NAME");
  if (Tree* given = tree_of(parameters).find("catalyst_load/implementation"))
    name = given->data;
  if (!name)
    return catalyst_status_error_no_implementation;
  const char* paths = std::getenv("CATALYST_IMPLEMENTATION_PATHS");
  void* library = nullptr;
  for (std::string rest = paths ? paths : ""; !library && !rest.empty();) {
    const std::size_t colon = rest.find(':');
    const std::string folder = rest.substr(0, colon);
    rest = colon == std::string::npos ? "" : rest.substr(colon + 1);
    library = dlopen((folder + "/libcatalyst-" + name + ".so").c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (!library)
      std::fprintf(stderr, "catalyst: %s\n", dlerror());
  }
  if (!library)
    return catalyst_status_error_not_found;
  implementation = static_cast<const Implementation*>(dlsym(library, "catalyst_api_impl"));
  if (!implementation)
    return catalyst_status_error_not_catalyst;
  return implementation->version == 1 ? catalyst_status_ok
                                      : catalyst_status_error_unsupported_version;
}

} // namespace

extern "C" {

conduit_node* conduit_node_create(void) {
  return node_of(new Tree);
}

void conduit_node_destroy(conduit_node* node) {
  delete &tree_of(node);
}

conduit_node* conduit_node_fetch(conduit_node* node, const char* path) {
  return node_of(&tree_of(node).make(path));
}

conduit_node* conduit_node_fetch_existing(conduit_node* node, const char* path) {
  return node_of(tree_of(node).find(path));
}

conduit_node* conduit_node_append(conduit_node* node) {
  return node_of(&tree_of(node).append());
}

conduit_node* conduit_node_child(conduit_node* node, conduit_index_t index) {
  return node_of(tree_of(node).children.at(static_cast<std::size_t>(index)).get());
}

conduit_index_t conduit_node_number_of_children(conduit_node* node) {
  return static_cast<conduit_index_t>(tree_of(node).children.size());
}

char* conduit_node_name(const conduit_node* node) {
  return strdup(tree_of(node).name.c_str());
}

int conduit_node_has_path(const conduit_node* node, const char* path) {
  return tree_of(node).find(path) != nullptr;
}

void conduit_node_remove_path(conduit_node* node, const char* path) {
  tree_of(node).remove(path);
}

const conduit_datatype* conduit_node_dtype(const conduit_node* node) {
  return reinterpret_cast<const conduit_datatype*>(node);
}

void* conduit_node_element_ptr(conduit_node* node, conduit_index_t index) {
  return Tree::functions().element_ptr(&tree_of(node), index);
}

char* conduit_node_as_char8_str(conduit_node* node) {
  return tree_of(node).data;
}

int64_t conduit_node_as_int64(conduit_node* node) {
  int64_t value = 0;
  std::memcpy(&value, conduit_node_element_ptr(node, 0), sizeof value);
  return value;
}

double conduit_node_as_float64(conduit_node* node) {
  double value = 0;
  std::memcpy(&value, conduit_node_element_ptr(node, 0), sizeof value);
  return value;
}

conduit_index_t conduit_datatype_sizeof_index_t(void) {
  return sizeof(conduit_index_t);
}

conduit_index_t conduit_datatype_id(const conduit_datatype* type) {
  return tree_of(type).type;
}

conduit_index_t conduit_datatype_number_of_elements(const conduit_datatype* type) {
  return tree_of(type).count;
}

conduit_index_t conduit_datatype_offset(const conduit_datatype* type) {
  return tree_of(type).offset;
}

conduit_index_t conduit_datatype_stride(const conduit_datatype* type) {
  return tree_of(type).stride;
}

conduit_index_t conduit_datatype_element_bytes(const conduit_datatype* type) {
  return Conduit::bytes_of(tree_of(type).type);
}

int conduit_datatype_endianness_matches_machine(const conduit_datatype* type) {
  return tree_of(type).same_endianness;
}

void conduit_node_set_path_char8_str(conduit_node* node, const char* path, const char* text) {
  Tree::functions().set_path_char8_str(&tree_of(node), path, text);
}

#define INSITU_CONDUIT_TYPE(name, type)                                                            \
  void conduit_node_set_path_##name(conduit_node* node, const char* path, type value) {            \
    tree_of(node).make(path).set_copy(Conduit::name, &value, 1);                                   \
  }                                                                                                \
  void conduit_node_set_path_##name##_ptr(conduit_node* node, const char* path, type* data,        \
                                          conduit_index_t n) {                                     \
    tree_of(node).make(path).set_copy(Conduit::name, data, n);                                     \
  }                                                                                                \
  void conduit_node_set_path_external_##name##_ptr(conduit_node* node, const char* path,           \
                                                   type* data, conduit_index_t n) {                \
    tree_of(node).make(path).set_external(Conduit::name, data, n, 0, sizeof(type));                \
  }                                                                                                \
  void conduit_node_set_path_external_##name##_ptr_detailed(                                       \
      conduit_node* node, const char* path, type* data, conduit_index_t n, conduit_index_t offset, \
      conduit_index_t stride, conduit_index_t /*element_bytes*/, conduit_index_t endianness) {     \
    Tree& leaf = tree_of(node).make(path);                                                         \
    leaf.set_external(Conduit::name, data, n, offset, stride);                                     \
    leaf.same_endianness = endianness != 1; /* big */                                              \
  }
INSITU_CONDUIT_TYPES
#undef INSITU_CONDUIT_TYPE

enum catalyst_status catalyst_initialize(const conduit_node* parameters) {
  if (!implementation)
    if (const enum catalyst_status status = load(parameters); status != catalyst_status_ok) {
      implementation = nullptr;
      return status;
    }
  return implementation->initialize(parameters);
}

enum catalyst_status catalyst_execute(const conduit_node* parameters) {
  return implementation ? implementation->execute(parameters)
                        : catalyst_status_error_no_implementation;
}

enum catalyst_status catalyst_finalize(const conduit_node* parameters) {
  return implementation ? implementation->finalize(parameters)
                        : catalyst_status_error_no_implementation;
}

enum catalyst_status catalyst_about(conduit_node* parameters) {
  return implementation ? implementation->about(parameters)
                        : catalyst_status_error_no_implementation;
}

enum catalyst_status catalyst_results(conduit_node* parameters) {
  return implementation ? implementation->results(parameters)
                        : catalyst_status_error_no_implementation;
}

} // extern "C"
