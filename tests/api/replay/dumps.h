// Dumps as Catalyst's stub writes them, of the nodes that a host of our own hands over.
#pragma once

#include <cstdlib>
#include <cstring>

#include "../catalyst/nodes.h"
#include "replay.h"

/// Writes the leaves of a node one after the other, packed, and their schema beside them.
class DumpWriter {
public:
  DumpWriter(const TestNode& node, const std::string& file) {
    const std::string schema = schema_of(node.get());
    std::ofstream(file, std::ios::binary).write(bytes_.data(), std::streamsize(bytes_.size()));
    std::ofstream(file + "_json") << schema;
  }

private:
  std::string schema_of(conduit_node* node) {
    const conduit_index_t children = conduit_node_number_of_children(node);
    if (children == 0)
      return leaf(node);
    std::string out;
    for (conduit_index_t i = 0; i < children; ++i) {
      conduit_node* child = conduit_node_child(node, i);
      char* name = conduit_node_name(child);
      out += (i == 0 ? "\"" : ",\n\"") + std::string(name) + "\":" + schema_of(child);
      std::free(name);
    }
    return "{" + out + "}";
  }
  std::string leaf(conduit_node* node) {
    static const char* const types[] = {"empty",  "object",  "list",    "int8",     "int16",
                                        "int32",  "int64",   "uint8",   "uint16",   "uint32",
                                        "uint64", "float32", "float64", "char8_str"};
    const conduit_datatype* type = conduit_node_dtype(node);
    const conduit_index_t count = conduit_datatype_number_of_elements(type),
                          size = conduit_datatype_element_bytes(type);
    const std::string out =
        "{\"dtype\":\"" + std::string(types[conduit_datatype_id(type)]) +
        "\",\"number_of_elements\":" + std::to_string(count) +
        ",\"offset\":" + std::to_string(bytes_.size()) + ",\"stride\":" + std::to_string(size) +
        ",\"element_bytes\":" + std::to_string(size) + ",\"endianness\":\"little\"}";
    for (conduit_index_t i = 0; i < count; ++i) {
      const auto* from = static_cast<const char*>(conduit_node_element_ptr(node, i));
      bytes_.insert(bytes_.end(), from, from + size);
    }
    return out;
  }

  std::vector<char> bytes_;
};

/// Dumps of calls, in the test's folder.
struct DumpReplay : Replay {
  /// in: a folder within it, such as "one/".
  std::string dump_of(int call, int process, int processes, const std::string& in = "") const {
    return path(in + "execute_invc" + std::to_string(call) + "_params.conduit_bin." +
                std::to_string(processes) + "." + std::to_string(process));
  }
};
