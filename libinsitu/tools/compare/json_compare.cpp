#include "compare/json_compare.h"

#include <algorithm>
#include <limits>
#include <map>
#include <yaml-cpp/yaml.h>

#include "core/status.h"

namespace insitu::compare {

namespace {

/// A value that is not a list or an object; an empty one of those counts as a value too.
struct Leaf {
  enum Kind { text, number, other } kind = other;
  std::string as_text;
  double value = 0;
  std::size_t order = 0;
  std::string key;
};

using Leaves = std::map<std::string, Leaf>;

/// YAML, which contains JSON, forbids tabs where JSON allows them: outside strings.
std::string without_tabs(std::string text) {
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (in_string && text[i] == '\\')
      ++i;
    else if (text[i] == '"')
      in_string = !in_string;
    else if (text[i] == '\t' && !in_string)
      text[i] = ' ';
  return text;
}

bool listed(const std::vector<std::string>& names, const std::string& path,
            const std::string& key) {
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return name == path || name == key; });
}

Leaf make_leaf(const YAML::Node& node) {
  Leaf leaf;
  if (node.IsNull()) {
    leaf.kind = Leaf::number;
    leaf.as_text = "null";
    leaf.value = std::numeric_limits<double>::quiet_NaN();
  } else if (node.IsMap() || node.IsSequence()) {
    leaf.as_text = node.IsMap() ? "{}" : "[]";
  } else {
    leaf.as_text = node.Scalar();
    const bool quoted = node.Tag() == "!";
    const bool number = !quoted && !leaf.as_text.empty() && parse_number(leaf.as_text, leaf.value);
    leaf.kind = quoted ? Leaf::text : number ? Leaf::number : Leaf::other;
  }
  return leaf;
}

void flatten(const YAML::Node& node, const std::string& path, const std::string& key,
             const std::vector<std::string>& ignored, Leaves& leaves) {
  if (listed(ignored, path, key))
    return;
  if (node.IsMap() && node.size() > 0) {
    for (const auto& item : node) {
      const std::string name = item.first.Scalar();
      flatten(item.second, path.empty() ? name : path + "." + name, name, ignored, leaves);
    }
  } else if (node.IsSequence() && node.size() > 0) {
    std::size_t i = 0;
    for (const auto& item : node)
      flatten(item, path + "[" + std::to_string(i++) + "]", key, ignored, leaves);
  } else {
    Leaf leaf = make_leaf(node);
    leaf.order = leaves.size();
    leaf.key = key;
    leaves.emplace(path, std::move(leaf));
  }
}

Leaves parse(const std::string& text, const std::string& name, const JsonOptions& options) {
  try {
    const YAML::Node root = YAML::Load(without_tabs(text));
    if (!root.IsMap() && !root.IsSequence())
      throw core::Error(INSITU_ERROR_FILE, "'" + name + "' is neither a JSON object nor a list");
    Leaves leaves;
    flatten(root, "", "", options.ignored, leaves);
    return leaves;
  } catch (const YAML::Exception& error) {
    throw core::Error(INSITU_ERROR_FILE, "'" + name + "' line " +
                                             std::to_string(error.mark.line + 1) +
                                             ": cannot be read as JSON: " + error.msg);
  }
}

Tolerance tolerance_for(const std::string& path, const std::string& key,
                        const JsonOptions& options) {
  Tolerance tolerance = options.tolerance;
  bool by_path = false;
  for (const NamedTolerance& named : options.keys) {
    if (named.name == path || (named.name == key && !by_path)) {
      tolerance = named.tolerance;
      by_path = named.name == path;
    }
  }
  return tolerance;
}

struct Finding {
  std::size_t order;
  std::string line;
};

std::string shown(const Leaf& leaf) {
  return leaf.kind == Leaf::text ? "\"" + leaf.as_text + "\"" : leaf.as_text;
}

} // namespace

Verdict compare_json(const std::string& a, const std::string& name_a, const std::string& b,
                     const std::string& name_b, const JsonOptions& options) {
  const Leaves in_a = parse(a, name_a, options), in_b = parse(b, name_b, options);
  std::vector<Finding> findings;
  double worst = -1;
  std::string worst_path;
  for (const auto& [path, leaf] : in_a) {
    const auto found = in_b.find(path);
    if (found == in_b.end()) {
      findings.push_back(
          {leaf.order, path + ": " + shown(leaf) + " is missing in the second file"});
      continue;
    }
    const Leaf& other = found->second;
    if (leaf.kind == Leaf::number && other.kind == Leaf::number) {
      const Tolerance tolerance = tolerance_for(path, leaf.key, options);
      if (leaf.as_text == other.as_text || same_number(leaf.value, other.value, tolerance))
        continue;
      findings.push_back({leaf.order, path + ": " + change_text(leaf.value, other.value)});
      const double relative = excess(leaf.value, other.value, {1, 0});
      if (relative > worst) {
        worst = relative;
        worst_path = path;
      }
    } else if (leaf.kind != other.kind || leaf.as_text != other.as_text) {
      findings.push_back({leaf.order, path + ": " + shown(leaf) + " -> " + shown(other)});
    }
  }
  for (const auto& [path, leaf] : in_b) {
    if (in_a.find(path) == in_a.end()) {
      findings.push_back(
          {in_a.size() + leaf.order, path + ": " + shown(leaf) + " is missing in the first file"});
    }
  }
  std::sort(findings.begin(), findings.end(),
            [](const Finding& x, const Finding& y) { return x.order < y.order; });

  Verdict verdict;
  constexpr std::size_t most = 20;
  for (std::size_t i = 0; i < std::min(findings.size(), most); ++i)
    verdict.differ(findings[i].line);
  if (findings.size() > most)
    verdict.differ("and " + count_text(findings.size() - most, "more value"));
  if (findings.size() > 1 && worst > 0)
    verdict.differ("relatively, " + worst_path + " moved most");
  if (verdict.same)
    verdict.lines.push_back("same: " + count_text(in_a.size(), "value"));
  return verdict;
}

} // namespace insitu::compare
