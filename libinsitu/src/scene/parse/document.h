#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scene/parse/problems.h"

namespace insitu::scene {

struct YamlNode;
using YamlNodePtr = std::shared_ptr<const YamlNode>;

/// One node of a YAML document. Aliases are shared nodes, so the graph has no cycles but may have
/// common parts.
struct YamlNode {
  enum class Kind { nothing, scalar, list, map };
  struct Entry {
    std::string key;
    int line;
    YamlNodePtr value;
  };
  Kind kind = Kind::nothing;
  bool quoted = false; ///< of a scalar: written within quotes, or as a block, so always a text
  int line = 0;        ///< counted from 1
  std::string text;    ///< of a scalar
  std::vector<YamlNodePtr> items; ///< of a list
  std::vector<Entry> entries;     ///< of a map, in the order of the text; keys may repeat
  std::size_t size = 1;           ///< nodes below and with this one, aliases expanded
};

/// Limits that no scene needs to pass, and that keep hostile ones from exhausting stack or memory.
constexpr std::size_t largest_document = 1 << 20; ///< bytes
constexpr int deepest_document = 24;              ///< lists and maps within each other
constexpr std::size_t most_nodes = 1 << 20;       ///< aliases expanded

/// Reads the one YAML document of `text`. Throws core::Error(INSITU_ERROR_SCENE) with "file:line:
/// ..." for text that is not UTF-8 YAML, for an empty or a second document, tags, aliases of an
/// enclosing node, keys that are not scalars, and for what goes beyond the limits above.
YamlNodePtr read_document(std::string_view text, const std::string& file);

/// All keys and scalars, one line each.
std::string words_of(const YamlNode& root);

} // namespace insitu::scene
