#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Texts without streams, which take a lack of memory for the end of what they read, and cut what
/// they write.
namespace insitu::core {

/// Returns what a file holds; nothing where it cannot be read, and errno then says why.
std::optional<std::string> read_file(const std::string& path);

/// Takes a line off the text, without its end; nothing where none is left that has one.
inline std::optional<std::string_view> take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  if (end == text.npos)
    return std::nullopt;
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end + 1);
  return line;
}

/// Names hold any byte but 0, so lists of them go from process to process with one behind each.
inline void join(std::string& list, std::string_view name) {
  list.append(name).push_back('\0');
}
/// Returns the names of such a list.
inline std::vector<std::string> parted(std::string_view list) {
  std::vector<std::string> names;
  for (std::size_t end = 0; (end = list.find('\0')) != list.npos; list.remove_prefix(end + 1))
    names.emplace_back(list.substr(0, end));
  return names;
}

} // namespace insitu::core
