#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>

#include "core/status.h"
#include "output/files/atomic_file.h"
#include "output/files/csv.h"
#include "output/vtk/xml_text.h"
#include "output/vtk/xml_vtk.h"

namespace insitu::output {

namespace {

constexpr std::string_view head = "<?xml version=\"1.0\"?>\n"
                                  "<VTKFile type=\"Collection\" version=\"1.0\">\n"
                                  " <Collection>\n";
constexpr std::string_view tail = " </Collection>\n</VTKFile>\n";
constexpr std::string_view entry_begin = "  <DataSet timestep=\"";
constexpr std::string_view entry_middle = "\" part=\"0\" file=\"";
constexpr std::string_view entry_end = "\"/>";

struct Entity {
  char character;
  std::string_view name;
};
constexpr Entity entities[] = {{'&', "&amp;"},  {'<', "&lt;"},   {'>', "&gt;"},
                               {'"', "&quot;"}, {'\n', "&#10;"}, {'\r', "&#13;"}};

/// False if the line is not one that PvdSeries writes.
bool parse_entry(std::string_view line, double& time, std::string& file) {
  if (!line.starts_with(entry_begin) || !line.ends_with(entry_end))
    return false;
  line.remove_prefix(entry_begin.size());
  line.remove_suffix(entry_end.size());
  const std::size_t middle = line.find(entry_middle);
  if (middle == std::string_view::npos)
    return false;
  const std::from_chars_result end = std::from_chars(line.data(), line.data() + middle, time);
  file = xml_unescape(line.substr(middle + entry_middle.size()));
  return end.ec == std::errc() && end.ptr == line.data() + middle;
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

PvdSeries::PvdSeries(std::string path, bool resume, bool backward)
    : path_(std::move(path)), backward_(backward) {
  std::error_code error;
  if (!resume || !std::filesystem::exists(path_, error))
    return;
  std::ifstream in(path_);
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    double time = 0;
    std::string file;
    if (parse_entry(line, time, file)) {
      entries_.emplace_back(time, std::move(file));
    } else if (head.find(line) == std::string_view::npos &&
               tail.find(line) == std::string_view::npos) {
      throw core::Error(INSITU_ERROR_FILE, "cannot continue the series '" + path_ + "': line " +
                                               std::to_string(number) +
                                               " was not written by this library");
    }
  }
  if (in.bad() || !in.eof())
    throw core::Error(INSITU_ERROR_FILE, "cannot read '" + path_ + "'");
  resumed_ = entries_.size();
}

void PvdSeries::add(double time, const std::string& file) {
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
  std::string text(head);
  for (const auto& [when, name] : entries_) {
    text += entry_begin;
    append_number(text, when);
    text += entry_middle;
    text += xml_escape(name);
    text += entry_end;
    text += '\n';
  }
  text += tail;
  AtomicFile out(path_);
  out.write(text);
  out.commit();
}

} // namespace insitu::output
