#include "output/page/run_page.h"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>

#include "output/files/atomic_file.h"

namespace insitu::output {

extern const std::string_view run_page_html; // from the files in page/, by CMake

namespace {

constexpr std::string_view header =
    "var insitu = []; // written by libinsitu for index.html, an entry a line\n";
constexpr std::string_view known_header = "var insitu = ";
constexpr std::string_view generator = "<meta name=\"generator\" content=\"libinsitu\">";
constexpr std::string_view line_begin = "insitu.push(", unfinished_begin = "//situ.push(";
static_assert(line_begin.size() == unfinished_begin.size());

std::optional<std::int64_t> cycle_of(std::string_view line) {
  constexpr std::string_view key = "{\"cycle\":";
  if ((!line.starts_with(line_begin) && !line.starts_with(unfinished_begin)) ||
      !line.substr(line_begin.size()).starts_with(key))
    return std::nullopt;
  line.remove_prefix(line_begin.size() + key.size());
  std::int64_t cycle = 0;
  const auto parsed = std::from_chars(line.data(), line.data() + line.size(), cycle);
  return parsed.ec == std::errc() ? std::optional(cycle) : std::nullopt;
}

/// The path, if the file is absent, empty or this library's: a marker stands in its beginning, cut
/// short perhaps.
std::string ours(const std::string& folder, const char* name, std::string_view marker) {
  const std::string path = (std::filesystem::path(folder) / name).string();
  std::ifstream in(path, std::ios::binary);
  std::string begin(1024, '\0');
  in.read(begin.data(), std::streamsize(begin.size()));
  begin.resize(std::size_t(in.gcount()));
  if (begin.find(marker) == std::string::npos && !marker.starts_with(begin)) {
    throw core::Error(INSITU_ERROR_FILE, "cannot write '" + path +
                                             "': the file that is there is not this library's; "
                                             "move it away, or say 'page: false' in the scene");
  }
  return path;
}

} // namespace

RunPage::RunPage(const std::string& folder, std::int64_t from)
    : data_(ours(folder, data_name, known_header)) {
  AtomicFile page(ours(folder, page_name, generator));
  page.write(run_page_html);
  page.commit();
  // Entries of another version could not be read.
  if (!data_.cut_from(from, cycle_of) || data_.first_line() != header) {
    data_.clear();
    data_.append(header);
  }
}

void RunPage::add(std::string_view entry) {
  std::string line(unfinished_begin);
  line += entry;
  line += ");\n";
  const std::int64_t at = data_.size();
  data_.append(line);
  data_.replace(at, line_begin.substr(0, 2));
  last_ = at;
}

void RunPage::take_back() {
  if (last_ > 0)
    data_.cut(last_, "take back the last entry of");
  last_ = 0;
}

} // namespace insitu::output
