#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/status.h"
#include "core/text.h"
#include "render/surface/triangle_mesh.h"

namespace insitu::render {

namespace {

constexpr std::size_t header_size = 84, record_size = 50; // of a binary file
/// Their corners are numbered with 32 bits.
constexpr std::size_t most_triangles = std::numeric_limits<std::uint32_t>::max() / 3;

[[noreturn]] void fail(const std::string& path, const std::string& message) {
  throw core::Error(INSITU_ERROR_SCENE, "body " + path + ": " + message);
}

std::string read_all(const std::string& path) {
  std::optional<std::string> bytes = core::read_file(path);
  if (!bytes)
    throw core::Error(INSITU_ERROR_FILE, "cannot read '" + path + "': " + std::strerror(errno));
  return std::move(*bytes);
}

std::uint32_t load_uint32(const char* p) {
  unsigned char b[4];
  std::memcpy(b, p, 4);
  return b[0] | std::uint32_t(b[1]) << 8 | std::uint32_t(b[2]) << 16 | std::uint32_t(b[3]) << 24;
}

/// Little-endian: a header of 80 bytes, the number of triangles, then for each its normal, its
/// corners as floats, and two bytes.
void read_binary(const std::string& bytes, const std::string& path, TriangleList& list) {
  const std::size_t count = (bytes.size() - header_size) / record_size;
  if (count > most_triangles)
    fail(path, std::to_string(count) + " triangles, more than " + std::to_string(most_triangles));
  list.corners.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const char* p = bytes.data() + header_size + i * record_size + 12;
    for (int k = 0; k < 3; ++k) {
      math::Vec3d x;
      for (int a = 0; a < 3; ++a, p += 4)
        x[a] = double(std::bit_cast<float>(load_uint32(p)));
      if (!std::isfinite(x.x) || !std::isfinite(x.y) || !std::isfinite(x.z))
        fail(path, "a corner of triangle " + std::to_string(i) + " is not finite");
      list.corners.push_back(x);
    }
  }
}

/// The words of an ASCII file, with their lines.
class Words {
public:
  Words(const std::string& text, const std::string& path)
      : at_(text.data()), end_(text.data() + text.size()), path_(path) {}

  /// Empty at the end.
  std::string_view next() {
    while (at_ != end_ && is_space(*at_))
      line_ += *at_++ == '\n';
    const char* from = at_;
    while (at_ != end_ && !is_space(*at_))
      ++at_;
    return {from, std::size_t(at_ - from)};
  }
  void skip_line() {
    while (at_ != end_ && *at_ != '\n')
      ++at_;
  }
  void expect(std::initializer_list<std::string_view> words) {
    for (const std::string_view word : words)
      if (const std::string_view found = next(); found != word)
        refuse("'" + std::string(word) + "'", found);
  }
  double number() {
    const std::string_view word = next();
    double value = 0;
    const char* from = word.data() + (!word.empty() && word[0] == '+');
    const auto [rest, error] = std::from_chars(from, word.data() + word.size(), value);
    if (error != std::errc() || rest != word.data() + word.size() || !std::isfinite(value))
      refuse("a number", word);
    return value;
  }
  [[noreturn]] void refuse(const std::string& expected, std::string_view found) const {
    constexpr std::size_t most_shown = 40;
    throw core::Error(INSITU_ERROR_SCENE,
                      path_ + ":" + std::to_string(line_) + ": " + expected + " expected, " +
                          (found.empty() ? std::string("the end of the file")
                                         : "'" + std::string(found.substr(0, most_shown)) + "'") +
                          " found");
  }

private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
  const char *at_, *end_;
  const std::string& path_;
  int line_ = 1;
};

void read_ascii(const std::string& text, const std::string& path, TriangleList& list) {
  Words words(text, path);
  words.expect({"solid"});
  words.skip_line(); // its name
  while (true) {
    const std::string_view word = words.next();
    if (word == "endsolid") {
      words.skip_line();
      const std::string_view more = words.next(); // files with several solids
      if (more.empty())
        return;
      if (more != "solid")
        words.refuse("'solid' or the end of the file", more);
      words.skip_line();
      continue;
    }
    if (word != "facet")
      words.refuse("'facet' or 'endsolid'", word);
    words.expect({"normal"});
    for (int a = 0; a < 3; ++a)
      words.next(); // known from the corners; some writers put nan
    words.expect({"outer", "loop"});
    for (int k = 0; k < 3; ++k) {
      words.expect({"vertex"});
      math::Vec3d x;
      for (int a = 0; a < 3; ++a)
        x[a] = words.number();
      list.corners.push_back(x);
    }
    words.expect({"endloop", "endfacet"});
    if (list.corners.size() / 3 > most_triangles)
      fail(path, "more than " + std::to_string(most_triangles) + " triangles");
  }
}

} // namespace

TriangleList read_stl(const std::string& path,
                      const core::CountedAllocator<math::Vec3d>& allocator) {
  const std::string bytes = read_all(path);
  TriangleList list{path, core::CountedVector<math::Vec3d>(allocator)};
  const bool says_solid = bytes.compare(0, 5, "solid") == 0;
  // Binary files may begin with "solid" too, so the size that the count implies is asked first.
  const std::uint64_t stated =
      bytes.size() >= header_size
          ? header_size + record_size * std::uint64_t(load_uint32(bytes.data() + 80))
          : 0;
  if (stated == bytes.size() && bytes.size() >= header_size)
    read_binary(bytes, path, list);
  else if (says_solid)
    read_ascii(bytes, path, list);
  else if (bytes.size() < header_size)
    fail(path, "no STL: it neither begins with 'solid' nor has the 84 bytes of a binary header");
  else
    fail(path, "no STL: it does not begin with 'solid', and as a binary file of " +
                   std::to_string(load_uint32(bytes.data() + 80)) + " triangles it would have " +
                   std::to_string(stated) + " bytes, not " + std::to_string(bytes.size()));
  if (list.corners.empty())
    fail(path, "no triangle in it");
  return list;
}

} // namespace insitu::render
