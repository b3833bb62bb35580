#include "dump_arrays.h"

#include <cstring>

namespace insitu_replay {

using insitu::blueprint::Conduit;
using insitu::catalyst::Tree;

bool DumpArrays::take(Tree& tree, std::size_t process) {
  return take(tree, std::to_string(process));
}

bool DumpArrays::take(Tree& tree, const std::string& path) {
  bool all = true;
  for (std::size_t i = 0; i < tree.children.size(); ++i) // names may hold slashes, or be none
    all = take(*tree.children[i], path + "/" + std::to_string(i) + ":" + tree.children[i]->name) &&
          all;
  const std::int64_t bytes = Conduit::bytes_of(tree.type);
  if (bytes == 0 || tree.count <= 0)
    return all;
  if (tree.stride != bytes)
    return false;
  const auto size = static_cast<std::size_t>(tree.count * bytes);
  Array& array = arrays_[path];
  if (array.type != tree.type || array.count != tree.count) {
    if (!array.bytes.empty())
      replaced_.push_back(std::move(array));
    array = {tree.type, tree.count, std::vector<char>(size)};
  }
  std::memcpy(array.bytes.data(), tree.data + tree.offset, size);
  const bool same_endianness = tree.same_endianness;
  tree.set_external(tree.type, array.bytes.data(), tree.count, 0, bytes);
  tree.same_endianness = same_endianness;
  return all;
}

} // namespace insitu_replay
