// A tree of Conduit's as a host may give it: whatever its bytes say, attaching it ends in a status
// with a message, never in a crash, and nothing is read outside the leaves. Input is a good mesh of
// Blueprint's, chosen by the first byte, then changes of its nodes, a few bytes each.
#include <string>
#include <vector>

#include "blueprint/attachment.h"
#include "catalyst/loader/tree.h"
#include "promises.h"

namespace {

using fuzz::Bytes;
using fuzz::require;
using insitu::blueprint::Attachment;
using insitu::blueprint::Conduit;
using insitu::blueprint::Node;
using insitu::catalyst::Tree;

void text(Tree& tree, const std::string& path, const char* value) {
  Tree::functions().set_path_char8_str(&tree, path.c_str(), value);
}

void numbers(Tree& tree, const std::string& path, const std::vector<double>& values) {
  tree.make(path).set_copy(Conduit::float64, values.data(), std::int64_t(values.size()));
}

void integers(Tree& tree, const std::string& path, const std::vector<std::int32_t>& values) {
  tree.make(path).set_copy(Conduit::int32, values.data(), std::int64_t(values.size()));
}

constexpr const char* kinds[] = {"uniform",    "rectilinear", "structured", "hex",   "mixed",
                                 "polyhedral", "adaptive",    "polygonal",  "among", "list"};

/// Two cubes side by side, in one of the ways of Blueprint.
void make(Tree& tree, unsigned kind) {
  const std::string t = "topologies/t/", c = "coordsets/c/", e = t + "elements/";
  text(tree, t + "coordset", "c");
  const bool block = kind == 0 || kind == 6;
  text(tree, c + "type", block ? "uniform" : kind == 1 ? "rectilinear" : "explicit");
  text(tree, t + "type", block ? "uniform" : kind < 3 ? kinds[kind] : "unstructured");
  if (block)
    for (const char* n : {"i", "j", "k"})
      integers(tree, c + "dims/" + n, {*n == 'i' ? 3 : 2});
  if (kind == 1)
    for (const char* a : {"x", "y", "z"})
      numbers(tree, c + "values/" + a, *a == 'x' ? std::vector{0., 1., 2.} : std::vector{0., 1.});
  if (kind == 7) { // a hexagon and a square
    text(tree, e + "shape", "polygonal");
    integers(tree, e + "connectivity", {0, 1, 2, 5, 4, 3, 3, 4, 7, 6});
    integers(tree, e + "sizes", {6, 4});
    integers(tree, e + "offsets", {0, 6});
    numbers(tree, c + "values/x", {0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2});
    numbers(tree, c + "values/y", {0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3});
  }
  if (kind >= 2 && kind != 6 && kind != 7) {
    numbers(tree, c + "values/x", {0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2});
    numbers(tree, c + "values/y", {0, 0, 0, 1, 1, 1, 0, 0, 0, 1, 1, 1});
    numbers(tree, c + "values/z", {0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1});
  }
  if (kind == 2)
    for (const char* n : {"i", "j", "k"})
      integers(tree, e + "dims/" + n, {*n == 'i' ? 2 : 1});
  const std::vector<std::int32_t> hexahedra = {0, 1, 4, 3, 6, 7, 10, 9, 1, 2, 5, 4, 7, 8, 11, 10};
  if (kind == 8) { // a cube by its faces beside a hexahedron
    text(tree, e + "shape", "mixed");
    integers(tree, e + "shape_map/hex", {12});
    integers(tree, e + "shape_map/polyhedral", {42});
    integers(tree, e + "shapes", {12, 42});
    integers(tree, e + "sizes", {8, 6});
    integers(tree, e + "connectivity", {0, 1, 4, 3, 6, 7, 10, 9, 0, 1, 2, 3, 4, 5});
    text(tree, t + "subelements/shape", "quad");
    integers(tree, t + "subelements/connectivity",
             {1, 4, 10, 7, 1, 2, 5, 4, 7, 8, 11, 10, 1, 2, 8, 7, 4, 5, 11, 10, 2, 5, 11, 8});
  }
  if (kind == 9)
    for (const int i : {0, 1}) {
      const std::string chunk = e + (i == 0 ? "a/" : "b/");
      text(tree, chunk + "shape", "hex");
      integers(tree, chunk + "connectivity",
               {hexahedra.begin() + 8 * i, hexahedra.begin() + 8 * (i + 1)});
    }
  if (kind == 3 || kind == 4) {
    text(tree, e + "shape", kinds[kind]);
    integers(tree, e + "connectivity", hexahedra);
  }
  if (kind == 4) {
    integers(tree, e + "shape_map/hex", {12});
    integers(tree, e + "shape_map/quad", {9});
    integers(tree, e + "shapes", {12, 12});
    integers(tree, e + "sizes", {8, 8});
  }
  if (kind == 5) {
    text(tree, e + "shape", "polyhedral");
    text(tree, t + "subelements/shape", "polygonal");
    integers(tree, t + "subelements/connectivity",
             {0,  1, 4, 3, 6, 7, 10, 9, 0,  1,  7, 6, 3, 4, 10, 9, 0,  3,  9, 6, 1,  4,
              10, 7, 1, 2, 5, 4, 7,  8, 11, 10, 1, 2, 8, 7, 4,  5, 11, 10, 2, 5, 11, 8});
    integers(tree, t + "subelements/sizes", {4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4});
    integers(tree, e + "connectivity", {0, 1, 2, 3, 4, 5, 5, 6, 7, 8, 9, 10});
    integers(tree, e + "sizes", {6, 6});
    integers(tree, t + "subelements/offsets", {0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40});
    integers(tree, e + "offsets", {0, 6, 12});
  }
  if (kind == 6) {
    integers(tree, "state/level", {2});
    integers(tree, "state/domain_id", {5});
    for (const char* partner : {"parent", "child"}) {
      const std::string window = std::string("nestsets/n/windows/") + partner + "/";
      text(tree, window + "domain_type", partner);
      integers(tree, window + "domain_id", {4});
      for (const char* n : {"i", "j", "k"})
        integers(tree, window + "ratio/" + n, {2});
    }
  }
  text(tree, "fields/f/association", kind == 6 ? "element" : "vertex");
  numbers(tree, "fields/f/values", std::vector<double>(kind == 6 ? 2 : 12, 0.5));
  text(tree, "fields/velocity/association", "element");
  for (const char* a : {"u", "v", "w"})
    numbers(tree, std::string("fields/velocity/values/") + a, {1, 2});
  text(tree, "fields/ascent_ghosts/association", "element");
  integers(tree, "fields/ascent_ghosts/values", {0, 0});
}

Tree& some_node(Tree& tree, Bytes& in) {
  Tree* at = &tree;
  for (unsigned depth = 1 + in.below(6); depth > 0 && !at->children.empty(); --depth)
    at = at->children[in.below(unsigned(at->children.size()))].get();
  return *at;
}

void change(Tree& tree, Bytes& in) {
  Tree& node = some_node(tree, in);
  switch (in.below(6)) {
  case 0: // a child goes
    if (!node.children.empty())
      node.children.erase(node.children.begin() + in.below(unsigned(node.children.size())));
    break;
  case 1: { // other text
    constexpr char texts[10][11] = {"uniform", "hex", "mixed", "element",   "vertex",
                                    "c",       "",    "t",     "polygonal", "polyhedral"};
    node.set_copy(Conduit::char8_str, texts[in.below(10)], 11);
    node.own.back() = '\0';
    break;
  }
  case 2: { // other numbers, of any type
    const auto type = Conduit::TypeId(Conduit::int8 + in.below(10));
    std::vector<std::int64_t> values;
    for (unsigned i = in.below(24); i > 0; --i)
      values.push_back(in.one_in(4) ? std::int64_t(in.byte()) << 56 : in.below(16));
    node.set_copy(type, values.data(), std::int64_t(values.size()));
    break;
  }
  case 3: // one number changes
    if (node.count > 0 && !node.own.empty())
      node.own[in.below(unsigned(node.own.size()))] = char(in.byte());
    break;
  case 4: // fewer items, or items further apart
    node.count /= 1 + in.below(3);
    node.stride *= node.count > 0 && in.one_in(2) ? 0 : 1;
    break;
  default: // offsets and strides
    integers(node, in.one_in(2) ? "offsets" : "strides",
             {std::int32_t(in.byte()) - 64, std::int32_t(in.byte()), std::int32_t(in.byte())});
  }
}

/// Whether the tree was taken; false: it was refused with a message.
bool attach(Attachment& attachment, Tree& tree, bool adaptive) {
  try {
    attachment.update(Node(Tree::functions(), &tree, "mesh"), {"", false, adaptive, {}});
    return true;
  } catch (const insitu::Error& e) {
    require(e.status() != INSITU_OK && *e.what(), "a status and a message");
    return false;
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  Tree tree; // which outlives the session that reads it
  const unsigned kind = in.below(10);
  make(tree, kind);
  const fuzz::Session session;
  Attachment attachment(session.mesh);
  for (int round = 0; round < 3; ++round) {
    insitu_commit_report report;
    const bool attached = attach(attachment, tree, kind == 6);
    const bool committed = fuzz::commit(session.mesh, report);
    require(attached || !committed, "a mesh that was not given is not committed");
    if (committed && kind != 5 && kind != 8)
      fuzz::ask(in, session.mesh, std::max<std::int64_t>(report.cells, 1));
    for (unsigned n = in.below(4); n > 0; --n)
      change(tree, in);
  }
  return 0;
}
