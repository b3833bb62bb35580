#include "scene/parse/document.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>
#include <unordered_map>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "core/status.h"

namespace insitu::scene {
namespace {

[[noreturn]] void fail(const std::string& file, int line, const std::string& message) {
  Problems problems(file);
  problems.add(line, message);
  problems.throw_if_any();
  std::abort(); // not reached: there is a problem
}

/// Builds the nodes from the parser's events. Unlike yaml-cpp's own tree this keeps repeated keys,
/// shares aliases, and stops the parser's recursion at deepest_document.
class Builder final : public YAML::EventHandler {
public:
  explicit Builder(const std::string& file) : file_(file) {}

  YamlNodePtr root() const { return root_; }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    complete(make(YamlNode::Kind::nothing, mark), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) {
      fail(file_, mark.line + 1, "an alias refers to a node that contains it");
    }
    if (!stack_.empty() && awaits_key()) {
      fail(file_, mark.line + 1, "an alias cannot be a key");
    }
    attach(found->second);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    check_tag(mark, tag);
    auto node = make(YamlNode::Kind::scalar, mark);
    node->text = value;
    node->quoted = tag == "!";
    if (!stack_.empty() && awaits_key()) {
      if (anchor != 0) {
        fail(file_, mark.line + 1, "key " + quote(value) + " has an anchor");
      }
      stack_.back().node->entries.push_back({value, node->line, nullptr});
      return;
    }
    complete(std::move(node), anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::list, mark, tag, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(YamlNode::Kind::map, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

private:
  struct Open {
    std::shared_ptr<YamlNode> node;
    YAML::anchor_t anchor;
  };

  std::shared_ptr<YamlNode> make(YamlNode::Kind kind, const YAML::Mark& mark) const {
    auto node = std::make_shared<YamlNode>();
    node->kind = kind;
    node->line = mark.line + 1;
    return node;
  }

  /// In a map every second node is a key: the last entry then has its value.
  bool awaits_key() const {
    const YamlNode& node = *stack_.back().node;
    return node.kind == YamlNode::Kind::map &&
           (node.entries.empty() || node.entries.back().value != nullptr);
  }

  void check_tag(const YAML::Mark& mark, const std::string& tag) const {
    // "?" and "!" are what the parser gives plain and quoted nodes without a tag.
    if (!tag.empty() && tag != "?" && tag != "!") {
      fail(file_, mark.line + 1, "the tag " + quote(tag) + " is not supported; leave it out");
    }
  }

  void open(YamlNode::Kind kind, const YAML::Mark& mark, const std::string& tag,
            YAML::anchor_t anchor) {
    check_tag(mark, tag);
    if (!stack_.empty() && awaits_key()) {
      fail(file_, mark.line + 1,
           "a list or map stands where a key should; is a ']', '}' or quotation mark missing?");
    }
    if (static_cast<int>(stack_.size()) >= deepest_document) {
      fail(file_, mark.line + 1,
           "more than " + std::to_string(deepest_document) + " lists and maps within each other");
    }
    stack_.push_back({make(kind, mark), anchor});
  }

  void close() {
    Open done = std::move(stack_.back());
    stack_.pop_back();
    complete(std::move(done.node), done.anchor);
  }

  void complete(YamlNodePtr node, YAML::anchor_t anchor) {
    if (anchor != 0) {
      anchors_[anchor] = node;
    }
    if (!stack_.empty() && awaits_key()) {
      fail(file_, node->line, "a key is missing before ':'");
    }
    attach(std::move(node));
  }

  void attach(YamlNodePtr node) {
    if (stack_.empty()) {
      root_ = std::move(node);
      return;
    }
    YamlNode& parent = *stack_.back().node;
    parent.size += node->size;
    if (parent.size > most_nodes) {
      fail(file_, node->line,
           "the aliases expand to more than " + std::to_string(most_nodes) + " values");
    }
    if (parent.kind == YamlNode::Kind::map) {
      parent.entries.back().value = std::move(node);
    } else {
      parent.items.push_back(std::move(node));
    }
  }

  const std::string& file_;
  std::vector<Open> stack_;
  std::unordered_map<YAML::anchor_t, YamlNodePtr> anchors_;
  YamlNodePtr root_;
};

/// Finds what the parser would take for something else or explain badly.
void check_text(std::string_view text, const std::string& file) {
  if (text.size() > largest_document) {
    fail(file, 0,
         "the scene has " + std::to_string(text.size()) + " bytes, more than " +
             std::to_string(largest_document) + "; keep lists of points in a file of their own");
  }
  int line = 1;
  bool indentation = true;
  bool tab = false;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\n') {
      ++line;
      indentation = true;
      tab = false;
    } else if ((byte < 0x20 && c != '\t' && c != '\r') || byte == 0x7F) {
      fail(file, line, "byte " + std::to_string(byte) + " found; the scene must be text in UTF-8");
    } else if (indentation && (c == ' ' || c == '\t')) {
      tab = tab || c == '\t';
    } else if (indentation && c != '\r') {
      if (tab && c != '#') {
        fail(file, line, "the indentation has a tab; YAML takes spaces only");
      }
      indentation = false;
    }
  }
}

} // namespace

std::string words_of(const YamlNode& root) {
  std::string words;
  std::set<const YamlNode*> seen; // aliases are shared
  const auto add = [&](const auto& self, const YamlNode& node) -> void {
    if (!seen.insert(&node).second)
      return;
    words += node.text + "\n";
    for (const YamlNodePtr& item : node.items)
      self(self, *item);
    for (const YamlNode::Entry& entry : node.entries) {
      words += entry.key + "\n";
      self(self, *entry.value);
    }
  };
  add(add, root);
  return words;
}

YamlNodePtr read_document(std::string_view text, const std::string& file) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") {
    text.remove_prefix(3); // the byte-order mark some editors write
  }
  check_text(text, file);
  Builder builder(file);
  try {
    // The parser takes the end of the text for the end of a quotation, but not the end of the
    // document.
    std::istringstream stream{std::string(text) + "\n...\n"};
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder) || builder.root() == nullptr ||
        builder.root()->kind == YamlNode::Kind::nothing) {
      fail(file, 0, "the scene is empty; it begins with 'insitu: 1'");
    }
    Builder second(file);
    if (parser.HandleNextDocument(second)) {
      fail(file, second.root() != nullptr ? second.root()->line : 0,
           "a second document begins here; a scene is one document");
    }
  } catch (const YAML::Exception& error) {
    const int line = error.mark.is_null() ? 0 : error.mark.line + 1;
    const int lines = 1 + static_cast<int>(std::count(text.begin(), text.end(), '\n'));
    if (line > lines) {
      fail(file, lines, "not valid YAML: the text ends within a quotation, list or map");
    }
    fail(file, line, "not valid YAML: " + error.msg);
  }
  return builder.root();
}

} // namespace insitu::scene
