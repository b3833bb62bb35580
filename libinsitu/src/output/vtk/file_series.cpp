#include "output/vtk/file_series.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>

#include "core/status.h"
#include "core/text.h"
#include "output/files/atomic_file.h"
#include "output/files/csv.h"
#include "output/vtk/xml_text.h"

namespace insitu::output {

namespace {

struct Entity {
  char character;
  std::string_view name;
};
constexpr Entity entities[] = {{'&', "&amp;"},  {'<', "&lt;"},   {'>', "&gt;"},
                               {'"', "&quot;"}, {'\n', "&#10;"}, {'\r', "&#13;"}};

std::string json_escape(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (const auto code = static_cast<unsigned char>(c); code < 0x20) {
      constexpr char digits[] = "0123456789abcdef";
      out += {'\\', 'u', '0', '0', digits[code >> 4], digits[code & 15]};
      continue;
    }
    if (c == '"' || c == '\\')
      out += '\\';
    out += c;
  }
  return out;
}

/// Of what json_escape() makes.
std::string json_unescape(std::string_view text) {
  std::string out;
  for (; !text.empty(); text.remove_prefix(1)) {
    if (text.front() == '\\' && text.size() > 1) {
      text.remove_prefix(1);
      if (text.front() == 'u' && text.size() >= 5) {
        int code = 0;
        std::from_chars(text.data() + 1, text.data() + 5, code, 16);
        out += char(code);
        text.remove_prefix(4);
        continue;
      }
    }
    out += text.front();
  }
  return out;
}

} // namespace

std::string xml_escape(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto entity = std::find_if(std::begin(entities), std::end(entities),
                                     [&](const Entity& e) { return e.character == c; });
    if (entity != std::end(entities))
      out += entity->name;
    else
      out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out;
}

std::string xml_unescape(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const auto entity = std::find_if(std::begin(entities), std::end(entities),
                                     [&](const Entity& e) { return text.starts_with(e.name); });
    const bool found = entity != std::end(entities);
    out += found ? entity->character : text.front();
    text.remove_prefix(found ? entity->name.size() : 1);
  }
  return out;
}

/// How an index is written: entries, a line each, between a head and a tail.
struct FileSeries::Form {
  std::string_view head, begin, middle, end, separator,
      tail; ///< of an entry: begin, time, middle,
            ///< file, end; separator before the next
  std::string (*escape)(std::string_view);
  std::string (*unescape)(std::string_view);

  /// False if the line is not one that add() writes.
  bool parse_entry(std::string_view line, double& time, std::string& file) const {
    if (line.ends_with(separator))
      line.remove_suffix(separator.size());
    if (!line.starts_with(begin) || !line.ends_with(end))
      return false;
    line.remove_prefix(begin.size());
    line.remove_suffix(end.size());
    const std::size_t at = line.find(middle);
    if (at == std::string_view::npos)
      return false;
    const std::from_chars_result read = std::from_chars(line.data(), line.data() + at, time);
    file = unescape(line.substr(at + middle.size()));
    return read.ec == std::errc() && read.ptr == line.data() + at;
  }
};

const FileSeries::Form& FileSeries::form_of(const std::string& path) {
  static constexpr Form pvd = {"<?xml version=\"1.0\"?>\n"
                               "<VTKFile type=\"Collection\" version=\"1.0\">\n"
                               " <Collection>\n",
                               "  <DataSet timestep=\"",
                               "\" part=\"0\" file=\"",
                               "\"/>",
                               "",
                               " </Collection>\n</VTKFile>\n",
                               xml_escape,
                               xml_unescape};
  static constexpr Form json = {"{\"file-series-version\": \"1.0\", \"files\": [\n",
                                "  {\"time\": ",
                                ", \"name\": \"",
                                "\"}",
                                ",",
                                "]}\n",
                                json_escape,
                                json_unescape};
  return path.ends_with(".pvd") ? pvd : json;
}

FileSeries::FileSeries(std::string path, bool resume, bool backward)
    : path_(std::move(path)), backward_(backward) {
  std::error_code error;
  if (!resume || !std::filesystem::exists(path_, error))
    return;
  const Form& form = form_of(path_);
  const std::optional<std::string> text = core::read_file(path_);
  if (!text)
    throw core::Error(INSITU_ERROR_FILE, "cannot read '" + path_ + "'");
  std::string_view rest = *text;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::string line(rest.substr(0, rest.find('\n')));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    double time = 0;
    std::string file;
    if (form.parse_entry(line, time, file)) {
      entries_.emplace_back(time, std::move(file));
    } else if (form.head.find(line) == std::string_view::npos &&
               form.tail.find(line) == std::string_view::npos) {
      throw core::Error(INSITU_ERROR_FILE, "cannot continue the series '" + path_ + "': line " +
                                               std::to_string(number) +
                                               " was not written by this library");
    }
  }
  resumed_ = entries_.size();
}

void FileSeries::add(double time, const std::string& file) {
  std::size_t kept = 0, resumed = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto& [when, name] = entries_[i];
    const bool beyond = i < resumed_ && (backward_ ? when < time : when > time);
    if (beyond || when == time || name == file)
      continue;
    resumed += i < resumed_;
    std::swap(entries_[kept++], entries_[i]);
  }
  entries_.resize(kept);
  resumed_ = resumed;
  entries_.emplace_back(time, file);
  const Form& form = form_of(path_);
  std::string text(form.head);
  for (const auto& [when, name] : entries_) {
    text += form.begin;
    append_number(text, when);
    text += form.middle;
    text += form.escape(name);
    text += form.end;
    text += name == entries_.back().second ? "" : form.separator;
    text += '\n';
  }
  text += form.tail;
  AtomicFile out(path_);
  out.write(text);
  out.commit();
}

} // namespace insitu::output
